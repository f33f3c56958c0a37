// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersects a ray with the boxes of a mesh block as they are stored, in bytes: most visits of a block need no more of
 * it, and decoded boxes take five times the memory. */

#include "../../cvert/format/mesh_block.h"
#include "boxes.h"
#include "quad_corners.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! The distance to a plane is its byte times `step`, plus nearAtZero or farAtZero, by axis. On the sheared axis
       *  they belong to the sheared coordinate. Vectors of four ignore the float after an array of three. */
      class StoredBoxes
      {
      public:
        /*! False for blocks with ranks, or a spacing above 2^64. */
        static __forceinline bool support (const MeshHeader* block)
        {
          const uint32_t below = block->spacings - 0x010101u; // biased exponents, minus 1
          return (below & (below << 1) & 0x808080u) == 0;     // from 0 to 190
        }

        /*! False if products of floats may be wrong. Then intersect() must not be called. */
        bool isUsable;

        /*! block: must be supported. */
        __forceinline StoredBoxes (const VertRay& ray, const MeshHeader* block)
        {
          const uint32_t form = block->form,
            shifts = (form & 0xFu) | (form & 0xF0u) << 4 | (form & 0xF00u) << 8; // a byte per axis
          const vint4 stored = bytesOf(block->spacings), exponents = max(stored,vint4(leastExponent));
          // Coordinates of a plane across an axis are 0, and have the least spacing: its boxes need not be told apart.
          const vboolf4 isPlane = stored < vint4(leastExponent);
          const vfloat4 size = powersOfTwo(exponents + bytesOf(shifts)), extent = vfloat4(256.0f)*size;
          vfloat4 from = vfloat4::loadu(block->origin) - vfloat4::loadu(ray.org), rcp = vfloat4::loadu(ray.rcp);
          vfloat4 slack = madd(vfloat4(slackOfPlanes*floatUlp),extent + abs(from),select(isPlane,extent,vfloat4(zero)))
            *abs(rcp);
          isUsable = (movemask(isPlane) & 7) != 7; // otherwise the block is tiny
          if ((form & 0x03FF0000u) != 0) shear(ray,block,isPlane,exponents,extent,from,rcp,slack);
          const vfloat4 scale = size*rcp, magnitude = abs(scale);
          // no product is infinite, or rounds to 0
          isUsable &= (movemask((magnitude >= vfloat4(1e-30f)) & (magnitude <= vfloat4(1e30f))) & 7) == 7;
          const vfloat4 atZero = from*rcp, perByte = select(isPlane,vfloat4(zero),scale), above = atZero + perByte;
          const vboolf4 isDescending = rcp < vfloat4(zero);
          vfloat4::store(step,perByte);
          vfloat4::store(nearAtZero,select(isDescending,above,atZero) - slack);
          vfloat4::store(farAtZero,select(isDescending,atZero,above) + slack);
          descends = uint32_t(movemask(isDescending));
        }

        /*! As intersectGroupBoxes. */
        __forceinline uint32_t intersect (const MeshHeader* block, float tnear, float tfar, float enter[16]) const
        {
          const int vectors = QuadCornersV::vectors;
          const uint32_t groups = meshGroups(block->counts);
          const uint8_t* const bytes = (const uint8_t*)block + meshLayout(block->counts).boxes;
          vfloatV tNear[vectors], tFar[vectors];
#pragma GCC unroll 4
          for (int j=0; j<vectors; j++) { tNear[j] = vfloatV(tnear); tFar[j] = vfloatV(tfar); }
#pragma GCC unroll 3
          for (uint32_t k=0; k<3; k++)
          {
            const __m128i lower = _mm_loadu_si128((const __m128i*)(bytes + k*groups)),
              upper = _mm_add_epi8(lower,_mm_loadu_si128((const __m128i*)(bytes + (3+k)*groups)));
            // no branch, which would be mispredicted
            const __m128i swapped = _mm_and_si128(_mm_xor_si128(lower,upper),_mm_set1_epi32(-int((descends >> k) & 1)));
            const __m128i nearer = _mm_xor_si128(lower,swapped), farther = _mm_xor_si128(upper,swapped);
            const vfloatV perByte(step[k]), ofNear(nearAtZero[k]), ofFar(farAtZero[k]);
#pragma GCC unroll 4
            for (int j=0; j<vectors; j++) {
              tNear[j] = max(tNear[j],madd(floatsOf(nearer,j),perByte,ofNear));
              tFar [j] = min(tFar [j],madd(floatsOf(farther,j),perByte,ofFar));
            }
          }
          vboolV open[vectors];
#pragma GCC unroll 4
          for (int j=0; j<vectors; j++) {
            vfloatV::store(enter+vectorWidth*j,tNear[j]);
            open[j] = tNear[j] <= tFar[j];
          }
          return lanesOf(open) & ((1u << groups)-1);
        }

      private:
        /*! slackUlps allows 3 ulps for each distance to a plane. Here it is 1/2 more: 1/2 each for the difference of
         *  origins, the reciprocal, their product, a byte's product, the plane above, and two sums. */
        static constexpr float slackOfPlanes = slackUlps + 1.0f;

        static const int leastExponent = 80;

        static __forceinline vint4 bytesOf (uint32_t bytes)
        {
          const __m128i none = _mm_setzero_si128();
          return vint4(_mm_unpacklo_epi16(_mm_unpacklo_epi8(_mm_cvtsi32_si128(int(bytes)),none),none));
        }

        static __forceinline vfloat4 powersOfTwo (const vint4& biasedExponents) {
          return asFloat(biasedExponents << 23);
        }

        /*! Replaces the sheared axis by the sheared coordinate. */
        __forceinline void shear (const VertRay& ray, const MeshHeader* block, const vboolf4& isPlane,
                                  const vint4& exponents, const vfloat4& extent, vfloat4& from, vfloat4& rcp,
                                  vfloat4& slack)
        {
          alignas(16) static const int axes[5][4] =
            { { -1,0,0,0 },{ 0,-1,0,0 },{ 0,0,-1,0 },{ -1,0,0,0 },{ 0,-1,0,0 } };
          const uint32_t form = block->form, m = min(meshShearedAxis(form),2u),
            exponent = (block->spacings >> (8*m)) & 255u;
          auto onAxis = [&](uint32_t i, const vint4& x) { return vint4::load(axes[m+i]) & x; };
          // the floats 16, s1 and s2 in 1/16
          const vint4 slopes = onAxis(0,vint4(16)) | onAxis(1,vint4(meshSlope(form,1)))
            | onAxis(2,vint4(meshSlope(form,2)));
          const vint4 ratios = vint4(int(exponent)) - exponents;
          const vfloat4 shears = vfloat4(slopes)*powersOfTwo(ratios + vint4(127-4)),
            spans = abs(shears)*(extent + abs(from));
          vfloat4 x, y, z;
          transpose(shears*from,shears*vfloat4::loadu(ray.dir),spans,vfloat4(zero),x,y,z);
          alignas(16) float sums[4]; // ray's origin and direction, and reach
          vfloat4::store(sums,x+y+z);
          // axis m reaches further by the share of the other axes, and by rounding
          const float spacing = floatOfBits(exponent << 23), reach = 2.0f*sums[2] + spacing,
            reciprocal = directionReciprocal(sums[1],ray.largest);
          isUsable &= reach <= 1e30f && (movemask(isPlane & (slopes != vint4(zero))) & 7) == 0;
          const vboolf4 isSheared = vint4::load(axes[m]) < vint4(zero);
          from = select(isSheared,vfloat4(sums[0]),from);
          rcp = select(isSheared,vfloat4(reciprocal),rcp);
          // the coordinate is rounded by up to 1/2
          slack = select(isSheared,vfloat4((shearedSlack(reach) + 0.5f*spacing)*std::fabs(reciprocal)),slack);
        }

        /*! Bytes of vector j. */
        static __forceinline vfloatV floatsOf (__m128i bytes, int j)
        {
#if defined(__AVX512F__)
          return vfloatV(vintV(_mm512_cvtepu8_epi32(bytes)));
#elif defined(__AVX2__)
          return vfloatV(vintV(_mm256_cvtepu8_epi32(j ? _mm_unpackhi_epi64(bytes,bytes) : bytes)));
#else
          const __m128i none = _mm_setzero_si128();
          auto four = [&](int i) {
            const __m128i words = i & 2 ? _mm_unpackhi_epi8(bytes,none) : _mm_unpacklo_epi8(bytes,none);
            return vfloat4(vint4(i & 1 ? _mm_unpackhi_epi16(words,none) : _mm_unpacklo_epi16(words,none)));
          };
#if defined(__AVX__)
          return vfloatV(four(2*j),four(2*j+1));
#else
          return four(j);
#endif
#endif
        }

        alignas(16) float step[4], nearAtZero[4], farAtZero[4];
        uint32_t descends;
      };
    }
  }
}
