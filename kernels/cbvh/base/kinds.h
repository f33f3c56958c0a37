// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What is to know of each kind of leaves besides its bytes, which kindFormats of block.h has.
 * A new kind with a frame has a line here and there, an encoder (framed/block_encoder.h lists them), a
 * visitor (scene/kind_visitors1.h) and its value in rtcore_compression.h. */

#include "../framed/block.h"
#include "../../../include/embree3/rtcore_compression.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    struct KindDescription
    {
      RTCCompression compression;
      const char* key;           //!< in device strings, after "cbvh.", and in EMBREE_CBVH
      const char* name;          //!< in messages
      bool alignsToLimit;        //!< frames align to corners before displacement, else after it
      bool takesHoles;           //!< leaves can leave a quad out
      bool hasThickness;         //!< leaves are not exact: a bound on their thickness means something
    };

    /*! by kind. Heights are best stored along the normal of the smooth surface; boxes are
     *  tightest around what they bound. */
    static const KindDescription kindDescriptions[numKinds] = {
      { RTC_COMPRESSION_GRID,  "grid",  "cGRID",  false, true,  false },
      { RTC_COMPRESSION_VOXEL, "voxel", "cVOXEL", false, false, true  },
      { RTC_COMPRESSION_LEAF,  "leaf",  "cLEAF",  true,  true,  true  },
      { RTC_COMPRESSION_VERT,  "vert",  "cVERT",  false, true,  false }
    };

    inline const KindDescription& describe(Kind kind) { return kindDescriptions[uint32_t(kind)]; }

    /*! kind of an RTCCompression; false for those that are none */
    inline bool findKind(int compression, Kind& kind)
    {
      for (uint32_t k=0; k<numKinds; k++)
        if (kindDescriptions[k].compression == compression) { kind = Kind(k); return true; }
      return false;
    }
  }}
}
