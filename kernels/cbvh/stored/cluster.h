// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Clusters of a surface in formats that GPUs read: plain data, which includes nothing of Embree.
 * docs/formats/clusters.md describes the formats. */

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
      /*! D3D12_VERTEX_FORMAT_COMPRESSED1 of DirectX Raytracing: its header and vertices, filled up to 4 bytes */
      COMPRESSED1 = 1,
      DGF1 = 2         //!< a block of 128 bytes of AMD's Dense Geometry Format, with its topology
    };

    /*! Why a cluster is stored as floats although another format was asked for. */
    enum class ClusterReason : int
    {
      FITS = 0,   //!< it is stored in the format that was asked for
      RAW = 1,    //!< its block stores floats, or as many bits
      MOVING = 2, //!< its vertices are between two time steps, and so on no lattice
      RANGE = 3   //!< its lattice reaches further than 2^23 steps from the origin, or has steps below 2^-126
    };
    enum { numClusterReasons = 4 };

    /*! Up to 8 x 8 quads: at most 81 vertices and 128 triangles; for DGF at most 64 of both. */
    struct StoredCluster
    {
      ClusterFormat format;        //!< of data: what was asked for, or FLOAT3
      ClusterReason reason;
      uint32_t numVertices, numTriangles;
      const void* data;            //!< aligned to 4 bytes
      size_t bytes;                //!< of data
      const uint8_t* indices;      //!< of three vertices of each triangle; for DGF in the order of a decoder
      /*! Index of each triangle in the part: 2 ((width-1) y + x) for quad x, y, and 1 more for its second triangle */
      const uint32_t* triangles;
      /*! Number of triangles in the clusters before; for DGF the first primitive index of the block */
      uint32_t firstTriangle;
      /*! In vertices, if the cluster is a whole grid, row by row: all clusters of one size then have the same indices.
       *  0, 0 otherwise, and for DGF. */
      uint32_t width, height;
      const StoredPart* part;      //!< that the cluster is cut from
    };

    /*! Sums over clusters. */
    struct ClusterReport
    {
      size_t numClusters = 0, numTriangles = 0;
      size_t numVertices = 0;      //!< a vertex that clusters share counts in each of them
      size_t bytes = 0;            //!< of data
      size_t indexBytes = 0;       //!< 3 per triangle, without those of whole grids and of DGF
      size_t numClustersOf[numClusterReasons] = {};
      size_t numTrianglesOf[numClusterReasons] = {};
    };

    /*! Returns a cluster as the struct of an interface, which has the same members in the same order. part: of the
     *  interface, likewise; must outlive the result. */
    template<typename Cluster, typename Part>
    Cluster clusterAs (const StoredCluster& cluster, const Part& part)
    {
      return Cluster{ decltype(Cluster::format)(cluster.format),decltype(Cluster::reason)(cluster.reason),
          cluster.numVertices,cluster.numTriangles,cluster.data,cluster.bytes,cluster.indices,cluster.triangles,
          cluster.firstTriangle,cluster.width,cluster.height,&part };
    }

    /*! Returns sums as the struct of an interface, which has members of the same names. */
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
