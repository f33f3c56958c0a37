// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of cLEAF's groups, codec/leaf.h, for the four leaves at once and mirrored with the
 * ray. */

#include "mirrored_ray.h"
#include "../codec/leaf.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! the surfaces of four leaves; lane l is child l ^ flip */
      struct GroupPatches
      {
        vfloat4 base;           //!< z at height 0
        vfloat4 bin;            //!< negative where z is mirrored
        vfloat4 q, a, b, twist; //!< height = q + a u + b v + twist u v, in bins
        vfloat4 rcpX, rcpY;     //!< of the boxes' extents
        vfloat4 reach;          //!< half of the thickness, in z
        size_t solid, empty;

        __forceinline vfloat4 z (const vfloat4& u, const vfloat4& v) const { return madd(bin,madd(u,a,madd(v,madd(u,twist,b),q)),base); }
        __forceinline float slopeX (size_t i, float v) const { return (solid >> i) & 1 ? 0.0f : bin[i]*(a[i]+v*twist[i])*rcpX[i]; }
        __forceinline float slopeY (size_t i, float u) const { return (solid >> i) & 1 ? 0.0f : bin[i]*(b[i]+u*twist[i])*rcpY[i]; }

        /*! a group's surfaces and, in c, its boxes; bits: its heights */
        __forceinline void decode (uint32_t word, uint64_t bits, const ParentBox& parent, const MirroredRay& ray, ChildBoxes& c)
        {
          if (likely(!(bits >> 63))) decodeLattice(word,bits,parent,ray,c);
          else decodeLoose(word,bits,parent,ray,c);
          rcpX = vfloat4(one)/c.extent[0];
          rcpY = vfloat4(one)/c.extent[1];
        }

      private:
        __forceinline void setHeights (const vfloat4& q00, const vfloat4& q10, const vfloat4& q01, const vfloat4& q11)
        {
          q = q00 + vfloat4(0.5f);
          a = q10-q00;
          b = q01-q00;
          twist = (q11-q01)-a;
        }

        /*! bins are centred on a box; with z -> 1-z they are their mirror image */
        __forceinline void setBins (float range, int bins, const MirroredRay& ray, const vfloat4& lower, const vfloat4& extent)
        {
          const float size = range/float(bins);
          bin = vfloat4(ray.flip[2] ? -size : size)*extent;
          base = madd(vfloat4(ray.flip[2] ? 0.5f*(range+1.0f) : 0.5f*(1.0f-range)),extent,lower);
        }

        __forceinline void decodeLattice (uint32_t word, uint64_t bits, const ParentBox& parent, const MirroredRay& ray, ChildBoxes& c)
        {
          for (int axis=0; axis<2; axis++)
          {
            const uint32_t planes = word >> latticeShift(axis);
            const float o0 = nodeTables.latticeOuter[planes & latticePlaneMask];
            const float o1 = nodeTables.latticeOuter[(planes >> 5) & latticePlaneMask];
            const float m = latticeMiddle((planes >> 10) & latticePlaneMask);
            const float p0 = ray.flip[axis] ? o1 : o0, p1 = ray.flip[axis] ? 1.0f-m : m, p2 = 1.0f-(ray.flip[axis] ? o0 : o1);
            const vfloat4 n = axis ? vfloat4(p0,p0,p1,p1) : vfloat4(p0,p1,p0,p1);
            const vfloat4 f = axis ? vfloat4(p1,p1,p2,p2) : vfloat4(p1,p2,p1,p2);
            c.lower[axis] = madd(n,parent.extent[axis],parent.lower[axis]);
            c.extent[axis] = madd(f,parent.extent[axis],parent.lower[axis]) - c.lower[axis];
          }

          vfloat4 corner[4];
          latticeCorners(bits,ray.flipXY(),corner);
          setHeights(corner[0],corner[1],corner[2],corner[3]);
          setBins(latticeRange,latticeBins,ray,parent.lower[2],parent.extent[2]);
          reach = vfloat4(0.5f*latticeThickness(word >> latticeThicknessShift))*abs(bin);
          const vfloat4 lowest  = madd(bin,min(min(corner[0],corner[1]),min(corner[2],corner[3]))+vfloat4(0.5f),base);
          const vfloat4 highest = madd(bin,max(max(corner[0],corner[1]),max(corner[2],corner[3]))+vfloat4(0.5f),base);
          c.lower[2] = max(min(lowest,highest)-reach,parent.lower[2]);
          c.extent[2] = max(min(max(lowest,highest)+reach,parent.lower[2]+parent.extent[2])-c.lower[2],vfloat4(zero));
          solid = empty = 0;
        }

        /*! the nine heights at the corners of the four cells */
        static __forceinline void latticeCorners (uint64_t bits, int flip, vfloat4 corner[4])
        {
          const __m128i bytes = _mm_cvtsi64_si128((long long)bits);
          const int middle = _mm_movemask_epi8(bytes) & 127;
          const __m128i nine = _mm_insert_epi16(_mm_and_si128(bytes,_mm_set1_epi8(127)),middle,4);
          for (int k=0; k<4; k++) corner[k] = vfloat4(vint4(pickBytes(nine,nodeTables.latticeCorner[flip][k])));
        }

        /*! 4 integers out of 16 bytes; control as of _mm_shuffle_epi8 */
        static __forceinline __m128i pickBytes (const __m128i& bytes, const uint8_t control[16])
        {
#if defined(__SSSE3__)
          return _mm_shuffle_epi8(bytes,_mm_load_si128((const __m128i*)control));
#else
          alignas(16) uint8_t b[16];
          _mm_store_si128((__m128i*)b,bytes);
          return _mm_set_epi32(b[control[12]],b[control[8]],b[control[4]],b[control[0]]);
#endif
        }

        __forceinline void decodeLoose (uint32_t word, uint64_t bits, const ParentBox& parent, const MirroredRay& ray, ChildBoxes& c)
        {
          ray.decode(word,parent,c);
          const int flip = ray.flipXY();
          auto lane = [&](int l) { return int(uint32_t(bits >> (looseBits*(l^flip))) & looseMask); };
          const vint4 leaf(lane(0),lane(1),lane(2),lane(3));
          solid = movemask(vboolf4(leaf == vint4(int(solidLeaf))));
          empty = movemask(vboolf4(leaf == vint4(int(emptyLeaf))));

          vfloat4 corner[4];
          for (int k=0; k<3; k++) corner[k] = vfloat4((leaf >> (5*k)) & vint4(31));
          corner[3] = corner[1]+corner[2]-corner[0];
          setHeights(corner[flip],corner[flip^1],corner[flip^2],corner[flip^3]);
          setBins(looseRange,looseBins,ray,c.lower[2],c.extent[2]);
          reach = vfloat4(0.5f*looseThickness(uint32_t(bits >> looseThicknessShift) & 7u))*abs(bin);
        }
      };
    }
  }
}
