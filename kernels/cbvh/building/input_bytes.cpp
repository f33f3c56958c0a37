// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "input_bytes.h"
#include "../surface/cage_memory.h"

namespace embree {
namespace {
/*! Counts each buffer once, and not buffers that the application allocated (shared). */
class InputBytes {
public:
  explicit InputBytes(std::set<const void*>& counted) : counted(counted) {}

  void add(const RawBufferView& view) {
    const Buffer* const buffer = view.buffer.ptr;
    if (buffer && !buffer->shared && counted.insert(buffer).second) bytes += buffer->bytes();
  }

  template<typename View>
  void add(const vector<View>& views) {
    for (const View& view : views) add(view);
  }

  template<typename Mesh>
  void addVertices(const Mesh* mesh) {
    add(mesh->vertices);
    add(mesh->vertexAttribs);
  }

  void addCage(const SubdivMesh* mesh) {
    addVertices(mesh);
    for (const auto& topology : mesh->topology) add(topology.vertexIndices);
    bytes += CageMemory::bytesOfTopology(mesh);
    add(mesh->faceVertices);
    add(mesh->edge_creases);
    add(mesh->edge_crease_weights);
    add(mesh->vertex_creases);
    add(mesh->vertex_crease_weights);
    add(mesh->levels);
    add(mesh->holes);
  }

  size_t bytes = 0;

private:
  std::set<const void*>& counted;
};
} // namespace

size_t bytesOfInput(const CompressibleGeometry* geometry, std::set<const void*>& counted) {
  InputBytes input(counted);
  // a geometry loaded from a file has none of these classes, whatever its type
  if (const SubdivMesh* cage = dynamic_cast<const SubdivMesh*>(geometry)) input.addCage(cage);
  else if (const GridMesh* grids = dynamic_cast<const GridMesh*>(geometry)) {
    input.addVertices(grids);
    input.add(grids->grids);
  } else if (const QuadMesh* quads = dynamic_cast<const QuadMesh*>(geometry)) {
    input.addVertices(quads);
    input.add(quads->quads);
  } else if (const TriangleMesh* triangles = dynamic_cast<const TriangleMesh*>(geometry)) {
    input.addVertices(triangles);
    input.add(triangles->triangles);
  }
  return input.bytes;
}
} // namespace embree
