// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The decoded triangles of clusters must be those that forEachStoredPart returns and that rays hit. Throws if
 * they differ. */

#include "support/cluster_decoder.h"
#include "support/surface_access.h"

#include <algorithm>
#include <cstring>
#include <exception>

namespace programs::test {

typedef std::array<float, 3> Corner;

// A set of triangles as sums of hashes and a count, because it may be too large to store. Rotated corners make no
// difference, reversed ones do.
struct TriangleSet {
  size_t count = 0;
  uint64_t sums[2] = {0, 0};

  void add(const Corner& a, const Corner& b, const Corner& c) {
    const std::array<Corner, 3> turns[3] = {{{a, b, c}}, {{b, c, a}}, {{c, a, b}}};
    const std::array<Corner, 3>& first = *std::min_element(turns, turns + 3);
    for (uint64_t i = 0; i < 2; i++) {
      uint64_t hash = 0x9E3779B97F4A7C15ull * (i + 1);
      for (const Corner& corner : first)
        for (float x : corner) {
          uint32_t bits;
          x += 0.0f; // maps -0 to 0
          std::memcpy(&bits, &x, sizeof(bits));
          hash = (hash ^ bits) * 0xFF51AFD7ED558CCDull;
          hash ^= hash >> 32;
        }
      sums[i] += hash;
    }
    count++;
  }

  bool operator==(const TriangleSet& other) const {
    return count == other.count && sums[0] == other.sums[0] && sums[1] == other.sums[1];
  }
};

inline Corner cornerOf(const CbvhPart& part, unsigned x, unsigned y) {
  const float* p = part.vertices + 3 * (size_t(y) * part.width + x);
  return {p[0], p[1], p[2]};
}

inline std::array<Corner, 3> triangleOf(const CbvhPart& part, unsigned number) {
  const unsigned quad = number / 2, x = quad % (part.width - 1), y = quad / (part.width - 1);
  if (number % 2) return {cornerOf(part, x, y + 1), cornerOf(part, x + 1, y), cornerOf(part, x + 1, y + 1)};
  return {cornerOf(part, x, y), cornerOf(part, x + 1, y), cornerOf(part, x, y + 1)};
}

// Finite and distinct vertices. Clusters contain only such triangles.
inline bool canBeHit(const std::array<Corner, 3>& t) {
  for (const Corner& c : t)
    for (float x : c)
      if (!std::isfinite(x)) return false;
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

class ClusterJudge {
public:
  CbvhClusterStatistics statistics;
  size_t decodedVertices = 0;
  size_t wholeClusters = 0, largestCluster = 0;

  // Throws with a description of the first difference.
  ClusterJudge(RTCGeometry geometry, float time, CbvhClusterFormat format) : format(format) {
    std::memset((void*)&statistics, 0xFF, sizeof(statistics));
    statistics.structSize = sizeof(statistics);
    forEachStoredPart(geometry, time, addPart, this);
    forEachStoredCluster(geometry, time, format, addCluster, this, &statistics);
    if (!failure.empty()) throw std::runtime_error(failure);
    demand(found == expected, "other triangles");
    size_t clusters = 0, triangles = 0;
    for (int i = 0; i < 8; i++) {
      clusters += statistics.numClustersByReason[i];
      triangles += statistics.numTrianglesByReason[i];
    }
    demand(statistics.numTriangles == found.count && triangles == found.count, "statistics: triangles");
    demand(statistics.numClusters == seen.numClusters && clusters == seen.numClusters, "statistics: clusters");
    demand(statistics.numVertices == seen.numVertices && statistics.bytes == seen.bytes &&
               statistics.indexBytes == seen.indexBytes,
           "statistics: bytes");
    demand(std::equal(statistics.numClustersByReason, statistics.numClustersByReason + 8, seen.numClustersByReason),
           "statistics: reasons");
  }

private:
  static bool addPart(void* self, const CbvhPart* part) {
    for (unsigned i = 0; i < 2 * (part->width - 1) * (part->height - 1); i++) {
      const std::array<Corner, 3> t = triangleOf(*part, i);
      if (canBeHit(t)) ((ClusterJudge*)self)->expected.add(t[0], t[1], t[2]);
    }
    return true;
  }

  static bool addCluster(void* self, const CbvhCluster* cluster) {
    try {
      ((ClusterJudge*)self)->add(*cluster);
    } catch (const std::exception& error) { ((ClusterJudge*)self)->failure = error.what(); }
    return ((ClusterJudge*)self)->failure.empty();
  }

  void add(const CbvhCluster& cluster) {
    demand((cluster.reason == CBVH_CLUSTER_REASON_NONE) == (cluster.format == format), "a reason, and the format");
    demand(cluster.format == format || cluster.format == CBVH_CLUSTER_FORMAT_FLOAT3, "another format");
    demand(cluster.numVertices <= 256 && cluster.numTriangles > 0 && cluster.numTriangles <= 256,
           "a cluster that is too large");
    demand(cluster.firstTriangle == found.count, "the first triangle");
    DecodedCluster decoded;
    const bool isDgf = cluster.format == CBVH_CLUSTER_FORMAT_DGF1;
    if (isDgf) {
      decoded = decodeDgf(cluster.data, cluster.bytes);
      demand(decoded.primitives == cluster.firstTriangle && decoded.vertices.size() == cluster.numVertices &&
                 decoded.triangles.size() == cluster.numTriangles,
             "the block's header");
      for (unsigned t = 0; t < cluster.numTriangles; t++)
        for (int c = 0; c < 3; c++)
          demand(decoded.triangles[t][c] == cluster.indices[3 * t + c], "indices are not those of the block");
    } else if (cluster.format == CBVH_CLUSTER_FORMAT_COMPRESSED1)
      decoded = decodeCompressed1(cluster.data, cluster.bytes, cluster.numVertices);
    else {
      demand(cluster.bytes == 12 * cluster.numVertices, "the bytes of floats");
      for (unsigned i = 0; i < cluster.numVertices; i++) {
        const float* p = (const float*)cluster.data + 3 * i;
        decoded.vertices.push_back({p[0], p[1], p[2]});
      }
    }
    std::vector<bool> isUsed(cluster.numVertices);
    for (unsigned t = 0; t < cluster.numTriangles; t++) {
      std::array<Corner, 3> triangle;
      for (int c = 0; c < 3; c++) {
        const unsigned v = cluster.indices[3 * t + c];
        demand(v < cluster.numVertices, "an index");
        isUsed[v] = true;
        triangle[c] = decoded.vertices[v];
      }
      std::array<Corner, 3> reported = triangleOf(*cluster.part, cluster.triangleNumbers[t]);
      demand(reported == triangle || std::array<Corner, 3>{reported[1], reported[2], reported[0]} == triangle ||
                 std::array<Corner, 3>{reported[2], reported[0], reported[1]} == triangle,
             "a triangle is not the part's");
      found.add(triangle[0], triangle[1], triangle[2]);
    }
    demand(std::find(isUsed.begin(), isUsed.end(), false) == isUsed.end(), "a vertex without a triangle");
    if (cluster.width > 0) {
      demand(cluster.numVertices == cluster.width * cluster.height &&
                 cluster.numTriangles == 2 * (cluster.width - 1) * (cluster.height - 1),
             "a whole grid");
      for (unsigned i = 0; i < cluster.numTriangles; i++) {
        const unsigned a = i / 2 / (cluster.width - 1) * cluster.width + i / 2 % (cluster.width - 1);
        const unsigned corners[2][3] = {{a, a + 1, a + cluster.width},
                                        {a + cluster.width, a + 1, a + cluster.width + 1}};
        demand(std::equal(corners[i % 2], corners[i % 2] + 3, cluster.indices + 3 * i), "indices of a whole grid");
      }
      wholeClusters++;
    }
    decodedVertices += cluster.numVertices;
    largestCluster = std::max(largestCluster, size_t(cluster.numTriangles));
    seen.numClusters++;
    seen.numVertices += cluster.numVertices;
    seen.bytes += cluster.bytes;
    if (cluster.width == 0 && !isDgf) seen.indexBytes += 3 * cluster.numTriangles;
    seen.numClustersByReason[cluster.reason]++;
  }

  const CbvhClusterFormat format;
  TriangleSet expected, found;
  CbvhClusterStatistics seen = CbvhClusterStatistics();
  std::string failure;
};

} // namespace programs::test
