// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Export of compressed geometry as clusters for GPUs. Clusters store the triangles that rays hit, with vertices that
 * are equal floats. docs/formats/clusters.md describes their contents and names the specifications. */

#include "rtcore_compressed_triangles.h"
#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

enum RTCCompressedClusterFormat {
  /* x, y, z of each vertex as floats */
  RTC_COMPRESSED_CLUSTER_FORMAT_FLOAT3 = 0,
  /* header and vertices of D3D12_VERTEX_FORMAT_COMPRESSED1 (DirectX Raytracing), padded to a multiple of 4 bytes */
  RTC_COMPRESSED_CLUSTER_FORMAT_COMPRESSED1 = 1,
  /* a block of 128 bytes of AMD's Dense Geometry Format, including the topology */
  RTC_COMPRESSED_CLUSTER_FORMAT_DGF1 = 2
};

/* Reason why a cluster stores floats instead of the requested format. */
enum RTCCompressedClusterReason {
  /* the cluster has the requested format */
  RTC_COMPRESSED_CLUSTER_REASON_NONE = 0,
  /* the geometry stores floats (cGRID, and some blocks of cVERT), or cVERT of more than 14 bits on an axis, and no
   * lattice of the format represents these vertices */
  RTC_COMPRESSED_CLUSTER_REASON_FLOATS = 1,
  /* the vertices are interpolated between two time steps, not on a lattice, or belong to a moving mesh block */
  RTC_COMPRESSED_CLUSTER_REASON_MOVING = 2,
  /* the vertices are over 2^23 spacings from the origin, the cluster is over 2^16 spacings wide, or the spacing is
   * below 2^-126 */
  RTC_COMPRESSED_CLUSTER_REASON_OUT_OF_RANGE = 3
};

/* A cluster: up to 8 x 8 quads with 81 vertices and 128 triangles; for DGF up to 32 quads with 64 of both. Later
 * versions may append members. */
struct RTCCompressedCluster {
  enum RTCCompressedClusterFormat format; /* of data: the requested format, or FLOAT3 */
  enum RTCCompressedClusterReason reason;
  unsigned int numVertices, numTriangles;
  const void* data;             /* aligned to 4 bytes */
  size_t bytes;                 /* of data */
  const unsigned char* indices; /* three vertices for each triangle; with DGF in the order in which a decoder emits
                                 * them */
  const unsigned int* triangleNumbers; /* number in the part of each triangle: 2 ((width-1) y + x) for the first
                                        * triangle of quad x, y, and 1 more for its second */
  unsigned int firstTriangle; /* number of triangles in all clusters before. With DGF the primitive indices of the
                               * block start here */
  unsigned int width, height; /* in vertices, row by row, if the cluster is a complete grid: all clusters of this
                               * size have the same indices. 0, 0 otherwise and with DGF */
  const struct RTCCompressedPart* part; /* the part that contains the cluster: parameters and primIDs */
};

/* Totals over clusters. */
struct RTCCompressedClusterStatistics {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCCompressedClusterStatistics); /* see rtcore_compression.h */
  size_t numClusters RTC_ZERO, numTriangles RTC_ZERO;
  size_t numVertices RTC_ZERO;             /* shared vertices count once for each cluster */
  size_t bytes RTC_ZERO;                   /* of data */
  size_t indexBytes RTC_ZERO;              /* of the indices of clusters that are not complete grids, 3 bytes per
                                            * triangle. 0 for DGF, whose blocks contain indices */
  size_t numClustersByReason[8] RTC_ZERO;  /* index: an RTCCompressedClusterReason. Other entries are 0 */
  size_t numTrianglesByReason[8] RTC_ZERO; /* the same */
};

/* Called with a cluster, which is valid until the function returns. Returning false ends the enumeration. */
typedef bool (*RTCCompressedClusterFunction)(void* userPtr, const struct RTCCompressedCluster* cluster);

/* Calls a function for all clusters of a surface at a time, on the calling thread. The order is the same for each call.
 * Each block is decoded when its clusters are passed.
 *
 * Vertices are not rounded: a decoder of the format returns the floats that rays hit, except that -0 becomes 0. There
 * are no cracks between clusters, with cGRID inside of a face. Triangles with a vertex that is not finite, or with two
 * equal vertices, are left out, because no ray hits them. Clusters that the format cannot represent have floats, and
 * their reason is set.
 *
 * geometry:   stored as cVERT or cGRID, as for rtcForEachCompressedPart.
 * time:       of rays. Ignored for geometry that does not move. At a time step, vertices are on their lattice.
 * format:     of the clusters.
 * function:   NULL if only the statistics are needed.
 * userPtr:    passed to the function.
 * statistics: totals over the clusters that were passed, or NULL. structSize is read. Written unless the geometry is
 *             NULL or structSize is wrong.
 *
 * Errors: as rtcForEachCompressedPart. RTC_ERROR_INVALID_ARGUMENT for an unknown format and a wrong structSize.
 * RTC_ERROR_INVALID_OPERATION if the surface has more than 2^32 triangles, or more than the 29-bit primitive indices of
 * DGF can count.
 * Thread safety: as rtcInterpolate. */
RTC_API void rtcForEachCompressedCluster(RTCGeometry geometry, float time, enum RTCCompressedClusterFormat format,
                                         RTCCompressedClusterFunction function, void* userPtr,
                                         struct RTCCompressedClusterStatistics* statistics);

RTC_NAMESPACE_END
