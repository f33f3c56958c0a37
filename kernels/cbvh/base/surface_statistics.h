// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Statistics of built surfaces. Outside of CBVH_ISA, because all ISAs share them. */

#include <algorithm>
#include <cstddef>
#include <limits>

namespace embree::cbvh {
/*! RTCCompressionStatistics without structSize; the public header defines the members. Floats are world units. */
struct CompressionStatistics {
  static const unsigned noPrimitive = ~0u; //!< RTC_INVALID_GEOMETRY_ID

  size_t topLevelBytes = 0; //!< BVH over blocks and grids
  size_t headerBytes = 0;
  size_t nodeBytes = 0;         //!< compressed inner nodes
  size_t leafBytes = 0;         //!< heights (cLEAF), vertices (cGRID, cVERT)
  size_t uncompressedBytes = 0; //!< grids of numUncompressedQuads
  size_t numBlocks = 0;
  size_t numQuads = 0;             //!< quads in blocks
  size_t numUncompressedQuads = 0; //!< traced by Embree's GRID
  size_t numInvalidQuads = 0;      //!< left out: a vertex is not finite, or an index is out of range
  size_t numAffineBlocks = 0;      //!< with an affine frame, where no projective frame was possible
  size_t numSolidLeaves = 0;       //!< cLEAF: leaves whose box is the surface
  size_t numRawBlocks = 0;         //!< cVERT: blocks that store floats
  size_t numFallbackQuads = 0;     //!< cLEAF: quads of faces stored as cVERT
  size_t numFlippedQuads = 0;      //!< the stored normal differs from the evaluated one by over 90 degrees
  size_t numMeshQuads = 0;         //!< in blocks: quads of quad meshes, pairs of triangles
  size_t numIrregularQuads = 0;    //!< of these, in no grid of 4 x 4 quads or more
  size_t numMovingQuads = 0;       //!< quads with several time steps
  size_t motionBytes = 0;          //!< of leafBytes, for time steps after the first
  /*! The first primitive with invalid quads. noPrimitive: there is none, it is unknown, or this is no scene. */
  unsigned firstInvalidGeometry = noPrimitive, firstInvalidPrimitive = noPrimitive;
  size_t numUnsupportedFaces = 0; //!< left out, as by Embree's subdivision
  /*! Buffers of compressed geometries that Embree allocated and did not release, and its copies of topology. */
  size_t inputBytes = 0;
  size_t cacheBytesPerThread = 0; //!< of a tracing thread; 0 for single surfaces
  float maxLeafThickness = 0;     //!< largest distance between a leaf's bounds
  float maxVertexSpacing = 0;     //!< cVERT: largest spacing of a lattice
  float maxVertexDeviation = 0;   //!< cVERT, borders of cLEAF: largest distance from the evaluated vertex
  /*! cVERT, cLEAF: largest distance between two faces' evaluations of a vertex. */
  float maxBorderMismatch = 0;

  /*! Blocks, grids and the tree above them. */
  size_t allBytes() const { return topLevelBytes + headerBytes + nodeBytes + leafBytes + uncompressedBytes; }
};

/*! Calls sum(a.x,b.x) for each summed member x and largest(a.x,b.x) for each maximum. */
template<typename A, typename B, typename Sum, typename Largest>
void forEachMember(A& a, const B& b, const Sum& sum, const Largest& largest) {
  sum(a.topLevelBytes, b.topLevelBytes);
  sum(a.headerBytes, b.headerBytes);
  sum(a.nodeBytes, b.nodeBytes);
  sum(a.leafBytes, b.leafBytes);
  sum(a.uncompressedBytes, b.uncompressedBytes);
  sum(a.numBlocks, b.numBlocks);
  sum(a.numQuads, b.numQuads);
  sum(a.numUncompressedQuads, b.numUncompressedQuads);
  sum(a.numInvalidQuads, b.numInvalidQuads);
  sum(a.numAffineBlocks, b.numAffineBlocks);
  sum(a.numSolidLeaves, b.numSolidLeaves);
  sum(a.numRawBlocks, b.numRawBlocks);
  sum(a.numFallbackQuads, b.numFallbackQuads);
  sum(a.numFlippedQuads, b.numFlippedQuads);
  sum(a.numMeshQuads, b.numMeshQuads);
  sum(a.numIrregularQuads, b.numIrregularQuads);
  sum(a.numMovingQuads, b.numMovingQuads);
  sum(a.motionBytes, b.motionBytes);
  sum(a.numUnsupportedFaces, b.numUnsupportedFaces);
  sum(a.inputBytes, b.inputBytes);
  sum(a.cacheBytesPerThread, b.cacheBytesPerThread); // static and moving blocks have separate caches
  largest(a.maxLeafThickness, b.maxLeafThickness);
  largest(a.maxVertexSpacing, b.maxVertexSpacing);
  largest(a.maxVertexDeviation, b.maxVertexDeviation);
  largest(a.maxBorderMismatch, b.maxBorderMismatch);
}

inline void add(CompressionStatistics& sums, const CompressionStatistics& other) {
  forEachMember(
      sums, other, [](size_t& sum, size_t value) { sum += value; },
      [](float& most, float value) { most = std::max(most, value); });
  if (other.firstInvalidGeometry < sums.firstInvalidGeometry) {
    sums.firstInvalidGeometry = other.firstInvalidGeometry;
    sums.firstInvalidPrimitive = other.firstInvalidPrimitive;
  }
}

/*! A vertex of the input that is not finite. */
struct InvalidVertex {
  unsigned vertex = ~0u; //!< ~0u: there is none
  unsigned timeStep = 0;
};

/*! Statistics of one surface, or of a part of it. Members other than `sums` are for messages; paper/writer.h also
 *  rejects a patch by its framelessQuads. */
struct SurfaceStatistics {
  CompressionStatistics sums;
  size_t highRateQuads = 0;        //!< traced by GRID because of their edge rates
  size_t framelessQuads = 0;       //!< in full precision, because their block has no good frame
  size_t framelessQuadsInGrid = 0; //!< part of framelessQuads that GRID traces
  size_t quadsForHoles = 0;        //!< stored as another kind because of holes
  size_t invalidFaces = 0;         //!< primitives that the commit reports as invalid (surface/source.h)
  size_t facesWithoutSurface = 0;  //!< of invalidFaces: control vertices leave nothing of them at any time step
  size_t bytesInEmbree = 0;        //!< estimate for Embree's own representation
  size_t firstInvalidFace = std::numeric_limits<size_t>::max();
  InvalidVertex firstInvalidVertex; //!< a reason why firstInvalidFace is invalid
  size_t firstUnsupportedFace = std::numeric_limits<size_t>::max();
};
} // namespace embree::cbvh
