// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: rays, at blocks of every shape. */

#include "hard_cases/hard_case.h"
#include "support/reference_check.h"
#include "support/vertex_recorder.h"

namespace programs::test { namespace {

class HardRays : public HardCase {
protected:
  void trace(const std::vector<RayKind>& kinds, unsigned raysPerKind, bool unitLength = true) {
    Random random(31);
    ReferenceCheck check(device, compression());
    for (unsigned height : {0, 1, 3, 5})
      for (Shape shape : allShapes) {
        check.trace(random, randomSheet(random, shape, height, {1, {0, 0, 0}}), kinds, raysPerKind, unitLength);
        if (HasFatalFailure()) return;
      }
    check.conclude();
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardRays, testing::ValuesIn(tracers()), tracerName);

TEST_P(HardRays, AlongAxes) {
  property("rays along an axis, with two zeros in their direction, find the reference's hits");
  trace({RayKind::AlongAxis}, 40);
}

TEST_P(HardRays, ThroughVertices) {
  property("rays through vertices find the reference's hits");
  trace({RayKind::ThroughVertex}, 40);
}

TEST_P(HardRays, AcrossEdges) {
  property("rays through points of edges find the reference's hits");
  trace({RayKind::AcrossEdge}, 40);
}

TEST_P(HardRays, AlongEdges) {
  property("rays that run along an edge find the reference's hits");
  trace({RayKind::AlongEdge}, 40);
}

TEST_P(HardRays, InThePlaneOfALeaf) {
  property("rays in the plane of a leaf find the reference's hits");
  trace({RayKind::InPlaneOfLeaf}, 40);
}

TEST_P(HardRays, FromInsideABlock) {
  property("rays that start inside a block find the reference's hits, none of them before the start");
  trace({RayKind::FromInsideBlock}, 40);
}

TEST_P(HardRays, FromInsideALeaf) {
  property("rays that start inside a leaf find the reference's hits");
  trace({RayKind::FromInsideLeaf}, 40);
}

TEST_P(HardRays, EndInsideABlock) {
  property("rays that end inside a block or a leaf find the reference's hits, none of them beyond the end");
  trace({RayKind::Segment}, 40);
}

TEST_P(HardRays, DirectionsOfLength1em15To1e18) {
  property("the length of a direction, 1e-15 to 1e18, scales t and changes nothing else");
  trace(allRays, 6, false);
}

// Displaced vertices on the borders of blocks, where leaks are most likely.
struct Seams : public VertexRecorder {
  int frameLevel = 3;
  std::vector<Vec> vertices;

  void record(const RTCDisplacementFunctionNArguments& args) override {
    for (unsigned i = 0; i < args.N; i++) {
      const long n = 1 << frameLevel, quads = 16, x = std::lround(quads * args.u[i]),
                 y = std::lround(quads * args.v[i]);
      const bool inside = x > 0 && x < quads && y > 0 && y < quads;
      if (inside && (x * n % quads == 0 || y * n % quads == 0))
        vertices.push_back({args.P_x[i], args.P_y[i], args.P_z[i]});
    }
  }
};

TEST_P(HardRays, FromFarAway) {
  property("rays from 10 to 10,000 block widths away, aimed at vertices between blocks, hit there or before, and do "
           "not slip "
           "through");
  for (float amplitude : {0.0f, 0.05f}) {
    Seams seams;
    seams.amplitude = amplitude;
    Scene scenes[2] = {Scene(device), Scene(device)};
    for (int i = 0; i < 2; i++) {
      SurfaceSettings settings;
      settings.frameLevel = seams.frameLevel;
      settings.compression = i ? compression() : RTC_COMPRESSION_NONE;
      seams.build(device, scenes[i], quadCage(), settings);
    }
    ASSERT_FALSE(seams.vertices.empty());
    Random random(33);
    unsigned leaks[2] = {};
    for (int i = 0; i < 20000; i++) {
      const Vec& target = seams.vertices[random.below(uint32_t(seams.vertices.size()))];
      Vec o, d;
      const double away = random.magnitude(1, 1000);
      for (int k = 0; k < 3; k++) {
        o[k] = float(away * (k == 2 ? 1 : random.uniform(-0.7, 0.7)));
        d[k] = target[k] - o[k];
      }
      const RTCRayHit ray = makeRay(o, d);
      for (int k = compression() == RTC_COMPRESSION_CGRID ? 0 : 1; k < 2; k++)
        leaks[k] += !isHit(intersect(scenes[k], ray));
    }
    // cGRID has GRID's triangles, where some rays pass through edges
    EXPECT_LE(leaks[1], leaks[0] + 5 * std::sqrt(leaks[0])) << "amplitude " << amplitude;
  }
}

// Upstream's limits: the square of a direction and 1/direction must be floats.
TEST_P(HardRays, RaysBeyondLimitsTerminate) {
  property(
      "rays beyond Embree's limits (directions longer than 1.8e18, shorter than 1e-18, zero, infinite or NaN, such "
      "origins) terminate, and hit within [tnear, tfar] or not at all");
  Random random(32);
  const Sheet sheet = randomSheet(random, Shape::Waves, 4, {1, {0, 0, 0}});
  Scene scene(device);
  commitSheet(device, scene, sheet, compression());
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const float values[] = {0,  -0.0f, 1e-45f, 1e-38f, 1e-20f,   -1e-20f,   1,
                          -1, 1e20f, -1e20f, 3e38f,  infinity, -infinity, nan};
  auto any = [&] { return values[random.below(sizeof(values) / sizeof(float))]; };
  for (int i = 0; i < 20000; i++) {
    RTCRayHit ray = randomRay(random, allRays[random.below(uint32_t(allRays.size()))], sheet);
    float* const fields[] = {&ray.ray.dir_x, &ray.ray.dir_y, &ray.ray.dir_z,
                             &ray.ray.org_x, &ray.ray.org_y, &ray.ray.org_z};
    if (i % 4 == 0) { // the whole direction, scaled by a power of ten
      const float length = std::pow(10.0f, float(random.uniform(18, 38)) * (random.chance(0.5) ? 1 : -1));
      for (int k = 0; k < 3; k++) *fields[k] *= length;
    } else
      for (unsigned k = 0; k < 1 + random.below(3); k++) *fields[random.below(i % 4 == 1 ? 6 : 3)] = any();
    const RTCRayHit hit = intersect(scene, ray);
    occluded(scene, ray);
    if (isHit(hit)) { ASSERT_TRUE(hit.ray.tfar >= ray.ray.tnear && hit.ray.tfar <= ray.ray.tfar) << hit.ray.tfar; }
  }
}

}} // namespace programs::test
