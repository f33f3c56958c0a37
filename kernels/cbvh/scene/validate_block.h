// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether bytes are a block of a kind that readers may take. */

#include "../framed/block.h"
#include "../vert/validate.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    inline const char* errorOfFramedBlock(uint32_t kind, const void* data, size_t bytes)
    {
      if (bytes < blockHeaderBytes) return "fewer bytes than a header has";
      const BlockHeader& header = *(const BlockHeader*)data;
      if (kindOf(header.info) != kind) return "another kind";
      if (heightOf(header.info) > maxLevel) return "a height that is none";
      if (blockXOf(header.info) > lastXOf(header.tiling) || blockYOf(header.info) > lastYOf(header.tiling)) return "a place outside of its patch";
      return bytes < blockLayout(kind,heightOf(header.info)).bytes ? "fewer bytes than its nodes and leaves have" : nullptr;
    }

    /*! Null if a block of a kind begins at data and takes at most that many bytes; else what is wrong. */
    inline const char* validateBlock(uint32_t kind, const void* data, size_t bytes) {
      return kind == kindVert ? VertValidation::errorOf(data,bytes) : errorOfFramedBlock(kind,data,bytes);
    }
  }}
}
