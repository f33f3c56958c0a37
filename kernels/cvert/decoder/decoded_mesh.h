// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decodes all triangles of a mesh block or of a group: the reference for the kernels' SIMD decoders. */

#include "mesh_step_view.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Triangles of a group, one per lane. */
struct DecodedMeshGroup {
  uint32_t numTriangles, numVertices;
  uint32_t vertices[maxGroupVertices];    //!< indices of the group's vertices in the block
  uint8_t indices[3][maxGroupTriangles];  //!< by corner, in the application's order, into `vertices`
  float corners[3][3][maxGroupTriangles]; //!< by corner and axis
  uint32_t numbers[maxGroupTriangles];    //!< see MeshView::number

  /*! Decodes the first step. */
  DecodedMeshGroup(const MeshView& view, uint32_t g)
    : DecodedMeshGroup(view, g, [&](uint32_t v, float out[3]) { view.vertex(v, out); }) {}

  /*! vertex(v,out): decodes vertex v of the block at the step. */
  template<typename Vertex>
  DecodedMeshGroup(const MeshView& view, uint32_t g, const Vertex& vertex) {
    const uint32_t group = meshGroupByte(view.block, g), record = meshRecord(view.block, g);
    numTriangles = groupTriangles(group);
    numVertices = groupVertices(record);
    const MeshTopology at = meshTopology(group, record, meshVertices(view.block->counts));
    auto bits = [&](uint32_t begin, uint32_t count) {
      return meshBitsAt(view.topology, view.topologyBegin[g] + begin, count);
    };

    const uint32_t ownMask = bits(at.ownMask, numVertices);
    float positions[maxGroupVertices][3];
    for (uint32_t i = 0, own = 0, other = 0; i < numVertices; i++) {
      vertices[i] = (ownMask >> i) & 1 ? view.firstVertex[g] + own++
                                       : bits(at.otherIndices + at.otherBits * other++, at.otherBits);
      vertex(vertices[i], positions[i]);
    }

    uint8_t stream[maxGroupTriangles + 2 + 2 * maxGroupRestarts];
    const uint32_t length = streamLength(numTriangles, groupRestarts(group, record));
    for (uint32_t i = 0, numNew = 0, repeats = 0; i < length; i++)
      stream[i] =
          uint8_t(i < 3 || bits(at.newMask + i - 3, 1) ? numNew++
                                                       : bits(at.repeats + at.repeatBits * repeats++, at.repeatBits));

    const uint32_t restarts = bits(at.restarts, numTriangles - 1) << 1 | 1, fans = bits(at.fans, numTriangles - 1) << 1;
    for (uint32_t t = 0; t < numTriangles; t++) {
      const StripTriangle triangle = stripTriangle(restarts, fans, bits(at.firstCorners + 2 * t, 2), t);
      const uint32_t positionsInStream[3] = {triangle.v0, triangle.v1, triangle.v2};
      for (uint32_t c = 0; c < 3; c++) {
        indices[c][t] = stream[positionsInStream[c]];
        for (uint32_t k = 0; k < 3; k++) corners[c][k][t] = positions[indices[c][t]][k];
      }
      numbers[t] = view.number(g, t);
    }
  }
};

/*! Vertices and triangles of a mesh block at a time step. SIMD decoders must return the same floats. The block must
 *  be valid (validateMesh). */
class DecodedMesh {
public:
  uint32_t numVertices, numTriangles, numGroups;
  float vertices[maxMeshVertices][3];
  uint32_t triangles[maxMeshTriangles][3];   //!< indices of vertices
  uint32_t numbers[maxMeshTriangles];        //!< see MeshView::number
  uint32_t firstTriangle[maxMeshGroups + 1]; //!< first triangle of each group, then their total

  /*! step: below the number of time steps. */
  explicit DecodedMesh(const MeshHeader* block, uint32_t step = 0)
    : numVertices(meshVertices(block->counts)),
      numTriangles(meshTriangles(block->counts)),
      numGroups(meshGroups(block->counts)) {
    const MeshView view(block);
    if (step == 0)
      for (uint32_t v = 0; v < numVertices; v++) view.vertex(v, vertices[v]);
    else {
      const MeshStepView later(view, step);
      for (uint32_t v = 0; v < numVertices; v++) later.vertex(v, vertices[v]);
    }
    for (uint32_t g = 0; g < numGroups; g++) {
      const DecodedMeshGroup group(view, g);
      firstTriangle[g] = view.firstTriangle[g];
      for (uint32_t t = 0; t < group.numTriangles; t++) {
        const uint32_t i = firstTriangle[g] + t;
        for (uint32_t c = 0; c < 3; c++) triangles[i][c] = group.vertices[group.indices[c][t]];
        numbers[i] = group.numbers[t];
      }
    }
    firstTriangle[numGroups] = numTriangles;
  }
};
}} // namespace cvert::CVERT_ISA
