// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Parameters of the face of a hit in a block of cVERT. */

#include "format.h"
#include "../../common/isa.h"
#include "../../../common/simd/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class VertParameters
      {
      public:
        __forceinline explicit VertParameters (const VertHeader* block)
          : block(block), quadsX(patchQuadsX(block->rates)), quadsY(patchQuadsY(block->rates)) {}

        /*! whether some edge has a lower rate than the one opposite */
        __forceinline bool isStitched () const {
          return vertRate(block->rates,0) != vertRate(block->rates,2) || vertRate(block->rates,1) != vertRate(block->rates,3);
        }

        /*! quad of the patch that is the first of a group */
        __forceinline uint32_t firstX (uint32_t g) const { return vertX(block->place) + groupQuads*(g & 3); }
        __forceinline uint32_t firstY (uint32_t g) const { return vertY(block->place) + groupQuads*(g >> 2); }

        /*! Of position (a,b) of quad (x,y) of the patch: interpolated from
         *  those of the triangle's vertices, which Embree stitches where an edge has a lower rate. */
        __forceinline void set (uint32_t x, uint32_t y, uint32_t triangle, float a, float b, float& u, float& v) const
        {
          if (unlikely(isStitched() && (x == 0 || y == 0 || x+1 == quadsX || y+1 == quadsY))) setStitched(x,y,triangle,inUnit(a),inUnit(b),u,v);
          else set<float>(float(x),float(y),a,b,u,v);
        }

        /*! the same where edges have one rate; numbers are floats, or vectors */
        template<typename Real>
        __forceinline void set (const Real& x, const Real& y, const Real& a, const Real& b, Real& u, Real& v) const
        {
          u = Real(0.5f*float(vertCornerU(block->place))) + max((x + inUnit(a))/Real(float(quadsX)),Real(0.0f));
          v = Real(0.5f*float(vertCornerV(block->place))) + max((y + inUnit(b))/Real(float(quadsY)),Real(0.0f));
        }

      private:
        void setStitched (uint32_t x, uint32_t y, uint32_t triangle, float a, float b, float& u, float& v) const
        {
          /* barycentrics of 00, 10, 01, 11 */
          const float w[4] = { triangle ? 0.0f : 1.0f-a-b, triangle ? 1.0f-b : a, triangle ? 1.0f-a : b, triangle ? a+b-1.0f : 0.0f };
          float s = 0.0f, t = 0.0f;
          for (uint32_t c=0; c<4; c++) {
            const uint32_t i = x + (c & 1), j = y + (c >> 1);
            s += w[c]*vertParameter<float>(i,quadsX,j == 0 ? vertRate(block->rates,0) : j == quadsY ? vertRate(block->rates,2) : quadsX);
            t += w[c]*vertParameter<float>(j,quadsY,i == 0 ? vertRate(block->rates,3) : i == quadsX ? vertRate(block->rates,1) : quadsY);
          }
          u = 0.5f*float(vertCornerU(block->place)) + max(s,0.0f);
          v = 0.5f*float(vertCornerV(block->place)) + max(t,0.0f);
        }

        /*! what is not a number, of slivers, becomes the middle of the diagonal: both triangles have it */
        template<typename Real>
        static __forceinline Real inUnit (const Real& x) { return select(x >= Real(0.0f),min(x,Real(1.0f)),select(x < Real(0.0f),Real(0.0f),Real(0.5f))); }

        const VertHeader* block;
        const uint32_t quadsX, quadsY;
      };
    }
  }
}
