// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/face_borders.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace programs {

FaceBorders::FaceBorders(const Cage& cage)
  : sizes(cage.faceSizes),
    vertexOf(cage.faceIndices),
    sides(cage.faceIndices.size()),
    corners(cage.positions.size()) {
  size_t offset = 0;
  std::unordered_map<uint64_t, unsigned> edges; // key: both vertices, the smaller one in the upper half
  edges.reserve(cage.faceIndices.size());
  std::vector<size_t> sidesOfEdge;
  for (unsigned face = 0; face < sizes.size(); face++) {
    firstCorner.push_back(offset);
    for (unsigned i = 0; i < sizes[face]; i++) {
      const unsigned a = vertexOf[offset + i], b = vertexOf[offset + (i + 1) % sizes[face]];
      corners[a].push_back({face, i, a > b});
      const uint64_t vertices = uint64_t(std::min(a, b)) << 32 | std::max(a, b);
      const auto [entry, isNew] = edges.try_emplace(vertices, unsigned(edges.size()));
      if (isNew) sidesOfEdge.push_back(0);
      sidesOfEdge[entry->second]++;
      edgeOf.push_back(entry->second);
    }
    offset += sizes[face];
  }
  firstSide.push_back(0);
  for (size_t count : sidesOfEdge) firstSide.push_back(firstSide.back() + count);
  std::vector<size_t> next(firstSide.begin(), firstSide.end() - 1);
  for (unsigned face = 0; face < sizes.size(); face++)
    for (unsigned i = 0; i < sizes[face]; i++) sides[next[edgeOf[corner(face, i)]]++] = {face, i, isReversed(face, i)};
}

FaceBorders::Side FaceBorders::opposite(unsigned face, unsigned edge) const {
  const Sides all = sidesOfEdge(face, edge);
  if (all.size() != 2) return {};
  const Side& other = all.begin()->face == face && all.begin()->edge == edge ? *(all.end() - 1) : *all.begin();
  return other.reversed == isReversed(face, edge) ? Side() : other;
}

/* Edges 0 to 3 of a quad are v = 0, u = 1, v = 1, u = 0. Corner quads of n-gons have half of an edge each at v = 0
 * and, of the previous edge, at u = 0. */
FaceBorders::BorderPosition FaceBorders::borderPosition(const FacePoint& p) const {
  float u = p.u, v = p.v;
  if (sizes[p.face] == 4) {
    if (v == 0.0f) return {0, u};
    if (u == 1.0f) return {1, v};
    if (v == 1.0f) return {2, 1.0f - u};
    if (u == 0.0f) return {3, 1.0f - v};
    return {};
  }
  const unsigned n = sizes[p.face], corner = std::min(decodeSubPatch(u, v), n - 1);
  if (v == 0.0f) return {int(corner), 0.5f * u};
  if (u == 0.0f) return {int((corner + n - 1) % n), 1.0f - 0.5f * v};
  return {};
}

FacePoint FaceBorders::point(unsigned face, unsigned edge, float t) const {
  if (sizes[face] != 4) {
    const bool first = t <= 0.5f;
    const Vec2f uv = encodeSubPatch(first ? edge : (edge + 1) % sizes[face], first ? 2.0f * t : 0.0f,
                                    first ? 0.0f : 2.0f * (1.0f - t));
    return {face, uv.x, uv.y};
  }
  switch (edge) {
  case 0: return {face, t, 0.0f};
  case 1: return {face, 1.0f, t};
  case 2: return {face, 1.0f - t, 1.0f};
  default: return {face, 0.0f, 1.0f - t};
  }
}

} // namespace programs
