// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Control cage of a Catmull-Clark surface, and Embree's patches: one per quad face; N per face of N != 4 vertices, one
 * per corner, with half the edge rate, because Embree subdivides the face once first. Level L means an edge rate of
 * 2^L. */

#include "basics/vec.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace programs {

/* Shape at boundary edges, with the names and numbers of OpenSubdiv's tag interpolateboundary. */
enum class BoundaryRule {
  None = 0,          // faces that touch the boundary have no surface
  EdgeAndCorner = 1, // smooth boundary curve, sharp corners
  EdgeOnly = 2,      // smooth boundary curve
};

/* How each subdivision step reduces the sharpness of creases. */
enum class CreaseRule {
  Uniform, // by 1
  Chaikin, // by 1 after averaging with neighboring creases
};

/* The sharpness that a file or a caller means: 10 and more are infinite, as in OpenSubdiv and USD. Embree rounds a
 * corner of any finite sharpness. */
inline float sharpnessOf(float given) { return given >= 10.0f ? INFINITY : given; }

struct Cage {
  std::string name;
  std::string comments; // of the head of its file, one per line
  std::vector<Vec3f> positions;
  std::vector<unsigned> faceSizes;   // vertices per face, at least 3
  std::vector<unsigned> faceIndices; // into positions

  /* Face-varying texture coordinates. uvIndices is parallel to faceIndices and noUV at all corners of a face without
   * coordinates. Both are empty if no face has any. */
  std::vector<Vec2f> uvs;
  std::vector<unsigned> uvIndices;
  size_t lineWithoutUVs = 0; // of the first face without coordinates, or 0
  static constexpr unsigned noUV = ~0u;

  std::vector<std::pair<unsigned, unsigned>> creaseEdges; // vertex pairs
  std::vector<float> creaseSharpness;                     // below 10, or infinity for a hard edge
  std::vector<unsigned> cornerVertices;
  std::vector<float> cornerSharpness;
  std::vector<unsigned> holes;
  BoundaryRule boundary = BoundaryRule::EdgeOnly; // the default of OpenSubdiv and Embree
  CreaseRule creaseRule = CreaseRule::Uniform;    // OpenSubdiv's default; for Embree see crease_rules.h

  size_t numFaces() const { return faceSizes.size(); }
  bool hasUVs() const { return !uvIndices.empty(); }
  size_t numFacesWithoutUVs() const;
  Box3f bounds() const;
};

/* resolution x resolution quads. Vertices are row by row, u fastest. */
struct Patch {
  unsigned face;
  unsigned subPatch; // corner of an n-gon, else 0
  unsigned resolution;
  size_t firstVertex; // index of vertex (0,0) in the vertices of all patches
  size_t firstQuad;   // the same in all quads
};

/* Patches in order of faces; holes have none. Faces are numbered consecutively over the copies. */
class PatchLayout {
public:
  PatchLayout(const Cage& cage, int level, size_t copies = 1);

  /* (u,v) are as Embree reports them. */
  const Patch& find(unsigned face, float u, float v) const;

  /* If true, (u,v) are in [0,1]. */
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

/* Embree's (u,v) of an n-gon encode the sub-patch i: it covers [0.5,1.5] + 2 (i mod 4, i div 4). Returns i and
 * replaces u and v by local ones in [0,1]. */
unsigned decodeSubPatch(float& u, float& v);

Vec2f encodeSubPatch(unsigned subPatch, float u, float v);

} // namespace programs
