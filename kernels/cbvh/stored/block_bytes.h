// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How many bytes a block takes. */

#include "../framed/block.h"
#include "../base/codec.h"
#include "../../cvert/format/motion.h"

namespace embree
{
  namespace cbvh
  {
    /*! isVert: cVERT, moving or not; else a block with a frame */
    inline uint32_t bytesOfBlock (const void* block, bool isVert) {
      return isVert ? vertBytes((const VertHeader*)block) : uint32_t(((const Block*)block)->layout().bytes);
    }
  }
}
