// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "input_checks.h"
#include <algorithm>
#include <cmath>

namespace embree {
static std::string describe(const SubdivMesh* mesh, size_t face) {
  return "face " + std::to_string(face) + " with " + std::to_string(mesh->faceVertices[face]) + " vertices: ";
}

void checkSizes(const SubdivMesh* mesh) {
  const size_t numIndices = mesh->topology[0].vertexIndices.size();
  size_t corners = 0;
  for (size_t f = 0; f < mesh->faceVertices.size(); f++)
    if ((corners += mesh->faceVertices[f]) > numIndices)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                     describe(mesh, f) + "the index buffer ends after " + std::to_string(numIndices) + " indices");

  auto require = [](size_t size, size_t expected, const std::string& values, const char* perWhat) {
    if (size < expected)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "there are " + std::to_string(size) + " " + values +
                                                     ": expected at least " + std::to_string(expected) + ", one per " +
                                                     perWhat);
  };
  for (size_t i = 1; i < mesh->topology.size(); i++)
    if (mesh->topology[i].vertexIndices)
      require(mesh->topology[i].vertexIndices.size(), corners, "indices of topology " + std::to_string(i),
              "corner of a face");
  if (mesh->levels) require(mesh->levels.size(), corners, "levels", "edge of a face");
  require(mesh->edge_crease_weights.size(), mesh->edge_creases.size(), "edge crease weights", "edge crease");
  require(mesh->vertex_crease_weights.size(), mesh->vertex_creases.size(), "vertex crease weights", "vertex crease");
}

void checkIndices(const SubdivMesh* mesh) {
  checkTimeSteps(mesh);
  checkSizes(mesh);
  const BufferView<unsigned>& indices = mesh->topology[0].vertexIndices;
  const size_t numVertices = mesh->vertices[0].size(), none = ~size_t(0);
  const size_t firstWrong = parallel_reduce(
      size_t(0), indices.size(), size_t(1) << 16, none,
      [&](const range<size_t>& r) {
        for (size_t i = r.begin(); i != r.end(); i++)
          if (indices[i] >= numVertices) return i;
        return none;
      },
      [](size_t a, size_t b) { return min(a, b); });
  size_t begin = 0;
  for (size_t f = 0; f < mesh->faceVertices.size(); begin += mesh->faceVertices[f++])
    if (begin + mesh->faceVertices[f] > firstWrong)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, describe(mesh, f) + "index " + std::to_string(firstWrong - begin) +
                                                     " is vertex " + std::to_string(indices[firstWrong]) +
                                                     ": expected less than " + std::to_string(numVertices));
}

namespace {
/*! Describes values that are not numbers. Embree's comparisons with them have arbitrary results. */
void describeValues(const BufferView<float>& values, const char* name, const char* expected,
                    std::vector<std::string>& warnings) {
  size_t first = 0, count = 0;
  for (size_t i = 0; i < values.size(); i++)
    if (std::isnan(values[i]) && count++ == 0) first = i;
  if (count == 0) return;
  warnings.push_back(std::string(name) + " " + std::to_string(first) +
                     (count == 1 ? "" : " and " + std::to_string(count - 1) + " others") +
                     (count == 1 ? " is not a number: expected " : " are not numbers: expected ") + expected);
}

/*! Describes creases whose two vertices share no edge. Embree, like OpenSubdiv, ignores them. */
void describeCreases(const SubdivMesh* mesh, std::vector<std::string>& warnings) {
  struct Crease {
    uint64_t edge;
    size_t index;
    bool isUsed;
  };
  std::vector<Crease> creases(mesh->edge_creases.size());
  for (size_t i = 0; i < creases.size(); i++) creases[i] = {uint64_t(mesh->edge_creases[i]), i, false};
  std::sort(creases.begin(), creases.end(), [](const Crease& a, const Crease& b) { return a.edge < b.edge; });
  const BufferView<unsigned>& indices = mesh->topology[0].vertexIndices;
  for (size_t f = 0, begin = 0; f < mesh->size(); begin += mesh->faceVertices[f++])
    for (size_t i = 0, n = mesh->faceVertices[f]; i < n; i++) {
      const uint64_t edge = SubdivMesh::Edge(indices[begin + i], indices[begin + (i + 1) % n]);
      auto found = std::lower_bound(creases.begin(), creases.end(), edge,
                                    [](const Crease& crease, uint64_t e) { return crease.edge < e; });
      for (; found != creases.end() && found->edge == edge && !found->isUsed; found++) found->isUsed = true;
    }
  size_t first = creases.size(), count = 0;
  for (const Crease& crease : creases)
    if (!crease.isUsed) {
      first = min(first, crease.index);
      count++;
    }
  if (count == 0) return;
  const SubdivMesh::Edge pair = mesh->edge_creases[first];
  warnings.push_back("crease " + std::to_string(first) + " joins the vertices " + std::to_string(pair.v0) + " and " +
                     std::to_string(pair.v1) + ", which share no edge" +
                     (count == 1 ? ": it is ignored"
                                 : ", like " + std::to_string(count - 1) + (count == 2 ? " other" : " others") +
                                       ": they are ignored"));
}
} // namespace

std::vector<std::string> describeIgnoredInput(const SubdivMesh* mesh) {
  std::vector<std::string> warnings;
  if (!mesh->faceVertices || !mesh->topology[0].vertexIndices) return warnings;
  if (mesh->edge_creases.size()) describeCreases(mesh, warnings);
  describeValues(mesh->edge_crease_weights, "edge crease weight", "0 to infinity", warnings);
  describeValues(mesh->vertex_crease_weights, "vertex crease weight", "0 to infinity", warnings);
  describeValues(mesh->levels, "level", "1 to 4096", warnings);
  if (!mesh->levels && std::isnan(mesh->tessellationRate))
    warnings.push_back("the tessellation rate is not a number: expected 1 to 4096");
  return warnings;
}

void checkSides(const GridMesh* mesh) {
  const unsigned maxSide = 32767;
  for (size_t i = 0; i < mesh->grids.size(); i++)
    if (max(mesh->grid(i).resX, mesh->grid(i).resY) > maxSide)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                     "grid " + std::to_string(i) + " has " + std::to_string(mesh->grid(i).resX) + " x " +
                         std::to_string(mesh->grid(i).resY) + " vertices: expected at most " + std::to_string(maxSide) +
                         " along a side of a grid that is not compressed");
}

void checkStrides(const GridMesh* mesh) {
  const size_t large = size_t(1) << 24; // number of vertices
  for (size_t i = 0; i < mesh->grids.size(); i++)
    if (mesh->grid(i).lineVtxOffset == 0 && size_t(mesh->grid(i).resX) * mesh->grid(i).resY > large)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                     "grid " + std::to_string(i) + " of " + std::to_string(mesh->grid(i).resX) + " x " +
                         std::to_string(mesh->grid(i).resY) +
                         " vertices has a stride of 0 vertices from one row to the next: expected at least 1");
}
} // namespace embree
