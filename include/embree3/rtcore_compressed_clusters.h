// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed surfaces out again as clusters that GPUs read: the triangles that rays hit here, with vertices that are the same floats. What is in clusters, and
 * from which specification, is in docs/formats/clusters.md. */

#include "rtcore_compressed_triangles.h"
#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

enum RTCClusterFormat
{
  RTC_CLUSTER_FORMAT_FLOAT3 = 0,      /* x, y, z of each vertex as floats */
  RTC_CLUSTER_FORMAT_COMPRESSED1 = 1, /* D3D12_VERTEX_FORMAT_COMPRESSED1 of DirectX Raytracing: its header and vertices, filled up to 4 bytes */
  RTC_CLUSTER_FORMAT_DGF1 = 2         /* a block of 128 bytes of AMD's Dense Geometry Format, with its topology */
};

/* Why a cluster has floats where another format was asked for. */
enum RTCClusterReason
{
  RTC_CLUSTER_FITS = 0,   /* it has not */
  RTC_CLUSTER_RAW = 1,    /* its vertices are stored as floats, or with as many bits: of cGRID, and of blocks of cVERT that kept full precision */
  RTC_CLUSTER_MOVING = 2, /* they are between two time steps, and so on no lattice */
  RTC_CLUSTER_RANGE = 3   /* on a lattice, but further from the origin than 2^23 of its steps, or with steps below 2^-126 */
};

/* Up to 8 x 8 quads: 81 vertices and 128 triangles; of DGF 64 of both. Later versions may append members. */
struct RTCCompressedCluster
{
  enum RTCClusterFormat format; /* of data: what was asked for, or RTC_CLUSTER_FORMAT_FLOAT3 */
  enum RTCClusterReason reason;
  unsigned int numVertices, numTriangles;
  const void* data;             /* aligned to 4 bytes */
  size_t bytes;
  const unsigned char* indices; /* of three vertices of each triangle; of DGF in the order of a decoder */
  const unsigned int* triangles; /* of each that it is of the part: 2 ((width-1) y + x) of quad x, y, and 1 more for its second */
  unsigned int firstTriangle;   /* triangles that were handed out before; of DGF those of a block have their primitive indices from here on */
  unsigned int width, height;   /* in vertices, if it is a whole grid, row by row: all clusters of that size have the same indices. 0, 0 otherwise, and of DGF */
  const struct RTCCompressedPart* part; /* that it is cut from: parameters, primIDs */
};

/* Sums over clusters. */
struct RTCCompressedClusterReport
{
  size_t structSize RTC_SIZE_OF(RTCCompressedClusterReport); /* see rtcore_compression.h */
  size_t numClusters, numTriangles;
  size_t numVertices;           /* those that clusters share count in each */
  size_t bytes;                 /* of data */
  size_t indexBytes;            /* of indices that are not those of a whole grid, 3 bytes a triangle. DGF has its own */
  size_t numClustersOf[4];      /* by reason */
  size_t numTrianglesOf[4];     /* likewise */
};

/* Is handed a cluster; valid until it returns. False ends the calls. */
typedef bool (*RTCCompressedClusterFunction)(void* userPtr, const struct RTCCompressedCluster* cluster);

/* Hands out all of a surface as it is at a time, cluster by cluster, by the calling thread, in an order that is the same each time. No vertex
 * is moved: a decoder of the format gets the floats that rays meet here, but 0 for -0, so clusters meet as blocks do. Triangles with a vertex that is not finite, or with two vertices
 * in the same place, are left out: no ray hits them. Clusters that a format cannot hold come as floats, with the reason.
 *
 * geometry: stored as cVERT or cGRID, as for rtcForEachCompressedPart.
 * time: as rays have it; without meaning for what does not move. At a time step vertices are on their lattice.
 * function: NULL: nothing but the report is wanted.
 * report: what was handed out, written when the function returns; may be NULL. structSize is read.
 *
 * Errors: as rtcForEachCompressedPart; RTC_ERROR_INVALID_ARGUMENT for an unknown format and a wrong structSize;
 * RTC_ERROR_INVALID_OPERATION where DGF has more triangles than the 29 bits of its primitive indices count. Thread
 * safety: as rtcInterpolate. */
RTC_API void rtcForEachCompressedCluster(RTCGeometry geometry, float time, enum RTCClusterFormat format, RTCCompressedClusterFunction function, void* userPtr, struct RTCCompressedClusterReport* report);

RTC_NAMESPACE_END
