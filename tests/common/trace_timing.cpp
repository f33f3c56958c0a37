// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_timing.h"
#include "basics/error.h"
#include "building/built_scene.h"
#include "scenes/cube.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

TEST(TraceTiming, EveryModeFindsTheSameHits)
{
  const Model model = makeCube();
  BuildSettings build;
  build.level = 3;
  build.threads = 1;
  const BuiltScene scene(model, {RepresentationKind::Grid}, build);
  const Camera camera({3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 40.0f, {101, 97}); // not a multiple of packets or streams
  const std::vector<Ray> rays = primaryRays(camera);
  size_t expected = 0;
  for (const SurfaceHit& hit : traceClosest(scene, rays, 1))
    expected += hit.hit();
  ASSERT_GT(expected, rays.size() / 20);
  ASSERT_LT(expected, rays.size());
  for (TraceMode mode :
       {TraceMode::Single, TraceMode::Packet4, TraceMode::Packet8, TraceMode::Packet16, TraceMode::Stream})
    for (Query query : {Closest, Any})
      for (bool coherent : {false, true})
        for (unsigned threads : {1u, 3u})
        {
          const TraceTiming timing = timeTrace(scene, rays, {query, mode, coherent, threads, 2});
          /* Packets may round differently for grazing rays. */
          EXPECT_NEAR(double(timing.hits), double(expected), 3.0)
            << traceModeName(mode) << ", " << queryName(query) << ", " << threads << " threads";
          EXPECT_GT(timing.seconds, 0.0);
        }
}

TEST(TraceTiming, NamesRoundTrip)
{
  for (TraceMode mode :
       {TraceMode::Single, TraceMode::Packet4, TraceMode::Packet8, TraceMode::Packet16, TraceMode::Stream})
    EXPECT_EQ(parseTraceMode(traceModeName(mode)), mode);
  EXPECT_EQ(parseQuery("any"), Any);
  EXPECT_THROW(parseTraceMode("packet"), Error);
  EXPECT_THROW(parseQuery(""), Error);
}

} // namespace
} // namespace cbvh::test
