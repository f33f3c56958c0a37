// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Clusters of triangles in formats that GPUs read, as plain data without Embree. stored_clusters.h makes them from the
 * blocks of a surface. docs/formats/clusters.md describes the formats. */

#include "part.h"
#include <algorithm>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    enum class ClusterFormat : int
    {
      FLOAT3 = 0,      //!< x, y, z per vertex
      /*! D3D12_VERTEX_FORMAT_COMPRESSED1: header and vertices, padded to 4 bytes. */
      COMPRESSED1 = 1,
      DGF1 = 2         //!< 128 bytes of AMD's Dense Geometry Format, with topology
    };

    /*! Why a cluster is returned as floats. */
    enum class ClusterReason : int
    {
      FITS = 0,   //!< it is not, unless floats were requested
      RAW = 1,    //!< the block stores floats, or as many bits
      MOVING = 2, //!< vertices are interpolated between time steps, or the block is a moving mesh block
      RANGE = 3   //!< the lattice extends more than 2^23 steps from the origin, or has steps below 2^-126
    };
    enum { numClusterReasons = 4 };

    /*! Up to 8 x 8 quads: at most 81 vertices and 128 triangles, or 64 of both for DGF. */
    struct StoredCluster
    {
      ClusterFormat format;        //!< the requested one, or FLOAT3
      ClusterReason reason;
      uint32_t numVertices, numTriangles;
      const void* data;            //!< aligned to 4 bytes
      size_t bytes;
      const uint8_t* indices;      //!< three per triangle; for DGF in a decoder's order
      /*! Per triangle, its number in the part: 2 ((part->width-1) y + x) for the first triangle of quad x, y, plus 1
       *  for the second. */
      const uint32_t* triangles;
      /*! Number of triangles in all previous clusters; the first primitive index of a DGF block. */
      uint32_t firstTriangle;
      /*! Size in vertices if the cluster is a whole grid, stored row by row. Grids of the same size have the same
       *  indices. Otherwise, and for DGF, 0. */
      uint32_t width, height;
      const StoredPart* part;
    };

    /*! Sums over the clusters of a call. */
    struct ClusterReport
    {
      size_t numClusters = 0, numTriangles = 0;
      size_t numVertices = 0;      //!< counts a vertex in each cluster that has it
      size_t bytes = 0;
      size_t indexBytes = 0;       //!< 3 per triangle, except for whole grids and DGF
      size_t numClustersOf[numClusterReasons] = {};  //!< by ClusterReason
      size_t numTrianglesOf[numClusterReasons] = {}; //!< by ClusterReason
    };

    /*! Cluster: struct of a public interface with the same members in the same order. part: must outlive the result. */
    template<typename Cluster, typename Part>
    Cluster clusterAs (const StoredCluster& cluster, const Part& part)
    {
      return Cluster{ decltype(Cluster::format)(cluster.format),decltype(Cluster::reason)(cluster.reason),
          cluster.numVertices,cluster.numTriangles,cluster.data,cluster.bytes,cluster.indices,cluster.triangles,
          cluster.firstTriangle,cluster.width,cluster.height,&part };
    }

    /*! Report: struct of a public interface with members of the same names. */
    template<typename Report>
    Report reportAs (const ClusterReport& report)
    {
      Report to = Report();
      static_assert(sizeof(to.numClustersOf) == sizeof(report.numClustersOf)
          && sizeof(to.numTrianglesOf) == sizeof(report.numTrianglesOf),"one sum per reason");
      to.numClusters = report.numClusters;
      to.numTriangles = report.numTriangles;
      to.numVertices = report.numVertices;
      to.bytes = report.bytes;
      to.indexBytes = report.indexBytes;
      std::copy_n(report.numClustersOf,size_t(numClusterReasons),to.numClustersOf);
      std::copy_n(report.numTrianglesOf,size_t(numClusterReasons),to.numTrianglesOf);
      return to;
    }
  }
}
