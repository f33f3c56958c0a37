// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Several threads trace one scene, and commit scenes of one device, at the same time: they
 * get what one thread gets. Under ThreadSanitizer, without a race. */

#include "support/random.h"
#include "support/scene.h"

#include <algorithm>
#include <thread>

namespace cbvh::test {
namespace {

constexpr unsigned threadCount = 4;

// One surface of each representation, side by side.
void addSurfaces(RTCDevice device, RTCScene scene, Displacement displacements[4])
{
  int i = 0;
  for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_GRID, RTC_COMPRESSION_VOXEL, RTC_COMPRESSION_LEAF}) {
    SurfaceSettings settings;
    settings.displacement = &displacements[i];
    settings.compression = compression;
    displacements[i].offset = {3.0f*float(i), 0, 0};
    addSurface(device, scene, trapezohedronCage(5), settings);
    i++;
  }
}

std::vector<RTCRayHit> makeRays()
{
  Random random(83);
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 1000; i++) {
    Vec org, dir;
    for (int k = 0; k < 3; k++) { org[k] = float(random.uniform(-4, 4)); dir[k] = float(random.normal()); }
    org[0] += float(random.uniform(0, 9));
    rays.push_back(makeRay(org, dir));
  }
  return rays;
}

// Hits and occlusion of all rays, as bytes.
std::vector<char> trace(RTCScene scene, const std::vector<RTCRayHit>& rays)
{
  std::vector<char> answers;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit hit = intersect(scene, ray);
    answers.insert(answers.end(), (const char*)&hit, (const char*)(&hit + 1));
    answers.push_back(occluded(scene, ray));
  }
  return answers;
}

template<typename Work>
void inThreads(const Work& work)
{
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < threadCount; i++) threads.emplace_back([&work, i]() { work(i); });
  for (std::thread& thread : threads) thread.join();
}

TEST(Threads, TraceOneSceneAlike)
{
  Device device;
  Displacement displacements[4];
  Scene scene(device);
  addSurfaces(device, scene, displacements);
  rtcCommitScene(scene);
  const std::vector<RTCRayHit> rays = makeRays();
  const std::vector<char> expected = trace(scene, rays);
  bool same[threadCount] = {};
  inThreads([&](unsigned i) { same[i] = trace(scene, rays) == expected; });
  for (bool s : same) EXPECT_TRUE(s);
}

TEST(Threads, CommitScenesOfOneDeviceAtOnce)
{
  Device device;
  const std::vector<RTCRayHit> rays = makeRays();
  std::vector<char> answers[threadCount];
  inThreads([&](unsigned i) {
    Displacement displacements[4];
    Scene scene(device);
    addSurfaces(device, scene, displacements);
    rtcCommitScene(scene);
    answers[i] = trace(scene, rays);
  });
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_NE(std::count(answers[0].begin(), answers[0].end(), 1), 0) << "no ray meets anything";
  for (const auto& a : answers) EXPECT_EQ(a, answers[0]);
}

} // namespace
} // namespace cbvh::test
