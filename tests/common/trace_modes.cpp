// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hits and timings of all ways to trace, compared with single rays. */

#include "basics/error.h"
#include "building/built_scene.h"
#include "scenes/cube.h"
#include "support/address_space.h"
#include "support/message_parts.h"
#include "tracing/hit_records.h"
#include "tracing/trace_hits.h"
#include "tracing/trace_timing.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace programs::test { namespace {

constexpr TraceMode allModes[] = {TraceMode::Single, TraceMode::Packet4, TraceMode::Packet8, TraceMode::Packet16,
                                  TraceMode::Stream};

/* Primary rays at a cube. Their number is not a multiple of packets or streams. */
struct CubeRays {
  const Model model = makeCube();
  const BuiltScene scene{model, {RepresentationKind::Grid}, settings()};
  const std::vector<Ray> rays = primaryRays(Camera({3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 40.0f, {101, 97}));
  const std::vector<SurfaceHit> expected = traceClosest(scene, rays, 1);

  static BuildSettings settings() {
    BuildSettings build;
    build.level = 3;
    build.threads = 1;
    return build;
  }
};

TEST(KeptHits, EveryQueryModeMatchesSingleRays) {
  const CubeRays cube;
  for (TraceMode mode : allModes)
    for (Query query : {Closest, Any}) {
      const std::vector<HitRecord> kept = recordHits(cube.scene, cube.rays, {query, mode, true, 3, 1});
      ASSERT_EQ(kept.size(), cube.rays.size());
      EXPECT_EQ(compareHitRecords(kept, recordHits(cube.scene, cube.rays, {query, mode, true, 1, 1})).all(), 0u)
          << "with one thread";
      size_t others = 0; // packets may round differently for grazing rays
      for (size_t i = 0; i < cube.rays.size(); i++) {
        const SurfaceHit& hit = cube.expected[i];
        const bool same = query == Any || !hit.hit() ||
                          (kept[i].primitive == hit.face && std::abs(kept[i].t - hit.t) < 1e-4f &&
                           std::abs(kept[i].u - hit.u) < 1e-2f && dot(kept[i].normal, hit.normal) > 0);
        others += kept[i].hit != hit.hit() || !same;
      }
      EXPECT_LE(others, cube.rays.size() / 500) << traceModeName(mode) << ", " << queryName(query);
    }
}

TEST(KeptHits, DifferencesAreCountedOnceByTheFirstCriterion) {
  HitRecord hit;
  hit.hit = true;
  hit.t = 2;
  const std::vector<HitRecord> all(6, hit);
  std::vector<HitRecord> others = all;
  others[0].hit = false;
  others[1].primitive = 7;
  others[1].t = 3;
  others[2].t = std::nextafter(2.0f, 3.0f);
  others[3].normal.z = 1;
  others[4].u = -0.0f; // equal
  const HitDifferences found = compareHitRecords(all, others);
  EXPECT_EQ(found.rays, 6u);
  EXPECT_EQ(found.hits, 1u);
  EXPECT_EQ(found.ids, 1u);
  EXPECT_EQ(found.distances, 1u);
  EXPECT_EQ(found.surfaces, 1u);
  EXPECT_EQ(found.all(), 4u);
}

TEST(KeptHits, NaNEqualsNaN) {
  HitRecord hit;
  hit.hit = true;
  hit.normal.x = NAN;
  EXPECT_EQ(compareHitRecords({hit}, {hit}).all(), 0u);
}

TEST(TraceTiming, EveryModeFindsTheSameHits) {
  const CubeRays cube;
  size_t expected = 0;
  for (const SurfaceHit& hit : cube.expected) expected += hit.hit();
  ASSERT_GT(expected, cube.rays.size() / 20);
  ASSERT_LT(expected, cube.rays.size());
  for (TraceMode mode : allModes)
    for (Query query : {Closest, Any})
      for (bool coherent : {false, true})
        for (unsigned threads : {1u, 3u}) {
          const TraceTiming timing = timeTrace(cube.scene, cube.rays, {query, mode, coherent, threads, 2});
          /* Packets may round differently for grazing rays. */
          EXPECT_NEAR(double(timing.hits), double(expected), 3.0)
              << traceModeName(mode) << ", " << queryName(query) << ", " << threads << " threads";
          EXPECT_GT(timing.seconds, 0.0);
        }
}

TEST(TraceTiming, ThreadsThatTheSystemRefusesAreReported) {
  const CubeRays cube;
  const auto child = [&] {
    limitAddressSpace(size_t(64) << 20);
    try {
      const unsigned passes = 10000; // work for all threads
      timeTrace(cube.scene, cube.rays, {Closest, TraceMode::Single, false, 10000, passes});
    } catch (const Error& e) {
      const std::string message = e.what(); // ends with the number of threads that are possible
      const unsigned long most = std::strtoul(&message[message.find_last_not_of("0123456789") + 1], nullptr, 10);
      std::_Exit(containsInOrder(message, {" 10000 "}) && most > 0 && most < 10000 ? 0 : 1);
    }
    std::_Exit(2);
  };
  EXPECT_EXIT(child(), testing::ExitedWithCode(0), "");
}

TEST(TraceTiming, NamesRoundTrip) {
  for (TraceMode mode : allModes) EXPECT_EQ(parseTraceMode(traceModeName(mode)), mode);
  EXPECT_EQ(parseQuery("any"), Any);
  EXPECT_THROW(parseTraceMode("packet"), Error);
  EXPECT_THROW(parseQuery(""), Error);
}

}} // namespace programs::test
