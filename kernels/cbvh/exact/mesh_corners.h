// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tests which triangles of half a group a ray's line may pass through, with triangles in lanes. The cache contains
 * vertices rather than corners, because it then holds more groups; each test shears them and permutes them into
 * corners. */

#include "../base/intrinsics.h"
#include "mesh_cache.h"
#include "triangles.h"

namespace embree::isa::cbvh {
/*! Vertices of a group in the sheared space in which the ray is the z axis (cvert/rule/rule.h). capacity: at
 *  least the number of vertices. */
template<int capacity>
class ShearedMesh {
public:
  static const int vectors = (capacity + vectorWidth - 1) / vectorWidth;

  /*! vertices(i,j): vector j of the vertices on the ray's axis kx, ky or kz (i = 0, 1, 2). */
  template<typename Vertices>
  __forceinline ShearedMesh(const VertRay& ray, const Vertices& vertices) {
    const vfloatV orgX(ray.org[ray.kx]), orgY(ray.org[ray.ky]), orgZ(ray.org[ray.kz]), sx(ray.sx), sy(ray.sy);
    for (int j = 0; j < vectors; j++) {
      const vfloatV z = vertices(2, j) - orgZ;
      storeVector(j, nmadd(sx, z, vertices(0, j) - orgX), nmadd(sy, z, vertices(1, j) - orgY));
    }
  }

  /*! Loads sheared x and y of vectorWidth corners. */
#if defined(__AVX512F__)
  __forceinline void loadCorners(__m512i vertex, vfloatV& cornerX, vfloatV& cornerY) const {
    cornerX = vfloatV(_mm512_permutex2var_ps(x[0], vertex, x[vectors - 1]));
    cornerY = vfloatV(_mm512_permutex2var_ps(y[0], vertex, y[vectors - 1]));
  }
#elif defined(__AVX2__)
  __forceinline void loadCorners(__m256i vertex, vfloatV& cornerX, vfloatV& cornerY) const {
    // bits 0 to 2 of a vertex select a lane, bits 3 and 4 a vector; blendv reads the sign bit
    const __m256 bit3 = _mm256_castsi256_ps(_mm256_slli_epi32(vertex, 28)),
                 bit4 = _mm256_castsi256_ps(_mm256_slli_epi32(vertex, 27));
    auto select = [&](const vfloatV* from) {
      auto permute = [&](int j) { return _mm256_permutevar8x32_ps(from[min(j, vectors - 1)], vertex); };
      const __m256 lower = _mm256_blendv_ps(permute(0), permute(1), bit3);
      if (vectors == 2) return vfloatV(lower);
      const __m256 upper = vectors == 3 ? permute(2) : _mm256_blendv_ps(permute(2), permute(vectors - 1), bit3);
      return vfloatV(_mm256_blendv_ps(lower, upper, bit4));
    };
    cornerX = select(x);
    cornerY = select(y);
  }
#else
  template<typename Index>
  __forceinline void loadCorners(const Index* lanes, vfloatV& cornerX, vfloatV& cornerY) const {
#if defined(__AVX__)
    vfloat4 x[2], y[2];
    for (int half = 0; half < 2; half++) loadFour(lanes + 4 * half, x[half], y[half]);
    cornerX = vfloatV(x[0], x[1]);
    cornerY = vfloatV(y[0], y[1]);
#else
    loadFour(lanes, cornerX, cornerY);
#endif
  }
#endif

private:
#if defined(__AVX2__)
  vfloatV x[vectors], y[vectors];

  __forceinline void storeVector(int j, const vfloatV& shearedX, const vfloatV& shearedY) {
    x[j] = shearedX;
    y[j] = shearedY;
  }
#else
  alignas(64) float xy[capacity][2]; //!< x and y together, which halves the number of loads

  __forceinline void storeVector(int j, const vfloatV& shearedX, const vfloatV& shearedY) {
    alignas(64) float at[2][vectorWidth];
    vfloatV::store(at[0], shearedX);
    vfloatV::store(at[1], shearedY);
    for (int i = 0; i < vectorWidth; i += 4) {
      const vfloat4 a = vfloat4::load(at[0] + i), b = vfloat4::load(at[1] + i);
      vfloat4::store(xy[vectorWidth * j + i], unpacklo(a, b));
      vfloat4::store(xy[vectorWidth * j + i + 2], unpackhi(a, b));
    }
  }

  template<typename Index>
  __forceinline void loadFour(const Index* lanes, vfloat4& x, vfloat4& y) const {
    auto two = [&](int i) {
      return _mm_loadh_pi(_mm_loadl_pi(_mm_setzero_ps(), (const __m64*)xy[lanes[i]]), (const __m64*)xy[lanes[i + 1]]);
    };
    const __m128 a = two(0), b = two(2);
    x = vfloat4(_mm_shuffle_ps(a, b, _MM_SHUFFLE(2, 0, 2, 0)));
    y = vfloat4(_mm_shuffle_ps(a, b, _MM_SHUFFLE(3, 1, 3, 1)));
  }
#endif
};

/*! Corner c of triangles n to n+vectorWidth-1, for ShearedMesh::loadCorners. */
__forceinline auto cornersOf(const MeshTriangles& triangles, uint32_t n, int c) {
  const uint8_t* const lanes = triangles.corners[c] + n;
#if defined(__AVX512F__)
  return _mm512_cvtepu8_epi32(_mm_load_si128((const __m128i*)lanes));
#elif defined(__AVX2__)
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)lanes));
#else
  return lanes;
#endif
}

/*! trianglesHitByLine for up to `capacity` vertices, of all 16 lanes. Vertices: see ShearedMesh. Triangles: an argument
 *  of cornersOf(). */
template<int capacity, typename Vertices, typename Triangles>
__forceinline uint32_t lanesHitByLine(const VertRay& ray, const Vertices& vertices, const Triangles& triangles,
                                      SidesInLanes& sides) {
  const ShearedMesh<capacity> mesh(ray, vertices);
  vboolV inside[MeshTriangles::width / vectorWidth];
  for (uint32_t j = 0; j < MeshTriangles::width / vectorWidth; j++) {
    vfloatV x[3], y[3];
    for (int c = 0; c < 3; c++) mesh.loadCorners(cornersOf(triangles, vectorWidth * j, c), x[c], y[c]);
    const vfloatV w0 = edgeSide(x[1], y[1], x[2], y[2]);
    const vfloatV w1 = edgeSide(x[2], y[2], x[0], y[0]);
    const vfloatV w2 = edgeSide(x[0], y[0], x[1], y[1]);
    inside[j] = mayContain(w0, w1, w2);
    sides.set(int(j), w0, w1, w2);
  }
  return movemasks(inside);
}

/*! trianglesHitByLine for up to `capacity` vertices. */
template<int capacity>
__forceinline uint32_t trianglesOfMeshHitByLine(const VertRay& ray, const MeshTriangles& triangles,
                                                SidesInLanes& sides) {
  const float* const axes[3] = {triangles.vertices.at[ray.kx], triangles.vertices.at[ray.ky],
                                triangles.vertices.at[ray.kz]};
  return lanesHitByLine<capacity>(
             ray, [&](int i, int j) { return vfloatV::load(axes[i] + vectorWidth * j); }, triangles, sides) &
         triangles.lanes;
}

/*! Returns the mask of triangles that the ray's line may pass through. Sets the sides of all lanes. */
__forceinline uint32_t trianglesHitByLine(const VertRay& ray, const MeshTriangles& triangles, SidesInLanes& sides) {
  if (triangles.numVertices <= 16) return trianglesOfMeshHitByLine<16>(ray, triangles, sides);
  if (likely(triangles.numVertices <= 24)) return trianglesOfMeshHitByLine<24>(ray, triangles, sides);
  return trianglesOfMeshHitByLine<32>(ray, triangles, sides);
}

/*! The triangle of half a group in a lane. */
__forceinline VertTriangle triangleInLane(const MeshTriangles& triangles, uint32_t lane) {
  const uint8_t vertices[3] = {triangles.corners[0][lane], triangles.corners[1][lane], triangles.corners[2][lane]};
  return VertTriangle(triangles.vertices.at, vertices);
}

/*! GroupTriangles (triangles.h) of a group of a mesh block. */
class MeshGroupTriangles {
public:
  uint32_t mask; //!< of triangles that the ray's line may pass through, see sides()

  /*! Cached: CachedMeshBlock or MovingMeshBlock. */
  template<typename Cached>
  __forceinline MeshGroupTriangles(const VertRay& ray, const Cached& cached, uint32_t g) {
    const MeshTriangles& first = cached.triangles(g, 0);
    const bool hasNextHalf = first.hasNextHalf;
    mask = trianglesHitByLine(ray, first, halves[0]);
    if (unlikely(hasNextHalf)) mask |= trianglesHitByLine(ray, cached.triangles(g, 1), halves[1]) << 16;
  }

  /*! Sides of a triangle. index: of the triangle in the group and of its bit in the mask. */
  __forceinline TriangleSides<float> sides(uint32_t index) const { return halves[index >> 4].at(index & 15u); }

private:
  SidesInLanes halves[2];
};

/* Of a CachedMeshBlock or MovingMeshBlock, for hits1.h: */

template<typename Cached>
__forceinline VertTriangle meshTriangleOf(const Cached& cached, uint32_t g, uint32_t index) {
  return triangleInLane(cached.triangles(g, index >> 4), index & 15);
}

template<typename Cached>
__forceinline MeshGroupTriangles meshTrianglesHitByLine(const VertRay& ray, const Cached& cached, uint32_t g) {
  return MeshGroupTriangles(ray, cached, g);
}
} // namespace embree::isa::cbvh
