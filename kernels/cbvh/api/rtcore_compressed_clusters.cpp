// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_compressed_clusters.h: checks pointers, calls operations/stored_surface.h, and
 * reports its exceptions to the device. */

#define RTC_EXPORT_API

#include "structs.h"
#include "../operations/stored_surface.h"

using namespace embree;

namespace {
using cbvh::ClusterFormat;
using cbvh::ClusterReason;
static_assert(int(ClusterFormat::COMPRESSED1) == RTC_COMPRESSED_CLUSTER_FORMAT_COMPRESSED1 &&
                  int(ClusterFormat::DGF1) == RTC_COMPRESSED_CLUSTER_FORMAT_DGF1,
              "formats");
static_assert(int(ClusterReason::FLOATS) == RTC_COMPRESSED_CLUSTER_REASON_FLOATS &&
                  int(ClusterReason::MOVING) == RTC_COMPRESSED_CLUSTER_REASON_MOVING &&
                  int(ClusterReason::OUT_OF_RANGE) == RTC_COMPRESSED_CLUSTER_REASON_OUT_OF_RANGE,
              "reasons");
} // namespace

RTC_NAMESPACE_BEGIN;

RTC_API void rtcForEachCompressedCluster(RTCGeometry hgeometry, float time, enum RTCCompressedClusterFormat format,
                                         RTCCompressedClusterFunction function, void* userPtr,
                                         struct RTCCompressedClusterStatistics* statistics) {
  Geometry* geometry = (Geometry*)hgeometry;
  const Ref<Geometry> held(geometry); // for RTC_CATCH_END2: the function may release the geometry
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  if (statistics) core::requireStruct(statistics);
  int value; // memcpy, because a value outside of the enumeration would be undefined behavior
  memcpy(&value, &format, sizeof(value));
  cbvh::ClusterStatistics sums;
  auto finish = [&] {
    if (statistics) core::writeStruct(statistics, cbvh::statisticsAs<RTCCompressedClusterStatistics>(sums));
  };
  try {
    core::forEachCluster(
        geometry, time, ClusterFormat(value),
        [&](const cbvh::StoredCluster& cluster) {
          if (!function) return true;
          const RTCCompressedPart part = toPublic(*cluster.part);
          const RTCCompressedCluster publicCluster = cbvh::clusterAs<RTCCompressedCluster>(cluster, part);
          return function(userPtr, &publicCluster);
        },
        sums);
  } catch (...) {
    finish();
    throw;
  } // statistics of the clusters before the error
  finish();
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
