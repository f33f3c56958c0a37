// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tests which triangles of half a group a ray's line may pass through, with triangles in lanes. The cache contains
 * vertices rather than corners, because it then holds more groups; each test shears them and permutes them into
 * corners. */

#include "../base/intrinsics.h"
#include "mesh_cache.h"
#include "ray.h"

namespace embree::isa::cbvh {
/*! Vertices of a group in the sheared space in which the ray is the z axis (cvert/rule/rule.h). capacity: at
 *  least the number of vertices. */
template<int capacity>
class ShearedMesh {
public:
  __forceinline ShearedMesh(const VertRay& ray, const MeshTriangles& triangles) : corners(triangles.corners) {
    const float(&at)[3][32] = triangles.vertices.at;
    const vfloatV orgX(ray.org[ray.kx]), orgY(ray.org[ray.ky]), orgZ(ray.org[ray.kz]), sx(ray.sx), sy(ray.sy);
    for (int j = 0; j < vectors; j++) {
      const int n = vectorWidth * j;
      const vfloatV z = vfloatV::load(at[ray.kz] + n) - orgZ;
      storeVector(j, nmadd(sx, z, vfloatV::load(at[ray.kx] + n) - orgX),
                  nmadd(sy, z, vfloatV::load(at[ray.ky] + n) - orgY));
    }
  }

  /*! Loads sheared x and y of corner c of triangles n to n+vectorWidth-1. */
  __forceinline void loadCorners(uint32_t n, int c, vfloatV& cornerX, vfloatV& cornerY) const {
    const uint8_t* const lanes = corners[c] + n;
#if defined(__AVX512F__)
    const __m512i vertex = _mm512_cvtepu8_epi32(_mm_load_si128((const __m128i*)lanes));
    cornerX = vfloatV(_mm512_permutex2var_ps(x[0], vertex, x[vectors - 1]));
    cornerY = vfloatV(_mm512_permutex2var_ps(y[0], vertex, y[vectors - 1]));
#elif defined(__AVX2__)
    const __m256i vertex = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)lanes));
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
#elif defined(__AVX__)
    vfloat4 x[2], y[2];
    for (int half = 0; half < 2; half++) loadFour(lanes + 4 * half, x[half], y[half]);
    cornerX = vfloatV(x[0], x[1]);
    cornerY = vfloatV(y[0], y[1]);
#else
    loadFour(lanes, cornerX, cornerY);
#endif
  }

private:
  static const int vectors = (capacity + vectorWidth - 1) / vectorWidth;

  const uint8_t (&corners)[3][16];
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

  __forceinline void loadFour(const uint8_t* lanes, vfloat4& x, vfloat4& y) const {
    auto two = [&](int i) {
      return _mm_loadh_pi(_mm_loadl_pi(_mm_setzero_ps(), (const __m64*)xy[lanes[i]]), (const __m64*)xy[lanes[i + 1]]);
    };
    const __m128 a = two(0), b = two(2);
    x = vfloat4(_mm_shuffle_ps(a, b, _MM_SHUFFLE(2, 0, 2, 0)));
    y = vfloat4(_mm_shuffle_ps(a, b, _MM_SHUFFLE(3, 1, 3, 1)));
  }
#endif
};

/*! trianglesHitByLine for up to `capacity` vertices. */
template<int capacity>
__forceinline uint32_t trianglesOfMeshHitByLine(const VertRay& ray, const MeshTriangles& triangles,
                                                SidesInLanes& sides) {
  const ShearedMesh<capacity> mesh(ray, triangles);
  vboolV inside[MeshTriangles::width / vectorWidth];
  for (uint32_t j = 0; j < MeshTriangles::width / vectorWidth; j++) {
    vfloatV x[3], y[3];
    for (int c = 0; c < 3; c++) mesh.loadCorners(vectorWidth * j, c, x[c], y[c]);
    const vfloatV w0 = edgeSide(x[1], y[1], x[2], y[2]);
    const vfloatV w1 = edgeSide(x[2], y[2], x[0], y[0]);
    const vfloatV w2 = edgeSide(x[0], y[0], x[1], y[1]);
    inside[j] = mayContain(w0, w1, w2);
    sides.set(int(j), w0, w1, w2);
  }
  return movemasks(inside) & triangles.lanes;
}

/*! Returns the mask of triangles that the ray's line may pass through. Sets the sides of all lanes. */
__forceinline uint32_t trianglesHitByLine(const VertRay& ray, const MeshTriangles& triangles, SidesInLanes& sides) {
  if (triangles.numVertices <= 16) return trianglesOfMeshHitByLine<16>(ray, triangles, sides);
  if (likely(triangles.numVertices <= 24)) return trianglesOfMeshHitByLine<24>(ray, triangles, sides);
  return trianglesOfMeshHitByLine<32>(ray, triangles, sides);
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
} // namespace embree::isa::cbvh
