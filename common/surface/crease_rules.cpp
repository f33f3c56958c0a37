// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/crease_rules.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace programs {
namespace {

bool isFraction(float sharpness) { return std::isfinite(sharpness) && sharpness != std::floor(sharpness); }

/* `sharpness` holds the vertex's sharp edges. */
bool differs(std::vector<float> sharpness, float corner, CreaseRule rule) {
  if (sharpness.size() < 2 || corner == INFINITY) return false;
  if (corner > 0.0f) return true;
  std::sort(sharpness.begin(), sharpness.end());
  /* In the order in which creases end: Embree treats a fractional crease as a whole one while there are three, and
   * averages the last two. */
  const bool areEqual = sharpness.front() == sharpness.back();
  for (size_t i = 0; i + 2 < sharpness.size(); i++)
    if (isFraction(sharpness[i])) return true;
  const size_t last = sharpness.size() - 1;
  if (sharpness.size() > 2 && areEqual) return false;
  if (rule == CreaseRule::Chaikin) return sharpness.size() > 2;
  return sharpness[last - 1] != sharpness[last];
}

} // namespace

std::vector<unsigned> findVerticesWithDifferentCreaseRules(const Cage& cage) {
  const auto edge = [](unsigned a, unsigned b) { return std::make_pair(std::min(a, b), std::max(a, b)); };
  if (cage.creaseEdges.empty()) return {};
  std::map<std::pair<unsigned, unsigned>, float> sharp;
  for (size_t i = 0; i < cage.creaseEdges.size(); i++)
    if (cage.creaseSharpness[i] > 0.0f)
      sharp[edge(cage.creaseEdges[i].first, cage.creaseEdges[i].second)] = cage.creaseSharpness[i];
  std::map<std::pair<unsigned, unsigned>, int> sides; // faces per edge: boundary edges are sharp
  size_t first = 0;
  for (unsigned n : cage.faceSizes) {
    for (unsigned i = 0; i < n; i++) sides[edge(cage.faceIndices[first + i], cage.faceIndices[first + (i + 1) % n])]++;
    first += n;
  }
  std::map<unsigned, std::vector<float>> atVertex;
  for (const auto& [vertices, count] : sides) {
    const auto crease = sharp.find(vertices);
    const float sharpness = count != 2 ? INFINITY : crease == sharp.end() ? 0.0f : crease->second;
    if (sharpness > 0.0f)
      for (unsigned v : {vertices.first, vertices.second}) atVertex[v].push_back(sharpness);
  }
  std::map<unsigned, float> corners;
  for (size_t i = 0; i < cage.cornerVertices.size(); i++) corners[cage.cornerVertices[i]] = cage.cornerSharpness[i];
  std::vector<unsigned> result;
  for (const auto& [vertex, sharpness] : atVertex) {
    const auto corner = corners.find(vertex);
    if (differs(sharpness, corner == corners.end() ? 0.0f : corner->second, cage.creaseRule)) result.push_back(vertex);
  }
  return result;
}

} // namespace programs
