// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Clusters of triangles in formats that GPUs read, as plain data without Embree. stored_clusters.h makes them from the
 * blocks of a surface. docs/formats/clusters.md describes the formats. */

#include "part.h"
#include <algorithm>
#include <cstddef>

namespace embree::cbvh {
enum class ClusterFormat : int {
  FLOAT3 = 0, //!< x, y, z per vertex
  /*! D3D12_VERTEX_FORMAT_COMPRESSED1: header and vertices, padded to 4 bytes. */
  COMPRESSED1 = 1,
  DGF1 = 2 //!< 128 bytes of AMD's Dense Geometry Format, with topology
};

/*! Why a cluster is returned as floats. */
enum class ClusterReason : int {
  NONE = 0,        //!< it is not, unless floats were requested
  FLOATS = 1,      //!< the block stores floats, or more than 14 bits on an axis
  MOVING = 2,      //!< the block moves, and its vertices at this time do not fit the format
  OUT_OF_RANGE = 3 //!< over 2^23 spacings from the origin, over 2^16 wide, or the spacing is below 2^-126
};
enum { numClusterReasons = 4 };

/*! Up to 8 x 8 quads, with 81 vertices and 128 triangles. For DGF up to 64 vertices and 64 triangles. */
struct StoredCluster {
  ClusterFormat format; //!< the requested one, or FLOAT3
  ClusterReason reason;
  uint32_t numVertices, numTriangles;
  const void* data; //!< aligned to 4 bytes
  size_t bytes;
  const uint8_t* indices; //!< three per triangle; for DGF in a decoder's order
  /*! Per triangle, its number in the part: 2 ((part->width-1) y + x) for the first triangle of quad x, y, plus 1
   *  for the second. */
  const uint32_t* triangleNumbers;
  /*! Number of triangles in all previous clusters; the first primitive index of a DGF block. */
  uint32_t firstTriangle;
  /*! Size in vertices if the cluster is a whole grid, stored row by row. Grids of the same size have the same
   *  indices. Otherwise, and for DGF, 0. */
  uint32_t width, height;
  const StoredPart* part;
};

/*! Sums over the clusters of a call. */
struct ClusterStatistics {
  size_t numClusters = 0, numTriangles = 0;
  size_t numVertices = 0; //!< counts a vertex in each cluster that has it
  size_t bytes = 0;
  size_t indexBytes = 0;                               //!< 3 per triangle, except for whole grids and DGF
  size_t numClustersByReason[numClusterReasons] = {};  //!< by ClusterReason
  size_t numTrianglesByReason[numClusterReasons] = {}; //!< by ClusterReason
};

/*! Cluster: struct of a public interface with the same members in the same order. part: must outlive the result. */
template<typename Cluster, typename Part>
Cluster clusterAs(const StoredCluster& cluster, const Part& part) {
  return Cluster{decltype(Cluster::format)(cluster.format),
                 decltype(Cluster::reason)(cluster.reason),
                 cluster.numVertices,
                 cluster.numTriangles,
                 cluster.data,
                 cluster.bytes,
                 cluster.indices,
                 cluster.triangleNumbers,
                 cluster.firstTriangle,
                 cluster.width,
                 cluster.height,
                 &part};
}

/*! Statistics: struct of a public interface with members of the same names. */
template<typename Statistics>
Statistics statisticsAs(const ClusterStatistics& statistics) {
  Statistics to = Statistics();
  static_assert(sizeof(to.numClustersByReason) >= sizeof(statistics.numClustersByReason) &&
                    sizeof(to.numTrianglesByReason) >= sizeof(statistics.numTrianglesByReason),
                "an entry per reason");
  to.numClusters = statistics.numClusters;
  to.numTriangles = statistics.numTriangles;
  to.numVertices = statistics.numVertices;
  to.bytes = statistics.bytes;
  to.indexBytes = statistics.indexBytes;
  std::copy_n(statistics.numClustersByReason, size_t(numClusterReasons), to.numClustersByReason);
  std::copy_n(statistics.numTrianglesByReason, size_t(numClusterReasons), to.numTrianglesByReason);
  return to;
}
} // namespace embree::cbvh
