// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Random cages with any error: indices out of range, unusual faces, positions, rates, creases and holes. They must not
 * crash, and valid faces must be traced.
 *
 *   CBVH_RANDOM_GEOMETRIES=100000 random_cages    for a longer run */

#include "support/message_parts.h"
#include "support/query_forms.h"
#include "support/random_rounds.h"

#include <algorithm>

namespace programs::test { namespace {

float oddNumber(Random& random) {
  const float odd[] = {NAN, INFINITY, -INFINITY, 1e18f, -1e18f, 1e30f, 3e38f, 1e-40f, -0.0f, 1e-30f, -1, 0, 0.3f, 1e9f};
  return odd[random.below(sizeof(odd) / sizeof(*odd))];
}

Cage randomCage(Random& random) {
  switch (random.below(6)) {
  case 0: return cubeCage();
  case 1: return prismCage(3 + random.below(random.chance(0.1) ? 1000 : 20));
  case 2: return trapezohedronCage(3 + random.below(random.chance(0.1) ? 500 : 20));
  case 3: return sheetCage(1 + random.below(5));
  case 4: return quadCage();
  }
  Cage soup; // arbitrary faces that share few vertices
  const unsigned vertices = 3 + random.below(20);
  for (unsigned i = 0; i < vertices; i++)
    soup.positions.push_back({float(random.normal()), float(random.normal()), float(random.normal())});
  for (unsigned i = random.below(20); i-- > 0;) {
    unsigned size = random.chance(0.05) ? random.below(1000) : random.below(7);
    if (size == 1) size = 0; // Embree's assertions, if enabled, fail for faces with one vertex
    soup.faces.push_back(size);
    for (unsigned k = 0; k < size; k++) soup.indices.push_back(random.below(vertices));
  }
  return soup;
}

void spoil(Random& random, Cage& cage) {
  const auto vertex = [&] {
    return random.chance(0.05) ? random.bits() : random.below(unsigned(cage.positions.size()) + 2);
  };
  for (unsigned n = random.below(3); n-- > 0;) switch (random.below(6)) {
    case 0: cage.positions[random.below(unsigned(cage.positions.size()))][random.below(3)] = oddNumber(random); break;
    case 1:
      if (!cage.indices.empty()) cage.indices[random.below(unsigned(cage.indices.size()))] = vertex();
      break;
    case 2:
      cage.creases.push_back({vertex(), vertex()});
      cage.creaseWeights.push_back(oddNumber(random));
      break;
    case 3:
      cage.corners.push_back(vertex());
      cage.cornerWeights.push_back(oddNumber(random));
      break;
    case 4:
      cage.holes.push_back(random.chance(0.1) ? random.bits() : random.below(unsigned(cage.faces.size()) + 2));
      break;
    case 5: cage.mode = RTCSubdivisionMode(random.below(5)); break;
    }
}

TEST(RandomCages, AreTracedWithoutCrash) {
  Random random(108);
  const size_t rounds = randomRounds(300);
  const RTCCompression kinds[] = {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CVERT,  RTC_COMPRESSION_CVERT,
                                  RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CGRID};
  size_t hits = 0, named = 0;
  for (size_t round = 0; round < rounds; round++) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    Device device("threads=2");
    Cage cage = randomCage(random);
    if (cage.faces.empty()) continue;
    spoil(random, cage);
    SurfaceSettings settings;
    settings.compression = kinds[random.below(6)];
    settings.fallbackFaces = random.chance(0.5);
    settings.rate = random.chance(0.05) ? oddNumber(random) : float(random.uniform(0, 9));
    if (settings.rate > 100) settings.rate = 100;
    if (random.chance(0.3))
      for (size_t i = 0; i < cage.indices.size(); i++)
        settings.edgeRates.push_back(random.chance(0.02) ? std::min(oddNumber(random), 300.0f)
                                                         : float(random.uniform(0, 12)));
    Scene scene(device);
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    named += device.takeError() != RTC_ERROR_NONE;
    const std::vector<RTCRayHit> rays = raysAt(random, 30);
    for (QueryForm form : {QueryForm::Single, QueryForm::Packet8}) {
      const std::vector<RTCRayHit> closest = closestHits(scene, rays, form), any = anyHits(scene, rays, form);
      for (size_t i = 0; i < rays.size(); i++) {
        ASSERT_EQ(isHit(closest[i]), any[i].ray.tfar < 0);
        if (!isHit(closest[i])) continue;
        hits++;
        ASSERT_LT(closest[i].hit.primID, cage.faces.size());
      }
    }
  }
  EXPECT_GT(hits, rounds);
  EXPECT_LT(named, rounds);
}

TEST(RandomCages, InvalidIndicesAreReported) {
  Device device;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  Cage cage = cubeCage();
  cage.indices[13] = 8;
  rtcReleaseGeometry(newSurface(device, cage, settings));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"face 3 ", " 4 vertices", "index 1 ", "vertex 8", " 8"}));
  cage = cubeCage();
  cage.faces[5] = 5;
  rtcReleaseGeometry(newSurface(device, cage, settings));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"face 5 ", " 5 vertices", " 24 indices"}));
  cage = cubeCage();
  cage.indices.push_back(1000); // belongs to no face
  rtcReleaseGeometry(newSurface(device, cage, settings));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

}} // namespace programs::test
