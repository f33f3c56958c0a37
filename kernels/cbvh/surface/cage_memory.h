// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include <vector>

namespace embree {
/*! Memory of a cage that Embree keeps. A friend of SubdivMesh. */
struct CageMemory {
  /*! Embree's own allocation of half-edges rounds their number up to a power of two. */
  static void reserveHalfEdges(SubdivMesh* mesh) {
    for (auto& topology : mesh->topology)
      if (topology.vertexIndices) topology.halfEdges.reserve(mesh->numEdges());
  }

  /*! Frees the arrays for sorting half-edges, as large as the half-edges. Embree needs them again only if the
   *  topology changes. */
  static void freeSortedEdges(SubdivMesh* mesh) {
    for (auto& topology : mesh->topology) {
      std::vector<SubdivMesh::KeyHalfEdge>().swap(topology.halfEdges0);
      std::vector<SubdivMesh::KeyHalfEdge>().swap(topology.halfEdges1);
    }
  }

  /*! Keeps vertex attributes, and the topology that rtcInterpolate needs for them. */
  static void releaseInput(SubdivMesh* mesh) {
    const bool hasAttributes = !mesh->vertexAttribs.empty();
    for (auto& buffer : mesh->vertices) buffer = BufferView<Vec3fa>();
    for (auto& tags : mesh->vertex_buffer_tags) std::vector<SharedLazyTessellationCache::CacheEntry>().swap(tags);
    for (auto& topology : mesh->topology) {
      topology.vertexIndices = BufferView<unsigned int>();
      if (!hasAttributes) topology.halfEdges.clear();
      else if (topology.halfEdges.size() > mesh->numHalfEdges) topology.halfEdges.resize(mesh->numHalfEdges);
    }
    mesh->faceVertices = BufferView<unsigned int>();
    mesh->edge_creases = BufferView<SubdivMesh::Edge>();
    mesh->edge_crease_weights = BufferView<float>();
    mesh->vertex_creases = BufferView<unsigned int>();
    mesh->vertex_crease_weights = BufferView<float>();
    mesh->levels = BufferView<float>();
    mesh->holes = BufferView<unsigned>();
    mesh->halfEdgeFace.clear();
    mesh->numHalfEdges = 0; // functions that use half-edges then report errors
    if (hasAttributes) return;
    mesh->faceStartEdge.clear();
    mesh->invalid_face.clear();
  }

  /*! Bytes of half-edges and of tables of faces, which Embree makes from the input. */
  static size_t bytesOfTopology(const SubdivMesh* mesh) {
    size_t bytes = (mesh->faceStartEdge.capacity() + mesh->halfEdgeFace.capacity()) * sizeof(uint32_t) +
                   mesh->invalid_face.capacity();
    for (const auto& topology : mesh->topology) // capacity() exceeds size() after edits
      bytes += topology.halfEdges.capacity() * sizeof(HalfEdge);
    return bytes;
  }
};
} // namespace embree
