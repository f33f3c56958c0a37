// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Clusters of a surface in formats that GPUs read. Plain data without headers of Embree. docs/formats/clusters.md
 * describes the formats. */

#include "part.h"
#include <algorithm>
#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    enum class ClusterFormat : int
    {
      FLOAT3 = 0,      //!< x, y, z of each vertex as floats
      /*! D3D12_VERTEX_FORMAT_COMPRESSED1: header and vertices, padded to 4 bytes. */
      COMPRESSED1 = 1,
      DGF1 = 2         //!< 128 bytes of AMD's Dense Geometry Format, including the topology
    };

    /*! Reason why a cluster is returned as floats. */
    enum class ClusterReason : int
    {
      FITS = 0,   //!< it has the requested format
      RAW = 1,    //!< its block stores floats, or as many bits
      MOVING = 2, //!< its vertices are interpolated between two time steps, or its block is a moving mesh block
      RANGE = 3   //!< its lattice extends more than 2^23 steps from the origin, or has steps below 2^-126
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
      const uint8_t* indices;      //!< three per triangle; for DGF in the order of a decoder
      /*! Index of each triangle in the part: 2 ((width-1) y + x) for quad x, y, plus 1 for its second triangle. */
      const uint32_t* triangles;
      /*! Number of triangles in all previous clusters; for DGF the first primitive index of the block. */
      uint32_t firstTriangle;
      /*! In vertices, if the cluster is a whole grid, row by row: clusters of the same size then have the same indices.
       *  Otherwise, and for DGF, 0, 0. */
      uint32_t width, height;
      const StoredPart* part;
    };

    struct ClusterReport
    {
      size_t numClusters = 0, numTriangles = 0;
      size_t numVertices = 0;      //!< counted in each cluster that has them
      size_t bytes = 0;
      size_t indexBytes = 0;       //!< 3 per triangle, except for whole grids and for DGF
      size_t numClustersOf[numClusterReasons] = {};  //!< by ClusterReason
      size_t numTrianglesOf[numClusterReasons] = {}; //!< by ClusterReason
    };

    /*! Converts a cluster for a public interface. Cluster: its struct, with the same members in the same order. part:
     *  must outlive the result. */
    template<typename Cluster, typename Part>
    Cluster clusterAs (const StoredCluster& cluster, const Part& part)
    {
      return Cluster{ decltype(Cluster::format)(cluster.format),decltype(Cluster::reason)(cluster.reason),
          cluster.numVertices,cluster.numTriangles,cluster.data,cluster.bytes,cluster.indices,cluster.triangles,
          cluster.firstTriangle,cluster.width,cluster.height,&part };
    }

    /*! Converts a report for a public interface. Report: its struct, with members of the same names. */
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
