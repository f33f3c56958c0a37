// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "cluster.h"
#include "stored_triangles.h"

namespace embree::cbvh {
/*! Divides the parts of a surface into clusters. Calls closure(cluster) until it returns false, and adds each
 *  cluster to the statistics. The cluster is valid during the call. Throws as forEachPart, and if there are more
 *  triangles than StoredCluster::firstTriangle, or DGF, can number. */
void forEachCluster(const SurfaceBlocks& blocks, const TraversalTime& time, ClusterFormat format,
                    const std::function<bool(const StoredCluster&)>& closure, ClusterStatistics& statistics);
} // namespace embree::cbvh
