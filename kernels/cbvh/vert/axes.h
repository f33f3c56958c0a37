// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The axes of the boxes of a block of cVERT, from its header. */

#include "cache.h"
#include "../base/codec.h"
#include "../../cvert/rule/rule.h"
#include "../embree/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! vertSpacing(), by vectors */
      __forceinline VertSpacing spacingOf (uint32_t word, const uint32_t corners[6])
      {
        const __m128i values = _mm_loadu_si128((const __m128i*)corners);
        const uint32_t bits = uint32_t(_mm_movemask_epi8(_mm_packs_epi16(values,_mm_slli_epi16(values,1)))); // signs: bits 15, then bits 14
        VertSpacing spacing;
        spacing.at[0] = floatOfBits((word >> 24) << 23);
        spacing.at[1] = floatOfBits((bits & 255u) << 23);
        spacing.at[2] = floatOfBits((bits >> 8) << 23);
        return spacing;
      }

      /*! the shear of boxes; the axes are those of the world if there is none */
      __forceinline void setShear (uint32_t form, bool isSheared, VertAxes& axes)
      {
        axes.axis = likely(isSheared) ? shearedAxis(form) : 3;
        for (int k=0; k<3; k++) axes.shear[k] = 0.0f;
        if (likely(isSheared))
          for (int i=0; i<3; i++) axes.shear[axisAfter(axes.axis,i)] = shearOf(form,i);
      }

      /*! Not the extent of a raw block, which is that of its planes. */
      __forceinline void setAxes (const VertHeader* block, VertAxes& axes)
      {
        const bool raw = isRaw(block->boxForm);
        const float extent = unlikely(raw) ? 0.0f : vertExtent(block->boxForm,block->reach,reachStep(block->boxForm),spacingOf(block->word,block->corners));
        setShear(block->boxForm,!raw,axes);
        for (int k=0; k<3; k++) {
          axes.origin[k] = block->origin[k];
          axes.extent[k] = extent;
        }
      }
    }
  }
}
