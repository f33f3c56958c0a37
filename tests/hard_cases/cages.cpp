// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: cages. */

#include "hard_cases/hard_case.h"
#include "support/grid_agreement.h"

namespace programs::test { namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

class HardCages : public HardCase {
protected:
  // For frame levels from one block per face to one block per quad. gap: largest gap between GRID's own vertices.
  void expectAgreement(const Cage& cage, const std::vector<RTCRayHit>& raysFromInside = {}, float gap = 0) {
    for (int frameLevel : {0, 1, 2, 4}) {
      SCOPED_TRACE(testing::Message() << "frame level " << frameLevel);
      Random random(51);
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = compression();
      settings.frameLevel = frameLevel;
      const Twins twins(device, cage, settings);
      ASSERT_EQ(statisticsOf(twins.scene).numUncompressedQuads + statisticsOf(twins.scene).numInvalidQuads, 0u);
      const std::vector<RTCRayHit> rays = raysAt(random, 800);
      if (gap > 0) expectHitsNearGrid(twins.grid, twins.scene, rays, gap);
      else if (compression() == RTC_COMPRESSION_CGRID) expectEqualToGrid(twins.grid, twins.scene, rays, cage);
      else expectCloseToGrid(twins.grid, twins.scene, rays, cage, settings);
      if (HasFatalFailure()) return;
      expectNoLeaks(twins.grid, twins.scene, raysFromInside, compression());
      if (HasFatalFailure()) return;
    }
  }

  void expectAgreementAndNoLeaks(const Cage& cage) {
    Random random(52);
    expectAgreement(cage, raysFromInside(random, cage));
  }

  void expectNoLeaksFromInside(const Cage& cage) {
    Random random(52);
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = compression();
    const Twins twins(device, cage, settings);
    expectNoLeaks(twins.grid, twins.scene, raysFromInside(random, cage), compression());
  }

  Displacement displacement;

private:
  // Rays from near the center of a closed cage, in all directions and towards its vertices.
  static std::vector<RTCRayHit> raysFromInside(Random& random, const Cage& cage) {
    std::vector<RTCRayHit> rays;
    for (int i = 0; i < 1000; i++) {
      Vec o, d;
      const Vec& target = cage.positions[random.below(uint32_t(cage.positions.size()))];
      const double beside = i % 2 ? 1 : random.magnitude(1e-6, 1);
      for (int k = 0; k < 3; k++) {
        o[k] = i % 4 ? float(random.uniform(-0.1, 0.1)) : 0;
        d[k] = float((i % 2 ? 0 : target[k]) + beside * random.normal());
      }
      rays.push_back(makeRay(o, d));
    }
    return rays;
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardCages, testing::ValuesIn(tracers()), tracerName);

TEST_P(HardCages, Valences3To16) {
  property("around vertices of valence 3 to 16 hits agree with GRID's, and no ray from inside leaks");
  for (unsigned n : {3, 4, 5, 8, 16}) {
    SCOPED_TRACE(testing::Message() << "valence " << n);
    expectAgreementAndNoLeaks(trapezohedronCage(n));
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, Valences33And64) {
  property(
      "around vertices of valence 33 and 64, the most that stock Embree supports, hits agree with GRID's, and no ray "
      "from inside leaks");
  for (unsigned n : {33, 64}) {
    SCOPED_TRACE(testing::Message() << "valence " << n);
    expectAgreementAndNoLeaks(trapezohedronCage(n));
    if (HasFatalFailure()) return;
  }
}

// Frames do not fit such needles well.
TEST_P(HardCages, Valences65To100) {
  property("around vertices of valence 65 to 100, whose faces stock Embree leaves out, no ray from inside leaks, and "
           "hits of "
           "cVERT agree with GRID's");
  for (unsigned n : {65, 100}) {
    SCOPED_TRACE(testing::Message() << "valence " << n);
    if (compression() == RTC_COMPRESSION_CVERT) expectAgreementAndNoLeaks(trapezohedronCage(n));
    else expectNoLeaksFromInside(trapezohedronCage(n));
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, Valence1025) {
  property(
      "faces at vertices of valence 1025, past the limit, are left out as GRID leaves them out, and hits on all others "
      "agree with GRID's");
  for (unsigned n : {1025}) {
    SCOPED_TRACE(testing::Message() << "valence " << n);
    Cage cage = cubeCage();
    const Cage poles = trapezohedronCage(n);
    for (unsigned i : poles.indices) cage.indices.push_back(i + unsigned(cage.positions.size()));
    cage.faces.insert(cage.faces.end(), poles.faces.begin(), poles.faces.end());
    cage.positions.insert(cage.positions.end(), poles.positions.begin(), poles.positions.end());
    expectAgreement(cage);
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, FacesOf3To9Edges) {
  property(
      "on triangles, pentagons and faces of up to 9 edges, whose sub-patches have their own parameters, hits, u and v "
      "agree with GRID's, and no ray from inside leaks");
  for (unsigned n : {3, 5, 6, 7, 9}) {
    SCOPED_TRACE(testing::Message() << n << " edges");
    expectAgreementAndNoLeaks(prismCage(n));
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, CreasesOfEverySharpness) {
  property("at creases of sharpness 0 to 10 and infinity hits agree with GRID's, and no ray from inside leaks");
  for (float sharpness : {0.0f, 0.3f, 1.0f, 1.7f, 3.0f, 5.5f, 10.0f, infinity}) {
    SCOPED_TRACE(testing::Message() << "sharpness " << sharpness);
    Cage cage = cubeCage();
    cage.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}, {4, 5}};
    cage.creaseWeights = {sharpness, 1.5f, 0.5f, sharpness, sharpness};
    expectAgreementAndNoLeaks(cage);
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, Corners) {
  property("at corners of sharpness 0.7, 2.5 and infinity hits agree with GRID's, and no ray from inside leaks");
  Cage cage = cubeCage();
  cage.corners = {0, 5, 6};
  cage.cornerWeights = {infinity, 2.5f, 0.7f};
  expectAgreementAndNoLeaks(cage);
}

TEST_P(HardCages, Holes) {
  property("faces that are holes are not there, and hits on all others agree with GRID's");
  Cage cage = sheetCage(4);
  cage.holes = {5, 6, 11};
  expectAgreement(cage);
}

TEST_P(HardCages, Boundaries) {
  property("at boundaries of every subdivision mode hits agree with GRID's");
  for (RTCSubdivisionMode mode :
       {RTC_SUBDIVISION_MODE_NO_BOUNDARY, RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY, RTC_SUBDIVISION_MODE_PIN_CORNERS,
        RTC_SUBDIVISION_MODE_PIN_BOUNDARY, RTC_SUBDIVISION_MODE_PIN_ALL}) {
    SCOPED_TRACE(testing::Message() << "mode " << mode);
    Cage cage = sheetCage(3);
    cage.mode = mode;
    expectAgreement(cage);
    if (HasFatalFailure()) return;
  }
}

TEST_P(HardCages, NonManifoldEdges) {
  property("at an edge of three faces, and at one that two cubes share, hits agree with GRID's");
  Cage fan;
  fan.positions = {{0, 0, -1}, {0, 0, 1}};
  for (unsigned i = 0; i < 3; i++) {
    const float x = float(std::cos(2 * M_PI * i / 3)), y = float(std::sin(2 * M_PI * i / 3));
    fan.positions.push_back({x, y, -1});
    fan.positions.push_back({x, y, 1});
    fan.addFace({0, 2 + 2 * i, 3 + 2 * i, 1});
  }
  fan.mode = RTC_SUBDIVISION_MODE_PIN_CORNERS;
  expectAgreement(fan);
  if (HasFatalFailure()) return;

  Cage cubes; // share the edge x = y = 0.5
  for (float z : {-0.5f, 0.5f})
    for (const auto& p : {Vec{-0.5f, -0.5f, z}, Vec{0.5f, -0.5f, z}, Vec{-0.5f, 0.5f, z}, Vec{0.5f, 0.5f, z},
                          Vec{1.5f, 0.5f, z}, Vec{0.5f, 1.5f, z}, Vec{1.5f, 1.5f, z}})
      cubes.positions.push_back(p);
  for (const auto& c : {std::array<unsigned, 4>{0, 1, 2, 3}, std::array<unsigned, 4>{3, 4, 5, 6}}) {
    const unsigned a = c[0], b = c[1], d = c[2], e = c[3], up = 7;
    cubes.addFace({a, d, e, b});
    cubes.addFace({a + up, b + up, e + up, d + up});
    cubes.addFace({a, b, b + up, a + up});
    cubes.addFace({b, e, e + up, b + up});
    cubes.addFace({e, d, d + up, e + up});
    cubes.addFace({d, a, a + up, d + up});
  }
  // Embree evaluates such faces differently from each of their corners and sides. The gaps between GRID's own
  // vertices are up to 0.004.
  expectAgreement(cubes, {}, 0.01f);
}

}} // namespace programs::test
