// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A source outside of the library is converted to blocks by the builder. The program contains the library's object
 * files, because the library does not export the builder. */

#include "sphere_source.h"
#include "kernels/cbvh/building/surface_builder.h"
#include "kernels/cbvh/blocks/stored_clusters.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include <atomic>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

namespace embree::isa {
/*! adds the vertices of all blocks below a node */
static void addVertices(BVH4::NodeRef ref, std::set<std::tuple<float, float, float>>& vertices) {
  if (ref == BVH4::emptyNode) return;
  if (!ref.isLeaf()) {
    for (size_t i = 0; i < 4; i++) addVertices(ref.getAABBNode()->child(i), vertices);
    return;
  }
  size_t type;
  const void* const block = ref.leaf(type);
  ASSERT_EQ(type, size_t(cbvh::VERT_BLOCK));
  const cbvh::DecodedBlock decoded((const cbvh::VertHeader*)block);
  for (size_t i = 0; i < (decoded.quadsX + 1) * (decoded.quadsY + 1); i++)
    vertices.emplace(decoded.vertices[i][0], decoded.vertices[i][1], decoded.vertices[i][2]);
}

/*! faces with this many quads per side: written in one piece, by several tasks, and in strips */
class SurfaceSource : public ::testing::TestWithParam<unsigned> {};

TEST_P(SurfaceSource, SphereIsClosedAndRound) {
  const size_t quads = GetParam();
  const RTCDevice handle = rtcNewDevice(nullptr);
  {
    SphereSource::Mesh mesh((Device*)handle, unsigned(quads));
    const std::shared_ptr<const cbvh::SurfaceNumber> number = std::make_shared<cbvh::SurfaceNumber>();
    const CompressionPlan plan(&mesh, *number);
    SourceBuilder<SphereSource> builder(&mesh, number, plan);
    std::atomic<int> primitives{0}; // tasks call progress() concurrently
    const std::shared_ptr<const SurfaceBlocks> blocks = builder.build([&](double n) { primitives += int(n); });
    EXPECT_EQ(primitives, 6);

    const float spacing = std::ldexp(1.0f, SphereSource::exponent);
    const cbvh::CompressionStatistics& sums = blocks->statistics.sums;
    EXPECT_EQ(sums.numQuads, 6 * quads * quads);
    EXPECT_EQ(sums.numInvalidQuads, 0u);
    EXPECT_EQ(sums.maxVertexSpacing, spacing);
    EXPECT_EQ(sums.maxBorderMismatch, 0.0f);

    std::set<std::tuple<float, float, float>> vertices;
    for (const PrimRef& part : blocks->parts) addVertices(BVH4::NodeRef(part.ID()), vertices);
    EXPECT_EQ(vertices.size(), 6 * quads * quads + 2) << "shared vertices of faces differ";
    double farthest = 0;
    for (const auto& v : vertices) {
      const double x = std::get<0>(v), y = std::get<1>(v), z = std::get<2>(v);
      farthest = std::max(farthest, std::fabs(std::sqrt(x * x + y * y + z * z) - 1.0));
    }
    EXPECT_LE(farthest, 0.87 * spacing) << "half the diagonal of a lattice cell";
    EXPECT_GT(farthest, 0.0);
  }
  rtcReleaseDevice(handle);
}

/*! statistics that begin with many triangles stand for a surface that has them */
TEST(SurfaceClusters, TooManyTrianglesAreErrors) {
  const RTCDevice handle = rtcNewDevice(nullptr);
  {
    SphereSource::Mesh mesh((Device*)handle, 8);
    const std::shared_ptr<const cbvh::SurfaceNumber> number = std::make_shared<cbvh::SurfaceNumber>();
    const CompressionPlan plan(&mesh, *number);
    SourceBuilder<SphereSource> builder(&mesh, number, plan);
    const std::shared_ptr<const SurfaceBlocks> blocks = builder.build([](double) {});
    const size_t triangles = 6 * 8 * 8 * 2;
    for (const cbvh::ClusterFormat format :
         {cbvh::ClusterFormat::FLOAT3, cbvh::ClusterFormat::COMPRESSED1, cbvh::ClusterFormat::DGF1}) {
      const uint64_t most = uint64_t(1) << (format == cbvh::ClusterFormat::DGF1 ? 29 : 32);
      for (const bool areTooMany : {false, true}) {
        cbvh::ClusterStatistics statistics;
        statistics.numTriangles = size_t(most - triangles + areTooMany);
        uint64_t next = statistics.numTriangles;
        const auto enumerate = [&] {
          cbvh::forEachCluster(
              *blocks, cbvh::TraversalTime{0.0f, false}, format,
              [&](const cbvh::StoredCluster& cluster) {
                EXPECT_EQ(cluster.firstTriangle, next);
                next += cluster.numTriangles;
                return true;
              },
              statistics);
        };
        if (areTooMany) EXPECT_THROW(enumerate(), rtcore_error) << "format " << int(format);
        else EXPECT_NO_THROW(enumerate()) << "format " << int(format);
        EXPECT_LE(next, most);
        EXPECT_EQ(next == most, !areTooMany);
      }
    }
  }
  rtcReleaseDevice(handle);
}

INSTANTIATE_TEST_SUITE_P(Quads, SurfaceSource, ::testing::Values(1u, 5u, 16u, 40u, 300u));
} // namespace embree::isa
