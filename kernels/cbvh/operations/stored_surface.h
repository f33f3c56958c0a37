// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads triangles, parts and clusters of compressed surfaces.
 *
 * All functions throw RTC_ERROR_INVALID_OPERATION for geometry that has no blocks, is not completely stored as cVERT or
 * cGRID (cLEAF and cVOXEL have no triangles), or has a damaged block in its file. Closures may run before that.
 *
 * Thread safety: several threads may call them for a geometry and trace it, but other threads must not commit it.
 * Closures run on the calling thread, and may release or commit the geometry. Their arguments are valid until they
 * return.
 *
 * time: of rays; ignored for geometry that does not move. Vertices are the floats of traversal at that time. Outside of
 * the geometry's time range there are no triangles. */

#include "../base/point_on_surface.h"
#include "../blocks/cluster.h"
#include <functional>

namespace embree {
class Geometry;

namespace core {
/*! As cbvhFindTriangle: finds the triangle of a hit. Ng: 3 floats, or null. triangle: written if one is
 *  found. Cost: decodes a few blocks. The first call after a commit builds an index of 16 bytes per block, plus 4
 *  per primitive of a quad or triangle mesh. */
bool findTriangle(Geometry* geometry, float time, unsigned primID, float u, float v, const float* Ng,
                  cbvh::StoredTriangle& triangle);

/*! As cbvhFindClosestPoint: finds the point of a primitive that is closest to p. radius: largest distance. closest:
 *  written if there is one; its geomID is 0. Cost: as findTriangle, decodes all blocks of the primitive. */
bool findClosestPointOfPrimitive(Geometry* geometry, float time, unsigned primID, const float p[3], float radius,
                                 cbvh::PointOnSurface& closest);

/*! Calls closure(part) for all parts, in unspecified order, until it returns false. Cost: decodes each block
 *  once. */
void forEachPart(Geometry* geometry, float time, const std::function<bool(const cbvh::StoredPart&)>& closure);

/*! As cbvhForEachCluster: calls closure(cluster) for all clusters, always in the same order, until it
 *  returns false. statistics: set to sums over the clusters, even after an error. Errors: also
 *  RTC_ERROR_INVALID_ARGUMENT for an unknown format, and RTC_ERROR_INVALID_OPERATION for more than 2^32
 *  triangles, or 2^29 with DGF. */
void forEachCluster(Geometry* geometry, float time, cbvh::ClusterFormat format,
                    const std::function<bool(const cbvh::StoredCluster&)>& closure,
                    cbvh::ClusterStatistics& statistics);
} // namespace core
} // namespace embree
