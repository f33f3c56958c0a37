// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* On a device, rays have the same hits in tiles as in the blocks that tiles were made from, to the bit. */

#include "kernels/cbvh/backend/flat_scene.h"
#include "kernels/cvert/format/tile.h"
#include "small_scenes.h"
#include "support/irregular_mesh.h"
#include "support/same_hits.h"
#include "vulkan_tracer.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <sstream>

namespace programs::test { namespace {

class VulkanTiles : public SharedVulkanTest {
protected:
  Random random{97};

  /* Traces a scene that add() fills, in both forms. */
  void compare(const std::vector<RTCRayHit>& rays, const std::function<void(RTCScene, RTCCompression)>& add) {
    compare(rays, embree, add);
  }

  void compare(const std::vector<RTCRayHit>& rays, RTCDevice owner,
               const std::function<void(RTCScene, RTCCompression)>& add) {
    std::vector<RTCRayHit> hits[2] = {rays, rays};
    std::vector<RTCRay> any[2];
    unsigned kinds[2];
    for (int i = 0; i < 2; i++) {
      Scene scene(owner);
      add(scene, i == 0 ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT);
      rtcCommitScene(scene);
      const VulkanScene onDevice =
          newVulkanScene(device, scene, i == 0 ? RTC_VULKAN_MEMORY_AUTO : RTC_VULKAN_MEMORY_COPY);
      ASSERT_NE(onDevice, nullptr) << embree.message;
      kinds[i] = rtcGetVulkanSceneLeafKinds(onDevice.get());
      if (i == 0) countWidths(scene);
      for (const RTCRayHit& ray : rays) any[i].push_back(ray.ray);
      intersectOnDevice(onDevice, hits[i]);
      occludedOnDevice(onDevice, any[i]);
    }
    tileScenes += kinds[0] != kinds[1];
    for (size_t r = 0; r < rays.size(); r++) {
      const RTCRayHit &a = hits[0][r], &b = hits[1][r];
      found += isHit(a);
      ASSERT_EQ(std::memcmp(&a.hit, &b.hit, sizeof(RTCHit)), 0)
          << "ray " << r << ": " << a.hit.primID << " and " << b.hit.primID;
      ASSERT_EQ(a.ray.tfar, b.ray.tfar) << "ray " << r;
      ASSERT_EQ(any[0][r].tfar < 0, isHit(a)) << "ray " << r;
      ASSERT_EQ(any[1][r].tfar < 0, isHit(a)) << "ray " << r;
    }
  }

  size_t tileScenes = 0, found = 0;
  size_t convertedScenes = 0;        // with blocks that were made from mesh tiles
  std::map<uint32_t, size_t> widths; // tiles, by bytes per vertex

private:
  void countWidths(RTCScene scene) {
    const embree::cbvh::FlatScene* flat = rtcFlattenScene(scene, embree::cbvh::flatSceneVersion);
    ASSERT_TRUE(flat);
    convertedScenes += flat->hasOwnBlocks;
    for (size_t i = 0; i < flat->numBlocks; i++)
      if (flat->blocks[i].type == embree::cbvh::blockReferenceType(embree::cbvh::kindTile))
        widths[cvert::tileVertexBytes((const cvert::VertHeader*)flat->blocks[i].data)]++;
    rtcReleaseFlatScene(flat);
  }
};

TEST_F(VulkanTiles, CagesHaveTheHitsOfBlocks) {
  Cage withHole = sheetCage(4);
  withHole.holes = {5};
  for (const Cage& cage : {cubeCage(), prismCage(3), prismCage(5), withHole})
    for (float rate : {8.0f, 13.0f, 16.0f, 40.0f}) {
      Displacement displacement;
      compare(raysAt(random, 3000), [&](RTCScene scene, RTCCompression form) {
        addSurface(embree, scene, cage, displacedSettings(displacement, form, rate));
      });
    }
  EXPECT_EQ(tileScenes, 16u);
  EXPECT_GT(found, 10000u);
}

TEST_F(VulkanTiles, StitchedEdgesAndHolesHaveTheHitsOfBlocks) {
  Displacement displacement;
  displacement.poison = [](unsigned primID, float u, float v) {
    return primID % 2 == 0 && u > 0.3f && u < 0.45f && v > 0.4f && v < 0.6f;
  };
  for (unsigned i = 0; i < 4; i++) {
    SurfaceSettings settings = displacedSettings(displacement, RTC_COMPRESSION_CTILE, 32);
    const Cage cage = cubeCage();
    for (size_t f = 0, k = 0; f < cage.faces.size(); k += cage.faces[f++])
      for (unsigned e = 0; e < cage.faces[f]; e++) {
        const unsigned a = cage.indices[k + e], b = cage.indices[k + (e + 1) % cage.faces[f]];
        settings.edgeRates.push_back(float(9 + (a * 7 + b * 7 + a * b * 3 + i * 5) % 23));
      }
    compare(raysAt(random, 5000), [&](RTCScene scene, RTCCompression form) {
      settings.compression = form;
      addSurface(embree, scene, cage, settings);
    });
    embree.takeError(); // reports the vertices
  }
  EXPECT_EQ(tileScenes, 4u);
}

TEST_F(VulkanTiles, GridsAndMeshesHaveTheHitsOfBlocks) {
  for (const Diced& diced : {dicedSheet(1, 50), dicedSheet(3, 16), dicedSheet(1, 300), dicedBall(2, 11)})
    compare(raysAt(random, 3000),
            [&](RTCScene scene, RTCCompression form) { attach(scene, newGrids(embree, diced, form)); });
  for (QuadOrder order : allQuadOrders) {
    const DicedMesh quads = meshOf(dicedSheet(3, 16), order, random);
    for (const DicedMesh& mesh : {quads, halvesApart(trianglesOf(quads, 0, 1)), trianglesOf(quads, 1, 2)})
      compare(raysAt(random, 2000),
              [&](RTCScene scene, RTCCompression form) { attach(scene, newMesh(embree, mesh, form)); });
  }
  EXPECT_GT(tileScenes, 4u);
}

// A device traces mesh tiles as the mesh blocks that they were made from.
TEST_F(VulkanTiles, IrregularMeshesHaveTheHitsOfBlocks) {
  const std::vector<NamedMesh> meshes = irregularMeshes(random, 0);
  for (const NamedMesh& shape : meshes)
    compare(raysAt(random, shape.mesh, 2000),
            [&](RTCScene scene, RTCCompression form) { attach(scene, newMesh(embree, shape.mesh, form)); });
  EXPECT_EQ(convertedScenes, meshes.size());
  EXPECT_GT(found, 1000u);
}

// Residuals of 2, 3, 4 and 5 bytes, and floats.
TEST_F(VulkanTiles, EveryPrecisionHasTheHitsOfBlocks) {
  for (int bits = 5; bits <= 24; bits++) {
    SCOPED_TRACE(bits);
    std::ostringstream settings;
    settings << "cbvh_max_error=" << (bits == 24 ? 0 : std::ldexp(1.0, -bits));
    const Device owner(settings.str());
    Displacement displacement;
    compare(raysAt(random, 2000), owner, [&](RTCScene scene, RTCCompression form) {
      addSurface(owner, scene, cubeCage(), displacedSettings(displacement, form, 32));
    });
  }
  EXPECT_EQ(tileScenes, 20u);
  for (uint32_t width : {2u, 3u, 4u, 5u, cvert::tileFloatBytes}) EXPECT_GT(widths[width], 0u) << width;
}

TEST_F(VulkanTiles, InstancesHaveTheHitsOfBlocks) {
  Displacement displacement;
  compare(raysAt(random, 10000), [&](RTCScene scene, RTCCompression form) {
    Scene inside(embree);
    addSurface(embree, inside, cubeCage(), displacedSettings(displacement, form, 24));
    rtcCommitScene(inside);
    for (float z : {-0.7f, 0.0f, 0.4f}) attach(scene, newInstance(embree, inside, z));
  });
  EXPECT_EQ(tileScenes, 1u);
}

}} // namespace programs::test
