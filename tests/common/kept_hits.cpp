// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/kept_hits.h"
#include "building/built_scene.h"
#include "scenes/cube.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

namespace cbvh::test {
namespace {

TEST(KeptHits, EveryQueryModeMatchesSingleRays)
{
  const Model model = makeCube();
  BuildSettings build;
  build.level = 3;
  build.threads = 1;
  const BuiltScene scene(model, {RepresentationKind::Grid}, build);
  const Camera camera({3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 40.0f, {101, 97}); // not a multiple of packets or streams
  const std::vector<Ray> rays = primaryRays(camera);
  const std::vector<SurfaceHit> expected = traceClosest(scene, rays, 1);
  for (TraceMode mode :
       {TraceMode::Single, TraceMode::Packet4, TraceMode::Packet8, TraceMode::Packet16, TraceMode::Stream})
    for (Query query : {Closest, Any})
    {
      const std::vector<KeptHit> kept = keepHits(scene, rays, {query, mode, true, 3, 1});
      ASSERT_EQ(kept.size(), rays.size());
      EXPECT_EQ(compareKeptHits(kept, keepHits(scene, rays, {query, mode, true, 1, 1})).all(), 0u) << "with one thread";
      size_t others = 0; // packets may round differently for grazing rays
      for (size_t i = 0; i < rays.size(); i++)
      {
        const SurfaceHit& hit = expected[i];
        const bool same = query == Any || !hit.hit() ||
                          (kept[i].primitive == hit.face && std::abs(kept[i].t - hit.t) < 1e-4f &&
                           std::abs(kept[i].u - hit.u) < 1e-2f && dot(kept[i].normal, hit.normal) > 0);
        others += kept[i].hit != hit.hit() || !same;
      }
      EXPECT_LE(others, rays.size() / 500) << traceModeName(mode) << ", " << queryName(query);
    }
}

TEST(KeptHits, DifferencesAreCountedOnceByTheFirstCriterion)
{
  KeptHit hit;
  hit.hit = true;
  hit.t = 2;
  const std::vector<KeptHit> all(6, hit);
  std::vector<KeptHit> others = all;
  others[0].hit = false;
  others[1].primitive = 7;
  others[1].t = 3;
  others[2].t = std::nextafter(2.0f, 3.0f);
  others[3].normal.z = 1;
  others[4].u = -0.0f; // equal
  const HitDifferences found = compareKeptHits(all, others);
  EXPECT_EQ(found.rays, 6u);
  EXPECT_EQ(found.hits, 1u);
  EXPECT_EQ(found.ids, 1u);
  EXPECT_EQ(found.distances, 1u);
  EXPECT_EQ(found.surfaces, 1u);
  EXPECT_EQ(found.all(), 4u);
}

TEST(KeptHits, NaNEqualsNaN)
{
  KeptHit hit;
  hit.hit = true;
  hit.normal.x = NAN;
  EXPECT_EQ(compareKeptHits({hit}, {hit}).all(), 0u);
}

} // namespace
} // namespace cbvh::test
