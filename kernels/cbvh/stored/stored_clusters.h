// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A surface as its blocks hold it, cut into clusters of formats that GPUs read. */

#include "cluster.h"
#include "stored_triangles.h"

namespace embree
{
  namespace cbvh
  {
    /*! Calls closure(cluster) until it returns false, and adds what it was called with to the report. Throws as forEachPart. */
    void forEachCluster (const SurfaceBlocks& blocks, const TraversalTime& time, ClusterFormat format,
                         const std::function<bool(const StoredCluster&)>& closure, ClusterReport& report);
  }
}
