// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "built_variant.h"

#include <algorithm>

namespace programs {
namespace {

/* Sizes in Embree 3.13. */
constexpr size_t gridQuads = 8;            // per side
constexpr size_t gridVertexBytes = 16;     // x, y, z and (u,v)
constexpr size_t vertexBytes = 12;         // of a triangle mesh
constexpr size_t indexBytes = 12;          // three per triangle
constexpr size_t triangle4Bytes = 4 * 44;  // four triangles with their vertices
constexpr size_t triangle4iBytes = 4 * 20; // four triangles with indices, in compact mode

/* `leafBytes` are the bytes of a full leaf of four triangles. */
size_t leafBytesOfTriangles(const PatchLayout& layout, size_t leafBytes) {
  return layout.numVertices() * vertexBytes + layout.numQuads() * 2 * (indexBytes + leafBytes / 4);
}

/* Each grid stores its own borders. */
size_t leafBytesOfGrids(const PatchLayout& layout) {
  size_t vertices = 0;
  for (const Patch& p : layout.patches()) {
    const size_t grids = (p.resolution + gridQuads - 1) / gridQuads, side = p.resolution + grids;
    vertices += side * side;
  }
  return vertices * gridVertexBytes;
}

/* Including the buffers of triangles. */
size_t leafBytes(const BuiltScene& scene) {
  switch (scene.representation().kind) {
  case RepresentationKind::Naive: return leafBytesOfTriangles(scene.layout(), triangle4Bytes);
  case RepresentationKind::NaiveCompact: return leafBytesOfTriangles(scene.layout(), triangle4iBytes);
  case RepresentationKind::Grid: return leafBytesOfGrids(scene.layout());
  default: return scene.report().compression.leafBytes + scene.report().compression.uncompressedBytes;
  }
}

} // namespace

BuiltVariant::BuiltVariant(const Model& model, const Variant& variant, BuildSettings settings, const Library& library,
                           Group& group)
  : scene(nullptr, Deleter{&library}) {
  settings.isa = variant.isa;
  library.use();
  scene.reset(new BuiltScene(model, variant.representation, settings));
  VariantResult result;
  result.variant = variant;
  result.library = library.name();
  result.build = scene->report();
  result.leafBytes = leafBytes(*scene);
  result.innerBytes = result.build.liveBytes - std::min(result.build.liveBytes, result.leafBytes);
  group.results.push_back(std::move(result));
  variantResult = &group.results.back();
}

void BuiltVariant::Deleter::operator()(BuiltScene* scene) const {
  library->use();
  delete scene;
}

std::optional<size_t> findInFirstLibrary(const std::vector<BuiltVariant>& batch, size_t i) {
  for (size_t first = 0; first < batch.size(); first++)
    if (first != i && batch[first].variant().library == 0 &&
        differOnlyByLibrary(batch[first].variant(), batch[i].variant()))
      return first;
  return std::nullopt;
}

} // namespace programs
