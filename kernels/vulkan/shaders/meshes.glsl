// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects leaves that are not compressed: runs of triangles of Embree's triangle meshes, and up to 2 x 2 quads of
 * GRID. */

#ifndef CBVH_MESHES_GLSL
#define CBVH_MESHES_GLSL

#include "triangle.glsl"

vec3 cbvhMeshVertex(GeometryData geometry, uint i) {
  uint first = i * geometry.vertexStride;
  return vec3(floatAt(geometry.vertices, first), floatAt(geometry.vertices, first + 1u),
              floatAt(geometry.vertices, first + 2u));
}

/* Intersects `count` consecutive triangles of SceneData::leaves. */
bool cbvhTraceRun(SceneData scene, CbvhPreparedRay ray, uint first, uint count, const bool anyHit, inout CbvhHit hit) {
  bool found = false;
  for (uint i = first; i < first + count; i++) {
    uvec2 id = CbvhPairs(scene.leaves).at[i];
    GeometryData geometry = CbvhGeometries(scene.geometries).at[ray.firstGeometry + id.x];
    if ((geometry.mask & ray.mask) == 0u) continue;
    uint k = id.y * geometry.indexStride;
    vec3 a = cbvhMeshVertex(geometry, wordAt(geometry.indices, k));
    vec3 b = cbvhMeshVertex(geometry, wordAt(geometry.indices, k + 1u));
    vec3 c = cbvhMeshVertex(geometry, wordAt(geometry.indices, k + 2u));
    CbvhTriangleHit at;
    bool isHit =
        geometry.isRobust != 0u ? cbvhPluecker(ray, hit.t, a, b, c, at) : cbvhMoellerTrumbore(ray, hit.t, a, b, c, at);
    if (!isHit) continue;
    found = true;
    cbvhSetHit(hit, ray, at.t, at.u, at.v, at.Ng, id.y, id.x);
    if (anyHit) return true;
  }
  return found;
}

/* Face parameters of vertex i of a grid. Embree stores them in 16 bits each, in units of 8/65536. */
vec2 cbvhGridParameters(CbvhPointer grid, uint first, uint plane, uint i) {
  uint uv = cbvhWord(grid, first + 3u * plane + i);
  return vec2(float(uv & 0xFFFFu), float(uv >> 16)) * (8.0 / 65536.0);
}

/* Intersects a leaf of a grid. index: in SceneData::leaves. */
bool cbvhTraceGridLeaf(SceneData scene, CbvhPreparedRay ray, uint index, const bool anyHit, inout CbvhHit hit) {
  uvec2 leaf = CbvhPairs(scene.leaves).at[index];
  CbvhPointer grid = cbvhPointer(scene, leaf.x);
  uint geomID = grid.geomID;
  if (!cbvhIsVisible(scene, ray, geomID)) return false;
  uint width = cbvhWord(grid, gridWidthWord), plane = cbvhWord(grid, gridPlaneStrideWord);
  uint first = gridDataWord + cbvhWord(grid, gridOffsetWord) / 4u;
  uint quadsX = width > 2u ? 2u : 1u, quads = quadsX * (cbvhWord(grid, gridHeightWord) > 2u ? 2u : 1u);
  bool found = false;
  for (uint triangle = 0u; triangle < 2u * quads; triangle++) {
    uint q = triangle >> 1, i = leaf.y + (q / quadsX) * width + q % quadsX;
    uvec3 corners = cbvhQuadTriangle(i, width, (triangle & 1u) != 0u);
    CbvhTriangleHit at;
    if (!cbvhPluecker(ray, hit.t, cbvhGridVertex(grid, first, plane, corners.x),
                      cbvhGridVertex(grid, first, plane, corners.y), cbvhGridVertex(grid, first, plane, corners.z), at))
      continue;
    found = true;
    vec2 uv = at.u * cbvhGridParameters(grid, first, plane, corners.y) +
              at.v * cbvhGridParameters(grid, first, plane, corners.z) +
              (1.0 - at.u - at.v) * cbvhGridParameters(grid, first, plane, corners.x);
    cbvhSetHit(hit, ray, at.t, uv.x, uv.y, at.Ng, cbvhWord(grid, gridPrimIDWord), geomID);
    if (anyHit) return true;
  }
  return found;
}

#endif
