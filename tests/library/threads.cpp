// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Several threads trace one scene, and commit scenes of one device, concurrently. All threads must get
 * the same results, without data races under ThreadSanitizer. */

#include "support/random.h"
#include "support/scene.h"

#include <thread>

namespace programs::test { namespace {

constexpr unsigned threadCount = 4;
constexpr unsigned surfaceCount = 5; // one per representation

void addSurfaces(RTCDevice device, RTCScene scene, Displacement displacements[surfaceCount]) {
  int i = 0;
  for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL,
                                     RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT}) {
    SurfaceSettings settings;
    settings.displacement = &displacements[i];
    settings.compression = compression;
    displacements[i].offset = {3.0f * float(i), 0, 0};
    addSurface(device, scene, trapezohedronCage(5), settings);
    i++;
  }
}

// The same number of rays at each surface, from around all of them.
std::vector<RTCRayHit> makeRays() {
  Random random(83);
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 1000; i++) {
    Vec org, dir;
    for (int k = 0; k < 3; k++) {
      org[k] = float(random.uniform(-4, 4));
      dir[k] = float(random.uniform(-0.7, 0.7)) - org[k];
    }
    const float offset = float(random.uniform(0, 3 * (surfaceCount - 1)));
    org[0] += offset;
    dir[0] += 3.0f * float(i % surfaceCount) - offset;
    rays.push_back(makeRay(org, dir));
  }
  return rays;
}

struct Answers {
  std::vector<char> bytes;          // hits and occlusion of all rays
  unsigned hits[surfaceCount] = {}; // rays whose first hit is on each of the surfaces
  unsigned occludedRays = 0;
};

Answers trace(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  Answers answers;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit hit = intersect(scene, ray);
    const bool isOccluded = occluded(scene, ray);
    answers.bytes.insert(answers.bytes.end(), (const char*)&hit, (const char*)(&hit + 1));
    answers.bytes.push_back(isOccluded);
    if (isHit(hit) && hit.hit.geomID < surfaceCount) answers.hits[hit.hit.geomID]++;
    answers.occludedRays += isOccluded;
  }
  return answers;
}

// Otherwise equal results would mean nothing: an eighth of all rays hit each surface, and as many rays are occluded as
// hit one.
void expectThatRaysMeetEverySurface(const Answers& answers, size_t rays) {
  unsigned sum = 0;
  for (unsigned i = 0; i < surfaceCount; i++) {
    EXPECT_GE(answers.hits[i], rays / 8) << "surface " << i;
    sum += answers.hits[i];
  }
  EXPECT_EQ(answers.occludedRays, sum);
}

template<typename Work>
void inThreads(const Work& work) {
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < threadCount; i++) threads.emplace_back([&work, i]() { work(i); });
  for (std::thread& thread : threads) thread.join();
}

TEST(Threads, TracingOneSceneMatchesSingleThread) {
  Device device;
  Displacement displacements[surfaceCount];
  Scene scene(device);
  addSurfaces(device, scene, displacements);
  rtcCommitScene(scene);
  const std::vector<RTCRayHit> rays = makeRays();
  const Answers expected = trace(scene, rays);
  expectThatRaysMeetEverySurface(expected, rays.size());
  bool same[threadCount] = {};
  inThreads([&](unsigned i) { same[i] = trace(scene, rays).bytes == expected.bytes; });
  for (bool s : same) EXPECT_TRUE(s);
}

TEST(Threads, CommittingScenesOfOneDeviceConcurrently) {
  Device device;
  const std::vector<RTCRayHit> rays = makeRays();
  Answers answers[threadCount];
  inThreads([&](unsigned i) {
    Displacement displacements[surfaceCount];
    Scene scene(device);
    addSurfaces(device, scene, displacements);
    rtcCommitScene(scene);
    answers[i] = trace(scene, rays);
  });
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  expectThatRaysMeetEverySurface(answers[0], rays.size());
  for (const Answers& a : answers) EXPECT_TRUE(a.bytes == answers[0].bytes);
}

}} // namespace programs::test
