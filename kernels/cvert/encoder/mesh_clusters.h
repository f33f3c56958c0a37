// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Cuts triangles into clusters of up to 256, and these into groups: recursively, at the median of an axis, so that all but the last cluster and group
 * are full. Compact groups share few vertices and have small boxes. A part of many triangles is cut across its longest axis; a smaller one across the
 * axis with the least sum of areas. */

#include "../format/mesh_block.h"
#include <algorithm>

namespace cvert { inline namespace CVERT_ISA
{
  /*! a triangle that is to be clustered */
  struct MeshCenter
  {
    float at[3];    //!< center of its bounds, finite
    uint32_t index; //!< of the caller's
  };

  class MeshClusters
  {
  public:
    /*! groupTriangles: of a full group, 16 or 32 */
    explicit MeshClusters (uint32_t groupTriangles) : groupTriangles(groupTriangles), clusterTriangles(std::min(groupTriangles*maxMeshGroups,maxMeshTriangles)) {}

    /*! Reorders the triangles and calls onCluster(triangles,count) for each cluster, in order. Each run of groupTriangles of a cluster is a group; the last
     *  may be shorter. Needs no memory. */
    template<typename OnCluster>
    void cut (MeshCenter* triangles, size_t count, const OnCluster& onCluster) const
    {
      split(triangles,count,clusterTriangles,[&](MeshCenter* cluster, size_t size) {
        split(cluster,size,groupTriangles,[](MeshCenter*, size_t) {});
        onCluster(cluster,uint32_t(size));
      });
    }

    const uint32_t groupTriangles, clusterTriangles;

  private:
    static const size_t fewTriangles = 4096;

    struct Bounds
    {
      float lower[3] = { INFINITY,INFINITY,INFINITY }, upper[3] = { -INFINITY,-INFINITY,-INFINITY };

      void extend (const float p[3]) { for (int k=0; k<3; k++) { lower[k] = std::min(lower[k],p[k]); upper[k] = std::max(upper[k],p[k]); } }
      double size (int k) const { return double(upper[k])-double(lower[k]); }
      double area () const { return size(0)*size(1) + size(1)*size(2) + size(2)*size(0); }
      int longest () const { return size(0) >= size(1) && size(0) >= size(2) ? 0 : size(1) >= size(2) ? 1 : 2; }
    };

    /*! Cuts off multiples of `unit` until at most `unit` are left. */
    template<typename OnPart>
    static void split (MeshCenter* triangles, size_t count, size_t unit, const OnPart& onPart)
    {
      if (count <= unit) { if (count > 0) onPart(triangles,count); return; }
      const size_t half = (count+unit-1)/unit/2*unit;
      const int k = axisOf(triangles,count);
      std::nth_element(triangles,triangles+half,triangles+count,[k](const MeshCenter& a, const MeshCenter& b) { return a.at[k] < b.at[k]; });
      split(triangles,half,unit,onPart);
      split(triangles+half,count-half,unit,onPart);
    }

    static int axisOf (const MeshCenter* triangles, size_t count)
    {
      Bounds bounds;
      double sum[3] = { 0,0,0 };
      for (size_t i=0; i<count; i++) {
        bounds.extend(triangles[i].at);
        for (int k=0; k<3; k++) sum[k] += double(triangles[i].at[k]);
      }
      if (count > fewTriangles) return bounds.longest();
      /* Means stand for medians. */
      float mean[3];
      for (int k=0; k<3; k++) mean[k] = float(sum[k]/double(count));
      Bounds halves[3][2];
      for (size_t i=0; i<count; i++)
        for (int k=0; k<3; k++) halves[k][triangles[i].at[k] >= mean[k]].extend(triangles[i].at);
      int best = bounds.longest();
      double least = INFINITY;
      for (int k=0; k<3; k++) {
        if (!(halves[k][0].lower[0] <= halves[k][0].upper[0] && halves[k][1].lower[0] <= halves[k][1].upper[0])) continue; // all at one place
        const double area = halves[k][0].area() + halves[k][1].area();
        if (area < least) { least = area; best = k; }
      }
      return best;
    }
  };
}}
