// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The axes of the boxes of a block of cVERT, from its header. */

#include "cache.h"
#include "format.h"
#include "../embree/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! the shear of boxes; the axes are those of the world if there is none */
      __forceinline void setShear (uint32_t form, bool isSheared, VertAxes& axes)
      {
        axes.axis = likely(isSheared) ? shearedAxis(form) : 3;
        for (int k=0; k<3; k++) axes.shear[k] = 0.0f;
        if (likely(isSheared))
          for (int i=0; i<3; i++) axes.shear[axisAfter(axes.axis,i)] = i == 0 ? 1.0f : float(shearSlope(form,i))*(1.0f/16.0f);
      }

      /*! Not the extent of a raw block, which is that of its planes. */
      __forceinline void setAxes (const VertHeader* block, VertAxes& axes)
      {
        setShear(block->boxForm,!isRaw(block->boxForm),axes);
        for (int k=0; k<3; k++) {
          axes.origin[k] = block->origin[k];
          axes.extent[k] = float(maxExtent)*vertSpacing(block->word);
        }
      }
    }
  }
}
