// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed surfaces out again: triangles, parts and clusters as they are stored.
 *
 * All functions throw RTC_ERROR_INVALID_OPERATION for a geometry that has no blocks, for one that is stored as anything
 * but cVERT or cGRID, if in part (cLEAF and cVOXEL have no triangles), and for one whose file is damaged.
 *
 * Thread safety: any number of threads may call them for a geometry at a time, and trace it; no thread may commit it
 * meanwhile. Closures are called by the calling thread. What they are passed is valid until they return.
 *
 * time: as rays have it. Of geometry that does not move the time does not matter. Vertices are the same floats that
 * rays meet at that time. Outside of the geometry's time range there are no triangles. */

#include "../stored/cluster.h"
#include <functional>

namespace embree
{
  class Geometry;

  namespace core
  {
    /*! Returns the time of a geometry's first time step. */
    float firstTime (Geometry* geometry);

    /*! Looks up the triangle that a hit is on.
     *
     *  primID, u, v: of the hit. Ng: of the hit, 3 floats; it chooses between triangles on whose common edge (u,v)
     *  lies. Null takes any of them. triangle: written if there is one. Its vertices are in the order of the patch:
     *  quad (x,y) has the triangles (x,y), (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). Of quad meshes and
     *  triangle meshes they are in the order of the primitive: v0, v1, v3 or v2, v3, v1 of a quad.
     *
     *  Returns false if (u,v) is on no triangle of the primitive: for an unknown primID, where triangles were left out,
     *  and for numbers that are not finite.
     *
     *  Cost: decodes a block or a few. The first call after a commit makes an index of the geometry's blocks, of 16
     *  bytes each, and for quad meshes and triangle meshes of 4 bytes for each primitive. */
    bool findTriangle (Geometry* geometry, float time, unsigned primID, float u, float v, const float* Ng,
        cbvh::StoredTriangle& triangle);

    /*! Calls closure(part) for all parts of a surface until it returns false, in an order that is not specified. Cost:
     *  decodes each block once. */
    void forEachPart (Geometry* geometry, float time, const std::function<bool(const cbvh::StoredPart&)>& closure);

    /*! Calls closure(cluster) for all clusters of a surface until it returns false, in an order that is the same each
     *  time.
     *
     *  No vertex is moved: a decoder of the format gets the floats that rays meet, but 0 for -0, so clusters share
     *  borders as blocks do. Triangles with a vertex that is not finite, or with two vertices in the same place, are
     *  left out: no ray hits them. Clusters that a format cannot hold are FLOAT3, with the reason.
     *
     *  format: RTC_ERROR_INVALID_ARGUMENT for an unknown one.
     *  report: sums of the clusters so far, starting with zeros; also valid after an error.
     *
     *  Also throws RTC_ERROR_INVALID_OPERATION if DGF has more triangles than the 29 bits of its primitive indices
     *  count. */
    void forEachCluster (Geometry* geometry, float time, cbvh::ClusterFormat format,
        const std::function<bool(const cbvh::StoredCluster&)>& closure,
                         cbvh::ClusterReport& report);
  }
}
