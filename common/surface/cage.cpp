// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/cage.h"

namespace programs {

/* Exporters also write vertices without faces, such as helper points. */
Box3f Cage::bounds() const {
  Box3f box;
  for (unsigned vertex : faceIndices) box.extend(positions[vertex]);
  return box;
}

size_t Cage::numFacesWithoutUVs() const {
  if (!hasUVs()) return numFaces();
  size_t count = 0, first = 0;
  for (unsigned size : faceSizes) {
    count += uvIndices[first] == noUV;
    first += size;
  }
  return count;
}

PatchLayout::PatchLayout(const Cage& cage, int level, size_t copies) {
  std::vector<char> isHole(cage.numFaces(), 0);
  for (unsigned face : cage.holes) isHole[face] = 1;

  firstOfFace.reserve(cage.numFaces() * copies);
  sizeOfFace = cage.faceSizes;
  for (unsigned face = 0; face < cage.numFaces() * copies; face++) {
    firstOfFace.push_back(unsigned(all.size()));
    if (isHole[face % cage.numFaces()]) continue;
    const bool quad = size(face) == 4;
    const unsigned rate = 1u << level;
    const unsigned resolution = quad ? rate : std::max(1u, rate / 2);
    for (unsigned sub = 0; sub < (quad ? 1 : size(face)); sub++) {
      all.push_back({face, sub, resolution, vertices, quads});
      vertices += size_t(resolution + 1) * (resolution + 1);
      quads += size_t(resolution) * resolution;
    }
  }
}

const Patch& PatchLayout::find(unsigned face, float u, float v) const {
  const unsigned sub = isQuadFace(face) ? 0 : std::min(decodeSubPatch(u, v), size(face) - 1);
  return all[firstOfFace[face] + sub];
}

unsigned decodeSubPatch(float& u, float& v) {
  const float column = std::floor(0.5f * u), row = std::floor(0.5f * v);
  u -= 2.0f * column + 0.5f;
  v -= 2.0f * row + 0.5f;
  return 4 * unsigned(row) + unsigned(column);
}

Vec2f encodeSubPatch(unsigned subPatch, float u, float v) {
  return {2.0f * float(subPatch & 3) + 0.5f + u, 2.0f * float(subPatch >> 2) + 0.5f + v};
}

} // namespace programs
