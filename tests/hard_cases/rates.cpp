// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: edge rates, of faces that are compressed or left to GRID. */

#include "hard_cases/hard_case.h"
#include "support/edge_rates.h"
#include "support/grid_agreement.h"

namespace programs::test { namespace {

class HardRates : public HardCase {
protected:
  /* rates: of all half-edges, equal on both sides of each edge. GRID's surface is within the reach of the leaf that is
   * hit, without additional slack for different tessellations: the vertices of both are on the displaced surface or,
   * along an edge of a lower rate, on the same polyline. A patch has as many quads along u and v as GRID, or up to
   * twice as many, so that the lines of GRID's vertices are no farther from a quad than the quad's size. Between its
   * vertices, GRID deviates from the surface by the sag of a chord, a fraction of that. */
  void expectTightAndNear(const Cage& cage, const std::vector<float>& rates) {
    Random random(71);
    Displacement displacement;
    std::vector<RTCRayHit> inside;
    for (int i = 0; i < 2000; i++)
      inside.push_back(makeRay({0, 0, 0}, {float(random.normal()), float(random.normal()), float(random.normal())}));
    for (int frameLevel : {0, 1, 3}) {
      SCOPED_TRACE(testing::Message() << "rate " << rates[0] << ", frame level " << frameLevel);
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = compression();
      settings.frameLevel = frameLevel;
      settings.edgeRates = rates;
      const Twins twins(device, cage, settings);
      expectHitsNearGrid(twins.grid, twins.scene, raysAt(random, 500));
      if (HasFatalFailure()) return;
      expectNoLeaks(twins.grid, twins.scene, inside, compression());
    }
  }

  void expectTightAndNear(float rate) {
    property("edges of rate " + std::to_string(int(rate)) + ": hits agree with GRID's, and no ray from inside leaks");
    expectTightAndNear(cubeCage(), std::vector<float>(24, rate));
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardRates, testing::ValuesIn(tracers()), tracerName);

TEST_P(HardRates, Rate1) { expectTightAndNear(1); }
TEST_P(HardRates, Rate2) { expectTightAndNear(2); }
TEST_P(HardRates, Rate5) { expectTightAndNear(5); }
TEST_P(HardRates, Rate13) { expectTightAndNear(13); }
TEST_P(HardRates, Rate64) { expectTightAndNear(64); }

TEST_P(HardRates, Mixed) {
  property("faces whose edges have different rates: hits agree with GRID's, and no ray from inside leaks");
  const float choice[] = {1, 2, 5, 8, 13, 16, 64};
  Random random(72);
  for (int repeat = 0; repeat < 4; repeat++) {
    const Cage cage = cubeCage();
    const std::vector<float> rates = drawRates(cage, random, [&](Random& r) { return choice[r.below(7)]; });
    expectTightAndNear(cage, rates);
    if (HasFatalFailure()) return;
  }
}

// Opposite edges of rate 1 keep the face small.
TEST_P(HardRates, Rate4096) {
  property("edges of rate 4096, the most that Embree supports, next to edges of rate 1: hits on a plane are exact");
  SurfaceSettings settings;
  settings.compression = compression();
  settings.edgeRates = {4096, 1, 4096, 1};
  const SurfaceScene scene(device, quadCage(), settings);
  Random random(73);
  for (int i = 0; i < 2000; i++) {
    const float x = float(random.uniform(0.01, 0.99)), y = float(random.uniform(0.01, 0.99));
    const RTCRayHit ray = makeRay({x, y, 1}, {0, 0, -1}), hit = intersect(scene, ray);
    ASSERT_TRUE(isHit(hit) && occluded(scene, ray));
    ASSERT_NEAR(hit.ray.tfar, 1, 1e-4f);
    ASSERT_NEAR(hit.hit.u, x, 1e-3f);
    ASSERT_NEAR(hit.hit.v, y, 1e-3f);
  }
}

}} // namespace programs::test
