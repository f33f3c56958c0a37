// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Control cage of a Catmull-Clark subdivision surface, and the patches Embree
 * makes of it. A quad face is one patch; a face of N != 4 vertices is N patches,
 * one a corner, each at half the edge rate, because Embree subdivides it once
 * first. Level L means an edge rate of 2^L. */

#include "basics/vec.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace cbvh {

/* How the surface ends at boundary edges; names and numbers as OpenSubdiv's
 * interpolateboundary tag. */
enum class BoundaryRule
{
  None = 0,          // faces that touch the boundary vanish
  EdgeAndCorner = 1, // smooth boundary curve, sharp corners
  EdgeOnly = 2,      // smooth boundary curve
};

/* How the sharpness of creases goes down from step to step. */
enum class CreaseRule
{
  Uniform, // by 1
  Chaikin, // by 1, after creases that meet have come nearer to each other
};

struct Cage
{
  std::string name;
  std::string comments; // at the head of its file, a line each
  std::vector<Vec3f> positions;
  std::vector<unsigned> faceSizes;   // vertices a face, at least 3
  std::vector<unsigned> faceIndices; // concatenated, into positions

  /* Face-varying texture coordinates: uvIndices runs parallel to faceIndices. It is noUV at
   * all corners of a face without coordinates. Both are empty if no face has some. */
  std::vector<Vec2f> uvs;
  std::vector<unsigned> uvIndices;
  size_t lineWithoutUVs = 0; // of the first face without, if others have some; 0 for a cage that is from no file
  static constexpr unsigned noUV = ~0u;

  std::vector<std::pair<unsigned, unsigned>> creaseEdges; // vertex pairs
  std::vector<float> creaseSharpness;                     // infinity: a hard edge
  std::vector<unsigned> cornerVertices;
  std::vector<float> cornerSharpness;
  std::vector<unsigned> holes;                            // faces without surface
  BoundaryRule boundary = BoundaryRule::EdgeOnly;         // OpenSubdiv's and Embree's default
  CreaseRule creaseRule = CreaseRule::Uniform;            // OpenSubdiv's default; see crease_rules.h on Embree's

  size_t numFaces() const { return faceSizes.size(); }
  bool hasUVs() const { return !uvIndices.empty(); } // on some faces at least
  size_t numFacesWithoutUVs() const;
  Box3f bounds() const;
};

/* A rectangle of quads of one face: resolution x resolution of them, vertices in
 * rows of resolution + 1, u fastest. */
struct Patch
{
  unsigned face;
  unsigned subPatch;   // corner of an n-gon, 0 for a quad face
  unsigned resolution;
  size_t firstVertex;  // index of vertex (0,0) when all patches are laid out in a row
  size_t firstQuad;    // likewise for quads
};

/* All patches of a cage at one level, in order of faces; holes have none. Several
 * copies of a cage follow one another, faces numbered on. */
class PatchLayout
{
public:
  PatchLayout(const Cage& cage, int level, size_t copies = 1);

  /* Patch of a face, given (u,v) as Embree reports them. */
  const Patch& find(unsigned face, float u, float v) const;

  /* Whether a face is one patch, with (u,v) from 0 to 1. */
  bool isQuadFace(unsigned face) const { return size(face) == 4; }

  const std::vector<Patch>& patches() const { return all; }
  size_t numQuads() const { return quads; }
  size_t numVertices() const { return vertices; }

private:
  std::vector<Patch> all;
  unsigned size(unsigned face) const { return sizeOfFace[face % sizeOfFace.size()]; }

  std::vector<unsigned> firstOfFace; // into all
  std::vector<unsigned> sizeOfFace;  // of one copy
  size_t quads = 0, vertices = 0;
};

/* Embree's (u,v) of an n-gon: sub-patch i covers [0.5,1.5] + 2 (i mod 4, i div 4).
 * This takes the sub-patch out and leaves local (u,v) in [0,1]. */
unsigned decodeSubPatch(float& u, float& v);

/* The inverse. */
Vec2f encodeSubPatch(unsigned subPatch, float u, float v);

} // namespace cbvh
