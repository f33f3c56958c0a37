// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../embree/scene.h"
#include "../stored/stored_clusters.h"
#include "stored_blocks.h"

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API void rtcForEachCompressedCluster (RTCGeometry hgeometry, float time, enum RTCClusterFormat format, RTCCompressedClusterFunction function, void* userPtr,
                                          struct RTCCompressedClusterReport* report)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  const SurfaceBlocks& blocks = storedBlocksOf(hgeometry);
  if (format != RTC_CLUSTER_FORMAT_FLOAT3 && format != RTC_CLUSTER_FORMAT_COMPRESSED1 && format != RTC_CLUSTER_FORMAT_DGF1)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"unknown format of clusters: " + std::to_string(int(format)));
  RTCCompressedClusterReport own = RTCCompressedClusterReport();
  RTCCompressedClusterReport& sums = report ? *report : own;
  sums = own;
  cbvh::forEachCluster(blocks,traversalTime(geometry,time),format,[&](const RTCCompressedCluster& cluster) { return !function || function(userPtr,&cluster); },sums);
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
