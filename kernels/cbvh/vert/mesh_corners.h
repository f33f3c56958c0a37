// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The corners of the triangles of a group of a mesh block, sheared for a ray: each vertex is sheared once, then the
 * corners are picked from registers. */

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
        static const int vectors = 32/vectorWidth;

      public:
        __forceinline MeshCornersV (const VertRay& ray, const MeshTriangles& triangles) : triangles(triangles)
        {
          for (int j=0; j<vectors && (j < few || uint32_t(vectorWidth*j) < triangles.numVertices); j++) {
            const int n = vectorWidth*j;
            const vfloatV z = vfloatV::load(triangles.at[ray.kz]+n) - vfloatV(ray.org[ray.kz]);
            x[j] = nmadd(vfloatV(ray.sx),z,vfloatV::load(triangles.at[ray.kx]+n) - vfloatV(ray.org[ray.kx]));
            y[j] = nmadd(vfloatV(ray.sy),z,vfloatV::load(triangles.at[ray.ky]+n) - vfloatV(ray.org[ray.ky]));
          }
        }

        /*! Sets the corners of the triangles in the lanes from n on. */
        __forceinline void get (uint32_t n, vfloatV outX[3], vfloatV outY[3]) const
        {
          for (int c=0; c<3; c++)
          {
            const uint8_t* const corners = triangles.corners[c]+n;
#if defined(__AVX512F__)
            const __m512i index = _mm512_cvtepu8_epi32(_mm_load_si128((const __m128i*)corners));
            outX[c] = _mm512_permutex2var_ps(x[0],index,x[1]);
            outY[c] = _mm512_permutex2var_ps(y[0],index,y[1]);
#elif defined(__AVX2__)
            const __m256i index = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)corners));
            outX[c] = pick(x,index);
            outY[c] = pick(y,index);
#else
            alignas(64) float ofX[vectorWidth], ofY[vectorWidth];
            for (int i=0; i<vectorWidth; i++) {
              const int v = corners[i] & 31; // lanes without a triangle may have any number
              ofX[i] = ((const float*)x)[v];
              ofY[i] = ((const float*)y)[v];
            }
            outX[c] = vfloatV::load(ofX);
            outY[c] = vfloatV::load(ofY);
#endif
          }
        }

      private:
#if defined(__AVX2__) && !defined(__AVX512F__)
        static const int few = 2; //!< vectors of vertices that most groups have

        __forceinline vfloatV pick (const vfloatV* from, __m256i index) const
        {
          const __m256 bit3 = _mm256_castsi256_ps(_mm256_slli_epi32(index,28));
          const __m256 lower = _mm256_blendv_ps(_mm256_permutevar8x32_ps(from[0],index),
            _mm256_permutevar8x32_ps(from[1],index),bit3);
          if (likely(triangles.numVertices <= 16)) return lower;
          const __m256 upper = _mm256_blendv_ps(_mm256_permutevar8x32_ps(from[2],index),
            _mm256_permutevar8x32_ps(from[3],index),bit3);
          return _mm256_blendv_ps(lower,upper,_mm256_castsi256_ps(_mm256_slli_epi32(index,27)));
        }
#else
        static const int few = vectors;
#endif

        const MeshTriangles& triangles;
        vfloatV x[vectors], y[vectors];
      };

      /*! Returns the lanes of triangles that a ray's line goes through, or may go through, as GroupTriangles does. */
      __forceinline uint32_t trianglesAround (const VertRay& ray, const MeshTriangles& triangles)
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
