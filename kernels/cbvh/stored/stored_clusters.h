// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "cluster.h"
#include "stored_triangles.h"

namespace embree
{
  namespace cbvh
  {
    /*! Calls closure(cluster) until it returns false, and adds clusters to the report. Throws as forEachPart. */
    void forEachCluster (const SurfaceBlocks& blocks, const TraversalTime& time, ClusterFormat format,
                         const std::function<bool(const StoredCluster&)>& closure, ClusterReport& report);
  }
}
