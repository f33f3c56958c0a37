// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface as its blocks hold it, cut into clusters of formats that GPUs read. */

#include "stored_triangles.h"
#include "../../../include/embree3/rtcore_compressed_clusters.h"

namespace embree
{
  namespace cbvh
  {
    /*! Calls closure(cluster) until it returns false, and adds what it was called with to the report. Throws as forEachPart. */
    void forEachCluster (const SurfaceBlocks& blocks, const TraversalTime& time, RTCClusterFormat format,
                         const std::function<bool(const RTCCompressedCluster&)>& closure, RTCCompressedClusterReport& report);
  }
}
