// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The public structs of include/embree3 that may grow (core/struct_size.h), and their conversion from internal structs.
 * For the files rtcore_*.cpp of this folder. */

#include "../core/struct_size.h"
#include "../embree/scene.h"
#include "../../../include/embree3/rtcore_compressed_clusters.h"
#include "../../../include/embree3/rtcore_compressed_files.h"
#include "../../../include/embree3/rtcore_dicing.h"
#include "../base/surface_statistics.h"
#include "../stored/part.h"

namespace embree
{
  namespace core
  {
    /* The second argument never changes: the last member in the first version that has the struct. */
    CBVH_GROWING_STRUCT(RTCCompressionArguments,progressUserPtr);
    CBVH_GROWING_STRUCT(RTCCompressionStatistics,cacheBytesPerThread);
    CBVH_GROWING_STRUCT(RTCCompressedFileGeometryInfo,bytes);
    CBVH_GROWING_STRUCT(RTCDicingArguments,maxRates);
    CBVH_GROWING_STRUCT(RTCCompressedClusterReport,numTrianglesOf);
  }

  inline void require (const void* argument, const char* name) {
    if (!argument) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,std::string(name) + " is NULL");
  }

  inline RTCCompressedPart asPublic (const cbvh::StoredPart& part) {
    return RTCCompressedPart{ part.primID,part.width,part.height,part.vertices,part.parameters,part.primIDs,
        part.primitivesPerQuad };
  }

  inline RTCCompressionStatistics asPublic (const cbvh::CompressionStatistics& statistics)
  {
    RTCCompressionStatistics to = RTCCompressionStatistics();
    cbvh::forEachMember(to,statistics,[](size_t& to, size_t value) { to = value; },
        [](float& to, float value) { to = value; });
    return to;
  }
}
