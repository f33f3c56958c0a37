// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Corners of a group's triangles, sheared for a ray. */

#include "mesh_cache.h"
#include "ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class MeshCornersV
      {
#if defined(__AVX512F__)
      public:
        __forceinline MeshCornersV (const VertRay& ray, const MeshTriangles& triangles) : triangles(triangles)
        {
          for (int j=0; j<2; j++) shear(ray,triangles,16*j,x[j],y[j]);
        }

        __forceinline void get (uint32_t n, vfloatV outX[3], vfloatV outY[3]) const
        {
          for (int c=0; c<3; c++) {
            const __m512i index = _mm512_cvtepu8_epi32(_mm_load_si128((const __m128i*)(triangles.corners[c]+n)));
            outX[c] = _mm512_permutex2var_ps(x[0],index,x[1]);
            outY[c] = _mm512_permutex2var_ps(y[0],index,y[1]);
          }
        }

      private:
        vfloatV x[2], y[2];
#else
      public:
        __forceinline MeshCornersV (const VertRay& ray, const MeshTriangles& triangles) : triangles(triangles)
        {
          for (uint32_t n=0; n<triangles.numVertices; n+=vectorWidth)
          {
            vfloatV x, y;
            shear(ray,triangles,n,x,y);
            const vfloatV low = unpacklo(x,y), high = unpackhi(x,y);
            for (int half=0; half<vectorWidth/4; half++) {
              _mm_store_ps(xy[n+4*half],quarter(low,half));
              _mm_store_ps(xy[n+4*half+2],quarter(high,half));
            }
          }
        }

        /*! Loads of pairs are faster than permutations of vectors: 40 instead of 64 ns per group on a Zen processor. */
        __forceinline void get (uint32_t n, vfloatV outX[3], vfloatV outY[3]) const
        {
          for (int c=0; c<3; c++)
          {
            const uint8_t* const corners = triangles.corners[c]+n;
            auto two = [&](int i) { // lanes without a triangle may have any number
              const __m128 first = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i*)xy[corners[i] & 31]));
              return _mm_loadh_pi(first,(const __m64*)xy[corners[i+1] & 31]);
            };
#if defined(__AVX__)
            const __m256 a = _mm256_insertf128_ps(_mm256_castps128_ps256(two(0)),two(4),1),
              b = _mm256_insertf128_ps(_mm256_castps128_ps256(two(2)),two(6),1);
            outX[c] = _mm256_shuffle_ps(a,b,_MM_SHUFFLE(2,0,2,0));
            outY[c] = _mm256_shuffle_ps(a,b,_MM_SHUFFLE(3,1,3,1));
#else
            const __m128 a = two(0), b = two(2);
            outX[c] = _mm_shuffle_ps(a,b,_MM_SHUFFLE(2,0,2,0));
            outY[c] = _mm_shuffle_ps(a,b,_MM_SHUFFLE(3,1,3,1));
#endif
          }
        }

      private:
#if defined(__AVX__)
        static __forceinline __m128 quarter (const vfloatV& v, int half) {
          return half ? _mm256_extractf128_ps(v,1) : _mm256_castps256_ps128(v);
        }
#else
        static __forceinline __m128 quarter (const vfloatV& v, int) { return v; }
#endif

        alignas(64) float xy[32][2]; //!< x and y per vertex
#endif

        static __forceinline void shear (const VertRay& ray, const MeshTriangles& triangles, uint32_t n, vfloatV& x,
                                           vfloatV& y)
        {
          const vfloatV z = vfloatV::load(triangles.at[ray.kz]+n) - vfloatV(ray.org[ray.kz]);
          x = nmadd(vfloatV(ray.sx),z,vfloatV::load(triangles.at[ray.kx]+n) - vfloatV(ray.org[ray.kx]));
          y = nmadd(vfloatV(ray.sy),z,vfloatV::load(triangles.at[ray.ky]+n) - vfloatV(ray.org[ray.ky]));
        }

        const MeshTriangles& triangles;
      };

      /*! GroupTriangles::mask for a mesh block */
      __forceinline uint32_t trianglesHitByLine (const VertRay& ray, const MeshTriangles& triangles)
      {
        const MeshCornersV corners(ray,triangles);
        uint32_t mask = 0;
        for (uint32_t n=0; n<maxGroupTriangles && (triangles.lanes >> n) != 0; n+=vectorWidth)
        {
          vfloatV x[3], y[3];
          corners.get(n,x,y);
          const vboolV inside = isInside(edgeSide(x[1],y[1],x[2],y[2]),edgeSide(x[2],y[2],x[0],y[0]),
            edgeSide(x[0],y[0],x[1],y[1]));
          mask |= uint32_t(movemask(inside)) << n;
        }
        return mask & triangles.lanes;
      }
    }
  }
}
