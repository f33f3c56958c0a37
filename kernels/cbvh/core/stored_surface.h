// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads triangles, parts and clusters of compressed surfaces as stored.
 *
 * All functions throw RTC_ERROR_INVALID_OPERATION for geometry that has no blocks, is not completely stored as cVERT or
 * cGRID, or comes from a damaged file. cLEAF and cVOXEL have no triangles.
 *
 * Thread safety: threads may call them for a geometry, and trace it, at the same time. No thread may commit it during a
 * call. Closures run on the calling thread; their arguments are valid until they return.
 *
 * time: time of rays; ignored for geometry that does not move. Vertices are the floats of traversal at that time.
 * Outside of the geometry's time range there are no triangles. */

#include "../stored/cluster.h"
#include <functional>

namespace embree
{
  class Geometry;

  namespace core
  {
    float firstTime (Geometry* geometry);

    /*! Finds the triangle of a hit.
     *
     *  primID, u, v: of the hit. Ng: of the hit, 3 floats, or null; selects the triangle if (u,v) is on an edge of
     *  several. triangle: set if the result is true. Its vertices are in the order of the patch: quad (x,y) has the
     *  triangles (x,y), (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). For meshes they are in the order of the
     *  primitive; for quads this is v0, v1, v3 or v2, v3, v1.
     *
     *  Returns false if (u,v) is on no triangle of the primitive: for an unknown primID, triangles that were left out,
     *  and values that are not finite.
     *
     *  Cost: decodes one or a few blocks. The first call after a commit builds an index of 16 bytes per block, plus 4
     *  per primitive of a quad or triangle mesh. */
    bool findTriangle (Geometry* geometry, float time, unsigned primID, float u, float v, const float* Ng,
        cbvh::StoredTriangle& triangle);

    /*! Calls closure(part) for all parts, in unspecified order, until it returns false. Cost: decodes each block
     *  once. */
    void forEachPart (Geometry* geometry, float time, const std::function<bool(const cbvh::StoredPart&)>& closure);

    /*! Calls closure(cluster) for all clusters of a surface, always in the same order, until it returns false.
     *
     *  Vertices do not move: a decoder of the format returns the floats of traversal, with 0 for -0, so clusters share
     *  borders as blocks do. Triangles that no ray hits are left out: those with a vertex that is not finite, or with
     *  two equal vertices. Clusters that a format cannot represent are FLOAT3, with the reason.
     *
     *  format: an unknown format is RTC_ERROR_INVALID_ARGUMENT.
     *  report: set to sums over the clusters, even after an error.
     *
     *  Also throws RTC_ERROR_INVALID_OPERATION if there are more triangles than the 29 bits of DGF's primitive indices
     *  support. */
    void forEachCluster (Geometry* geometry, float time, cbvh::ClusterFormat format,
        const std::function<bool(const cbvh::StoredCluster&)>& closure,
                         cbvh::ClusterReport& report);
  }
}
