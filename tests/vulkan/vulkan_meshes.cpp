// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Mesh blocks have the same hits on the device and on the CPU. */

#include "agreement.h"
#include "kernels/cbvh/backend/flat_scene.h"
#include "kernels/cvert/format/mesh_block.h"
#include "support/closed.h"
#include "support/irregular_mesh.h"
#include "support/message_parts.h"
#include "support/moving_surface.h"
#include "support/odd_rays.h"
#include "support/same_hits.h"

namespace programs::test { namespace {

struct BlockCounts {
  size_t grids = 0, meshes = 0;
  size_t ranked = 0, sheared = 0, ofQuads = 0; // of mesh blocks

  void add(RTCScene scene) {
    const embree::cbvh::FlatScene* flat = rtcFlattenScene(scene, embree::cbvh::flatSceneVersion);
    ASSERT_NE(flat, nullptr);
    for (size_t i = 0; i < flat->numBlocks; i++) {
      const bool isMesh = flat->blocks[i].type == embree::cbvh::meshBlockReferenceType;
      grids += !isMesh;
      if (!isMesh) continue;
      const cvert::MeshHeader& block = *static_cast<const cvert::MeshHeader*>(flat->blocks[i].data);
      meshes++;
      ranked += cvert::hasRanksOnAnyAxis(block.spacings);
      sheared += cvert::meshSlope(block.info, 1) != 0 || cvert::meshSlope(block.info, 2) != 0;
      ofQuads += (block.info & cvert::meshHasQuads) != 0;
    }
    rtcReleaseFlatScene(flat);
  }
};

class VulkanMeshes : public VulkanAgreement {
protected:
  // Distances and normals are computed in double precision, by the same operations as on the CPU.
  void expectSameDistances(RTCScene scene, const std::vector<RTCRayHit>& rays) {
    const VulkanScene onDevice = newVulkanScene(device, scene);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    const std::vector<RTCRayHit> traced = traceAll(onDevice.get(), rays);
    size_t hits = 0, others = 0;
    for (size_t i = 0; i < rays.size(); i++) {
      const RTCRayHit expected = intersect(scene, rays[i]);
      const RTCHit &a = expected.hit, &b = traced[i].hit;
      hits += isHit(expected);
      others += expected.ray.tfar != traced[i].ray.tfar || a.primID != b.primID || a.geomID != b.geomID ||
                (isHit(expected) && (a.Ng_x != b.Ng_x || a.Ng_y != b.Ng_y || a.Ng_z != b.Ng_z));
    }
    EXPECT_GT(hits, rays.size() / 10) << "too many rays miss";
    EXPECT_LE(others, 1u) << "of " << rays.size();
  }
};

// Blocks of all forms.
TEST_F(VulkanMeshes, HitsMatchCpu) {
  const Device exact("cbvh_max_error=0");
  Agreement sum;
  BlockCounts blocks;
  for (const Device* of : {static_cast<const Device*>(&embree), &exact})
    for (const NamedMesh& shape : irregularMeshes(random, 0)) {
      SCOPED_TRACE(shape.name + (of == &exact ? ", exact" : ""));
      const MeshScene scene(*of, shape.mesh);
      blocks.add(scene);
      compare(scene, raysAt(random, shape.mesh, 1000), sum,
              of == &exact ? RTC_VULKAN_MEMORY_COPY : RTC_VULKAN_MEMORY_AUTO);
      if (vulkan->handles.hasFloat64) expectSameDistances(scene, raysAt(random, 1000));
      if (HasFatalFailure()) return;
    }
  sum.expect();
  EXPECT_GT(blocks.grids, 20u);
  EXPECT_GT(blocks.meshes, 100u);
  EXPECT_GT(blocks.ranked, 20u);
  EXPECT_GT(blocks.sheared, 20u);
  EXPECT_GT(blocks.ofQuads, 20u);
}

TEST_F(VulkanMeshes, HitsAreBetweenTnearAndTfarAndRespectMasks) {
  Agreement sum;
  Scene scene(embree);
  unsigned mask = 1;
  for (const NamedMesh& shape : irregularMeshes(random, 0)) {
    RTCGeometry geometry = newMesh(embree, shape.mesh, RTC_COMPRESSION_CVERT);
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    mask *= 2;
  }
  addSurface(embree, scene, cubeCage(), smallSurface(RTC_COMPRESSION_CVERT));
  attach(scene, newTriangle(embree, 0.1f));
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = raysAt(random, 20000);
  for (RTCRayHit& ray : rays) { // directions have a length of about 4
    ray.ray.mask = unsigned(random.below(mask));
    ray.ray.tnear = float(random.uniform(0.5, 1.1));
    ray.ray.tfar = ray.ray.tnear + float(random.uniform(0, 0.5));
  }
  compare(scene, rays, sum);
  sum.expect();
}

TEST_F(VulkanMeshes, InstancesMatchCpu) {
  Scene inside(embree), scene(embree);
  const DicedMesh ball = jittered(meshOf(dicedBall(2, 12), QuadOrder::Rows, random), random, 0.01);
  const DicedMesh sheet = meshOf(dicedSheet(1, 50), QuadOrder::Rows, random);
  attach(inside, newMesh(embree, irregularTriangles(ball, random), RTC_COMPRESSION_CVERT));
  attach(inside, newMesh(embree, partlyIrregular(sheet, random, false), RTC_COMPRESSION_CVERT));
  rtcCommitScene(inside);
  attachMovingInstances(embree, scene, inside, random);
  attach(scene, newMesh(embree, irregularQuads(sheet, random), RTC_COMPRESSION_CVERT));
  rtcCommitScene(scene);
  Agreement sum;
  compare(scene, maskedTimedRays(random, 20000), sum);
  sum.expect();
}

// The same mesh three times.
TEST_F(VulkanMeshes, EqualDistancesReportTheSameMesh) {
  for (const NamedMesh& shape : irregularMeshes(random, 0)) {
    SCOPED_TRACE(shape.name);
    Scene scene(embree);
    for (int i = 0; i < 3; i++) attach(scene, newMesh(embree, shape.mesh, RTC_COMPRESSION_CVERT));
    rtcCommitScene(scene);
    const VulkanScene onDevice = newVulkanScene(device, scene);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    const std::vector<RTCRayHit> rays = raysAt(random, shape.mesh, 2000);
    const std::vector<RTCRayHit> traced = traceAll(onDevice.get(), rays);
    size_t others = 0;
    for (size_t i = 0; i < rays.size(); i++) {
      const RTCRayHit expected = intersect(scene, rays[i]);
      ASSERT_EQ(traced[i].hit.geomID, expected.hit.geomID) << "ray " << i;
      others += traced[i].hit.primID != expected.hit.primID;
    }
    EXPECT_LE(others, 1u);
  }
}

// Rays from inside a closed surface, partly of grids, at edges and vertices, with any precision and direction length.
TEST_F(VulkanMeshes, ClosedSurfacesDoNotLeak) {
  const Device exact("cbvh_max_error=0"), coarse("cbvh_max_error=0.02");
  const DicedMesh ball = jittered(meshOf(dicedBall(3, 16), QuadOrder::Rows, random), random, 0.005);
  const DicedMesh triangles = irregularTriangles(ball, random), quads = irregularQuads(ball, random);
  const DicedMesh inPart = partlyIrregular(ball, random, true);
  const DicedMesh notWelded = unwelded(partlyIrregular(ball, random, false));
  for (const Device* of : {static_cast<const Device*>(&embree), &exact, &coarse})
    for (const DicedMesh& mesh : {triangles, quads, inPart, notWelded}) {
      const MeshScene scene(*of, mesh);
      ASSERT_GT(statisticsOf(scene).numIrregularQuads, 1500u);
      const VulkanScene onDevice = newVulkanScene(device, scene);
      ASSERT_NE(onDevice, nullptr) << embree.message;
      std::vector<RTCRayHit> rays;
      for (unsigned i = 0; i < 10000; i++) {
        const unsigned* v = mesh.isTriangleForm() ? mesh.triangles[random.below(unsigned(mesh.size()))].data()
                                                  : mesh.quads[random.below(unsigned(mesh.size()))].data();
        const unsigned n = mesh.isTriangleForm() ? 3 : 4, k = random.below(n);
        rays.push_back(rayFromMiddle(random, mesh.vertices[v[k]], mesh.vertices[v[(k + 1) % n]]));
      }
      for (int exponent : {-60, 0, 40}) {
        std::vector<RTCRayHit> found = withDirections(rays, std::ldexp(1.0f, exponent));
        std::vector<RTCRay> any = withoutHits(found);
        intersectOnDevice(onDevice, found);
        occludedOnDevice(onDevice, any);
        size_t leaks = 0;
        for (size_t i = 0; i < rays.size(); i++) leaks += !isHit(found[i]) + !(any[i].tfar < 0);
        EXPECT_EQ(leaks, 0u) << "length 2^" << exponent << (mesh.isTriangleForm() ? ", triangles" : ", quads");
      }
    }
}

TEST_F(VulkanMeshes, MovingMeshBlocksAreRefused) {
  const DicedMesh sheet = meshOf(dicedSheet(1, 30), QuadOrder::Rows, random);
  for (DicedMesh mesh : {irregularTriangles(sheet, random), irregularQuads(sheet, random)}) {
    mesh.motion = [](const Vec& p, unsigned step) { return twisted(p, 0.1 * step); };
    Scene scene(embree);
    attach(scene, newMesh(embree, mesh, RTC_COMPRESSION_CVERT, 0, 2));
    rtcCommitScene(scene);
    EXPECT_EQ(newVulkanScene(device, scene), nullptr);
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_TRUE(containsInOrder(embree.message, {"moving", "mesh"}));
  }
}

// Devices without 64-bit floats use separate shaders.
TEST_F(VulkanMeshes, DevicesWithoutDoublesMatchCpu) {
  DeviceOptions options;
  options.hasFloat64 = false;
  const ValidatedDevice single(options);
  const VulkanDevice onSingle = open(single.handles);
  ASSERT_NE(onSingle, nullptr) << embree.message;
  size_t rays = 0, others = 0;
  for (const NamedMesh& shape : irregularMeshes(random, 0)) {
    const MeshScene scene(embree, shape.mesh);
    const VulkanScene onDevice = newVulkanScene(onSingle, scene);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    const std::vector<RTCRayHit> aimed = raysAt(random, shape.mesh, 500), traced = traceAll(onDevice.get(), aimed);
    for (size_t i = 0; i < aimed.size(); i++) {
      const RTCRayHit expected = intersect(scene, aimed[i]);
      rays++;
      others += expected.hit.primID != traced[i].hit.primID ||
                std::fabs(expected.ray.tfar - traced[i].ray.tfar) > 1e-4f * expected.ray.tfar;
    }
  }
  EXPECT_LE(others, rays / 500);
}

}} // namespace programs::test
