// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Cages that Embree takes and that are not what one expects: index buffers longer than the faces, holes, faces without
 * edges. Builds that share borders, of cVERT and of cLEAF, make of them what the same cage in plain words gives. */

#include "support/edge_rates.h"

#include <malloc.h>

namespace cbvh::test {
namespace {

class CageTopology : public testing::TestWithParam<RTCCompression> {};
INSTANTIATE_TEST_SUITE_P(Compression, CageTopology, testing::Values(RTC_COMPRESSION_LEAF, RTC_COMPRESSION_VERT), nameOf);

// New memory has this byte in it, as it has any on a heap in use.
class FilledHeap
{
public:
  explicit FilledHeap(int byte) { mallopt(M_PERTURB, ~byte & 0xFF); }
  ~FilledHeap() { mallopt(M_PERTURB, 0); }
};

SurfaceSettings sharing(RTCCompression compression, float rate)
{
  SurfaceSettings settings;
  settings.compression = compression;
  settings.exactFaces = true;
  settings.rate = rate;
  return settings;
}

/* The same hits as in the plain scene. faces: those of the cage, by those of the plain cage. */
void expectSameHits(RTCScene scene, RTCScene plain, const std::vector<unsigned>& faces)
{
  Random random(111);
  size_t hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 300)) {
    const RTCRayHit found = intersect(scene, ray), expected = intersect(plain, ray);
    ASSERT_EQ(isHit(found), isHit(expected));
    if (!isHit(expected)) continue;
    ASSERT_EQ(found.hit.primID, faces[expected.hit.primID]);
    ASSERT_EQ(found.ray.tfar, expected.ray.tfar);
    ASSERT_EQ(found.hit.u, expected.hit.u);
    ASSERT_EQ(found.hit.v, expected.hit.v);
    hits++;
  }
  EXPECT_GT(hits, 50u);
}

TEST_P(CageTopology, IndicesBehindThoseOfFacesDoNotMatter)
{
  Device device;
  const SurfaceSettings settings = sharing(GetParam(), 16);
  const SurfaceScene plain(device, cubeCage(), settings);
  for (size_t spare : {1, 7, 4096})
    for (int byte = 1; byte <= 20; byte++) {
      SCOPED_TRACE(testing::Message() << spare << " more indices, heap of " << 12*byte);
      Cage cage = cubeCage();
      cage.indices.resize(cage.indices.size() + spare, 0);
      const FilledHeap filled(12*byte);
      const SurfaceScene scene(device, cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      ASSERT_EQ(statisticsOf(scene).numQuads, statisticsOf(plain).numQuads);
      expectSameHits(scene, plain, {0, 1, 2, 3, 4, 5});
      if (HasFatalFailure()) return;
    }
}

// Embree has the face behind it in its place, once more.
TEST_P(CageTopology, AFaceWithoutEdgesIsNone)
{
  Device device;
  const SurfaceSettings settings = sharing(GetParam(), 16);
  const SurfaceScene plain(device, cubeCage(), settings);
  Cage cage = cubeCage();
  cage.faces = {0, 4, 4, 0, 0, 4, 4, 4, 0, 4};
  for (int byte = 1; byte <= 5; byte++) {
    const FilledHeap filled(50*byte);
    const SurfaceScene scene(device, cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(scene).numQuads, statisticsOf(plain).numQuads);
    expectSameHits(scene, plain, {1, 2, 5, 6, 7, 9});
    if (HasFatalFailure()) return;
  }
}

// Rays from inside at the middles of faces, as GRID has them.
TEST_P(CageTopology, HolesAreOpenAndNothingElseIs)
{
  Device device;
  for (const std::vector<unsigned>& holes : {std::vector<unsigned>{0}, std::vector<unsigned>{5}, std::vector<unsigned>{1, 2, 3}}) {
    Cage cage = cubeCage();
    cage.holes = holes;
    cage.indices.resize(cage.indices.size() + 5, 0);
    const FilledHeap filled(0xA7);
    const Twins twins(device, cage, sharing(GetParam(), 16));
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    Random random(112);
    size_t hits = 0;
    for (int i = 0; i < 600; i++) {
      Vec d;
      for (float& x : d) x = float(random.uniform(-0.3, 0.3));
      d[i % 3] = i % 2 ? 1.f : -1.f;
      const RTCRayHit ray = makeRay({0, 0, 0}, d), expected = intersect(twins.grid, ray), found = intersect(twins.scene, ray);
      ASSERT_EQ(isHit(found), isHit(expected));
      if (!isHit(expected)) continue;
      EXPECT_EQ(found.hit.primID, expected.hit.primID);
      hits++;
    }
    EXPECT_EQ(hits, 100*(6 - holes.size()));
  }
}

} // namespace
} // namespace cbvh::test
