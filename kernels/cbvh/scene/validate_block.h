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
    /*! False for frames that are not finite, and for those that map all points to one, such as that of a header of zeros. */
    inline bool isFrame(const BlockHeader& header)
    {
      bool isZero = true;
      for (int i=0; i<3; i++) {
        if (!std::isfinite(header.centre[i])) return false;
        for (int k=0; k<4; k++) {
          if (!std::isfinite(header.columns[i][k])) return false;
          isZero &= k == 3 || header.columns[i][k] == 0.0f;
        }
      }
      return !isZero;
    }

    inline const char* errorOfFramedBlock(uint32_t kind, const void* data, size_t bytes)
    {
      if (bytes < blockHeaderBytes) return "fewer bytes than a header has";
      const BlockHeader& header = *(const BlockHeader*)data;
      if (kindOf(header.info) != kind) return "another kind";
      if (heightOf(header.info) > maxLevel) return "a height that is none";
      if (!isFrame(header)) return "a frame that is not finite, or that maps all points to one";
      if (!isPatchCorner(cornerUOf(header.tiling),cornerVOf(header.tiling))) return "a patch whose corner is outside of its face";
      if (blockXOf(header.info) > lastXOf(header.tiling) || blockYOf(header.info) > lastYOf(header.tiling)) return "a place outside of its patch";
      return bytes < blockLayout(kind,heightOf(header.info)).bytes ? "fewer bytes than its nodes and leaves have" : nullptr;
    }

    /*! Null if a block of a kind begins at data and takes at most that many bytes; else what is wrong. */
    inline const char* validateBlock(uint32_t kind, const void* data, size_t bytes) {
      return kind == kindVert ? VertValidation::errorOf(data,bytes) : errorOfFramedBlock(kind,data,bytes);
    }
  }}
}
