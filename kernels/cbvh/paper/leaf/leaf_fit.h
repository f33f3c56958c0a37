// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures how well leaves represent their quads, to decide if a patch should be stored as cVERT. A leaf is a height
 * field over a box: walls that are vertical in the frame get wrong normals, folds become thick planes or entire boxes,
 * and where the surface ends or bends, boxes extend past the edges. docs/paper.md has the limits. */

#include "../block_geometry.h"
#include "../normal.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Smallest cosine of the angle between the normals of a good leaf and its quad. */
static constexpr double minNormalCosine = 0.7;

/*! Largest thickness of a good leaf, relative to the side of a square with the quad's area. */
static constexpr double maxRelativeThickness = 0.25;

/*! Largest distance that a good leaf extends past an edge where the surface ends or bends, in leaf extents. */
static constexpr double maxOverhang = 1.0 / 16;

/*! Largest fractions of a patch's quads, and of its edges where the surface ends or bends, that may be poor. */
static constexpr double maxPoorQuadFraction = 1.0 / 64, maxPoorEdgeFraction = 1.0 / 16;

/*! Smallest sample of isClearlyPoor(), in quads. A smaller patch is the sample. */
static constexpr size_t minSampleQuads = 1024;

/*! Counts, of a block or a patch. */
struct LeafFit {
  uint32_t quads = 0, poorQuads = 0; //!< poor: wrong normal, thick, or in a group of separate leaves
  uint32_t edges = 0, poorEdges = 0; //!< where the surface ends or bends
  uint32_t flippedQuads = 0;         //!< normal is off by over 90 degrees

  void merge(const LeafFit& other) {
    quads += other.quads;
    poorQuads += other.poorQuads;
    edges += other.edges;
    poorEdges += other.poorEdges;
    flippedQuads += other.flippedQuads;
  }

  /*! True if the patch should be stored as cVERT. */
  bool isPoor() const { return poorQuads > maxPoorQuadFraction * quads || poorEdges > maxPoorEdgeFraction * edges; }

  /*! True if the part added so far shows that the patch should be stored as cVERT: poor quads exceed their fraction
   *  of a sample, or poor edges their fraction of all edges. The first quarter of the quads, but at least
   *  minSampleQuads, is the sample; it must be distributed over the patch. patchQuads: quads of the patch.
   *  maxEdges: upper bound of the patch's edges. */
  bool isClearlyPoor(size_t patchQuads, size_t maxEdges) const {
    const size_t sampleSize = std::min(patchQuads, std::max(patchQuads / 4, minSampleQuads));
    return poorQuads > maxPoorQuadFraction * double(std::max(size_t(quads), sampleSize)) ||
           poorEdges > maxPoorEdgeFraction * double(maxEdges);
  }

  /*! Adds quad (x,y) of a block and its leaf. Ignores quads without area. Vertices must be finite. box: of the
   *  leaf. slope: dz/dx and dz/dy of the leaf's plane in the frame. isSeparate: its group has separate
   *  leaves. thickness: in world space. */
  void addQuad(const BlockGeometry& geometry, uint32_t x, uint32_t y, const NodeBox& box, const double slope[2],
               bool isSeparate, double thickness) {
    const QuadNormal quad(geometry, x, y);
    if (!(quad.length > 0)) return;
    const double cosine = quad.cosine(geometry.frame, box, slope);
    quads++;
    flippedQuads += cosine < 0;
    poorQuads +=
        isSeparate || cosine < minNormalCosine || thickness > maxRelativeThickness * std::sqrt(0.5 * quad.length);
  }

  /*! Adds a quad of cVOXEL, whose plane has a constant z in the frame. It may be flipped, but is never poor. */
  void addFlatQuad(const BlockGeometry& geometry, uint32_t x, uint32_t y, const NodeBox& box) {
    const double flat[2] = {0, 0};
    const QuadNormal quad(geometry, x, y);
    if (!(quad.length > 0)) return;
    quads++;
    flippedQuads += quad.cosine(geometry.frame, box, flat) < 0;
  }

  /*! overhang: see maxOverhang. */
  void addEdge(double overhang) {
    edges++;
    poorEdges += !(overhang <= maxOverhang);
  }

private:
  /*! Normal of a quad in world space: the cross product of its diagonals. length: twice the area. */
  struct QuadNormal {
    double n[3], length;

    QuadNormal(const BlockGeometry& geometry, uint32_t x, uint32_t y) {
      const uint32_t w = geometry.width, v = y * w + x;
      double a[3], b[3];
      for (int k = 0; k < 3; k++) {
        a[k] = double(geometry.vertices[v + w + 1][k]) - double(geometry.vertices[v][k]);
        b[k] = double(geometry.vertices[v + w][k]) - double(geometry.vertices[v + 1][k]);
      }
      n[0] = a[1] * b[2] - a[2] * b[1];
      n[1] = a[2] * b[0] - a[0] * b[2];
      n[2] = a[0] * b[1] - a[1] * b[0];
      length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }

    /*! Cosine of the angle to the normal (normal.h) of the plane with these slopes through the middle of a box.
     *  0 if that plane has no normal. */
    double cosine(const Frame& frame, const NodeBox& box, const double slope[2]) const {
      const double c[3] = {box.lower[0] + 0.5 * box.extent[0], box.lower[1] + 0.5 * box.extent[1],
                           box.lower[2] + 0.5 * box.extent[2]};
      const double k = c[2] - slope[0] * c[0] - slope[1] * c[1];
      double dot = 0, square = 0;
      for (int i = 0; i < 3; i++) {
        const float* col = frame.columns[i];
        const double m = col[2] - slope[0] * col[0] - slope[1] * col[1] - k * col[3];
        dot += m * n[i];
        square += m * m;
      }
      return square > 0 ? dot / (std::sqrt(square) * length) : 0;
    }
  };
};
}} // namespace embree::cbvh::CBVH_ISA
