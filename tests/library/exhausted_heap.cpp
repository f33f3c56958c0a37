// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Loaded geometries are released while the heap is exhausted: the process continues, and other geometries are traced as
 * before, also by rays that find no memory for a list of loaded geometries. */

#include "support/exhaustible_heap.h"
#include "support/file_mutations.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

#include <memory>

namespace programs::test { namespace {

TEST(ExhaustedHeap, LoadedGeometriesAreReleased) {
  Folder folder;
  Device device;
  const std::string path = folder / "a.cbvh", damaged = folder / "b.cbvh";
  RTCGeometry geometry = allSaveable()[0].make(device);
  ASSERT_TRUE(saveGeometryFile(geometry, path.c_str()));
  rtcReleaseGeometry(geometry);
  FileBytes file(bytesOf(path));
  std::fill_n(file.bytes.begin() + ptrdiff_t(file.record(0).blocks), file.record(0).blockBytes, '\0');
  writeBytes(damaged, file.bytes);
  Random random(1);
  const std::vector<RTCRayHit> rays = raysAt(random, 500);
  const auto load = [&](const std::string& from) {
    RTCGeometry loaded = loadGeometryFile(device, from.c_str());
    EXPECT_NE(loaded, nullptr) << device.message;
    return loaded;
  };
  const auto sceneOf = [&](RTCGeometry geometry) {
    auto scene = std::make_unique<Scene>(device);
    rtcAttachGeometry(*scene, geometry);
    rtcCommitScene(*scene);
    return scene;
  };
  const auto countHits = [&](const std::unique_ptr<Scene>& scene) {
    size_t hits = 0;
    for (const RTCRayHit& ray : rays) hits += isHit(intersect(*scene, ray));
    return hits;
  };
  RTCGeometry first = load(path), second = load(path), third = load(damaged);
  const size_t hits = countHits(sceneOf(first));
  EXPECT_GT(hits, 100u);
  std::unique_ptr<Scene> scene = sceneOf(second), sceneOfDamaged = sceneOf(third);
  isExhausted = true;
  rtcReleaseGeometry(first);
  const size_t hitsWithoutMemory = countHits(scene);
  isExhausted = false;
  EXPECT_GT(refused, 0u) << "no allocation was refused, so nothing is tested";
  EXPECT_EQ(hitsWithoutMemory, hits);
  EXPECT_EQ(device.errors, 0u);
  EXPECT_EQ(countHits(sceneOfDamaged), 0u) << "damaged blocks must still be detected";
  EXPECT_EQ(device.errors, 1u);
  scene.reset();
  sceneOfDamaged.reset();
  RTCGeometry fourth = load(path);
  EXPECT_EQ(countHits(sceneOf(fourth)), hits);
  // second and third have numbers of their own, because the number of the file was in use
  isExhausted = true;
  for (RTCGeometry other : {second, third, fourth}) rtcReleaseGeometry(other);
  isExhausted = false;
}

}} // namespace programs::test
