// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles of a surface as its blocks hold them, for who asks for them outside of traversal. */

#include "../vert/format.h"
#include "../../../include/embree3/rtcore_compressed_triangles.h"
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace embree
{
  struct SurfaceBlocks;

  namespace cbvh
  {
    /*! Blocks of a surface by their primitives. */
    class BlockIndex
    {
    public:
      /*! Throws where a block is not cVERT. */
      explicit BlockIndex (const SurfaceBlocks& blocks);

      /*! see rtcGetCompressedTriangle */
      bool find (uint32_t primID, float u, float v, const float* Ng, RTCCompressedTriangle& triangle) const;

    private:
      enum : uint32_t { none = 0xFFFFFFFFu };

      std::vector<const VertHeader*> blocks; //!< in the order of primitives
      std::vector<uint32_t> blockOf;         //!< of each primitive, if blocks number their quads; empty if they do not
    };

    /*! Calls closure(part) for the blocks of a surface until it returns false. Throws where one is not cVERT. */
    void forEachPart (const SurfaceBlocks& blocks, const std::function<bool(const RTCCompressedPart&)>& closure);
  }
}
