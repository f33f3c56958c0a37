// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Where coherent packets could differ from single rays: inactive lanes, rays that start on the surface, filters, and
 * faces that GRID traces. scene_features.cpp tests simple cases. */

#include "support/filtered_geometry.h"
#include "support/random.h"
#include "support/scene.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <tuple>

namespace programs::test { namespace {

constexpr unsigned N = 8;
constexpr unsigned words = sizeof(RTCRayHit8) / 4 / N;

struct Traced {
  RTCRayHit hit;
  bool occluded;
};

// Traces packets of 8. Inactive lanes contain `garbage` in every word and are not part of the result.
std::map<size_t, Traced> inPackets(
    RTCScene scene, const std::vector<RTCRayHit>& rays, RTCIntersectContext& context,
    const std::function<bool(size_t)>& isOn = [](size_t) { return true; }, float garbage = 0) {
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  std::map<size_t, Traced> traced;
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    alignas(64) RTCRayHit8 packet;
    alignas(64) int valid[N];
    float* lanes = (float*)&packet;
    auto pack = [&] {
      for (unsigned k = 0; k < N; k++) {
        valid[k] = isOn(first + k) ? -1 : 0;
        for (unsigned w = 0; w < words; w++)
          std::memcpy(&lanes[w * N + k], valid[k] ? (const float*)&rays[first + k] + w : &garbage, 4);
      }
    };
    pack();
    rtcIntersect8(valid, scene, &context, &packet);
    for (unsigned k = 0; k < N; k++) {
      if (!valid[k]) continue;
      traced[first + k].hit = rays[first + k];
      for (unsigned w = 0; w < words; w++) std::memcpy((float*)&traced[first + k].hit + w, &lanes[w * N + k], 4);
    }
    pack();
    rtcOccluded8(valid, scene, &context, &packet.ray);
    for (unsigned k = 0; k < N; k++)
      if (valid[k]) traced[first + k].occluded = packet.ray.tfar[k] < 0;
  }
  return traced;
}

std::map<size_t, Traced> inPackets(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return inPackets(scene, rays, context);
}

// Rays of a picture, row by row, from a short distance.
std::vector<RTCRayHit> pictureRays(unsigned side) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < side * side; i++) {
    const float x = 0.8f * float(i % side) / float(side) - 0.4f, y = 0.8f * float(i / side) / float(side) - 0.4f;
    rays.push_back(makeRay({0.1f, 0.2f, 4}, {x, y, -4}));
    rays.back().ray.id = i;
  }
  return rays;
}

class CoherentPackets : public testing::TestWithParam<RTCCompression> {
protected:
  Device device;
  Displacement displacement;

  SurfaceSettings settings() {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = GetParam();
    s.frameLevel = 2;
    s.rate = 32;
    return s;
  }

  void TearDown() override { EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message; }
};

INSTANTIATE_TEST_SUITE_P(Compression, CoherentPackets,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         [](const auto& info) { return kindName(info.param); });

void expectHitsOfSingleRays(RTCScene scene, const std::vector<RTCRayHit>& rays, const std::map<size_t, Traced>& found) {
  for (const auto& [i, traced] : found) {
    const RTCRayHit expected = intersect(scene, rays[i]);
    ASSERT_EQ(traced.hit.ray.tfar, expected.ray.tfar) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.primID, expected.hit.primID) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.u, expected.hit.u) << "ray " << i;
    ASSERT_EQ(traced.occluded, occluded(scene, rays[i])) << "ray " << i;
    ASSERT_EQ(traced.occluded, isHit(expected)) << "ray " << i;
  }
}

TEST_P(CoherentPackets, InactiveLanesAreIgnored) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  const std::vector<RTCRayHit> rays = pictureRays(96);
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (float garbage : {nan, inf, -inf, 0.0f}) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    expectHitsOfSingleRays(scene, rays,
                           inPackets(scene, rays, context, [](size_t i) { return i % N != i / N % N; }, garbage));
    ASSERT_FALSE(HasFatalFailure()) << "lanes hold " << garbage;
  }
}

TEST_P(CoherentPackets, RaysThatStartOnTheSurfaceMatchSingleRays) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = pictureRays(96);
  Random random(81);
  for (RTCRayHit& ray : rays) {
    const RTCRayHit hit = intersect(scene, ray);
    if (!isHit(hit)) continue;
    const float nudge = float(random.uniform(-0.002, 0.002));
    if (random.chance(0.8)) ray.ray.tnear = hit.ray.tfar + nudge;
    else ray.ray.tfar = hit.ray.tfar + nudge;
  }
  expectHitsOfSingleRays(scene, rays, inPackets(scene, rays));
}

// Any-hit rays with a negative tfar count as occluded, as in Embree, even if tnear is less.
TEST_P(CoherentPackets, AnyHitRaysThatEndBeforeTheirOriginAreUnchanged) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  const std::vector<RTCRayHit> rays = pictureRays(32);
  unsigned behind = 0;
  for (size_t first = 0; first < rays.size(); first += N) {
    alignas(64) RTCRay8 packet = {};
    alignas(64) int valid[N];
    for (unsigned k = 0; k < N; k++) {
      const RTCRay& ray = rays[first + k].ray; // the surface is between the origin and twice the direction
      packet.org_x[k] = ray.org_x + 2 * ray.dir_x;
      packet.dir_x[k] = ray.dir_x;
      packet.org_y[k] = ray.org_y + 2 * ray.dir_y;
      packet.dir_y[k] = ray.dir_y;
      packet.org_z[k] = ray.org_z + 2 * ray.dir_z;
      packet.dir_z[k] = ray.dir_z;
      packet.tnear[k] = -2;
      packet.tfar[k] = -0.001f;
      packet.mask[k] = ~0u;
      valid[k] = -1;
      behind += isHit(intersect(scene, rays[first + k]));
    }
    rtcOccluded8(valid, scene, &context, &packet);
    for (unsigned k = 0; k < N; k++) ASSERT_EQ(packet.tfar[k], -0.001f) << "ray " << first + k;
  }
  EXPECT_GT(behind, 100u);
}

// --- filters -------------------------------------------------------------------------------------

struct SeenHit {
  float t, u, v;
  unsigned primID;
};

struct PacketFilter {
  RTCIntersectContext context; // must be the first member
  std::function<bool(const SeenHit&)> accepts;
  std::map<unsigned, std::vector<SeenHit>> seen; // by ray

  explicit PacketFilter(const std::function<bool(const SeenHit&)>& accepts) : accepts(accepts) {
    rtcInitIntersectContext(&context);
  }
};

void filter(const RTCFilterFunctionNArguments* args) {
  PacketFilter& self = *(PacketFilter*)args->context;
  for (unsigned k = 0; k < args->N; k++) {
    if (args->valid[k] != -1) continue;
    const SeenHit s = {RTCRayN_tfar(args->ray, args->N, k), RTCHitN_u(args->hit, args->N, k),
                       RTCHitN_v(args->hit, args->N, k), RTCHitN_primID(args->hit, args->N, k)};
    self.seen[RTCRayN_id(args->ray, args->N, k)].push_back(s);
    if (!self.accepts(s)) args->valid[k] = 0;
  }
}

bool isOnDarkSquare(const SeenHit& s) { return (int(s.u * 5.3f + 0.37f) + int(s.v * 5.3f + 0.37f)) % 2 == 0; }

TEST_P(CoherentPackets, NearestAcceptedHitIsReported) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  const std::vector<RTCRayHit> rays = pictureRays(64);
  PacketFilter together(isOnDarkSquare);
  unsigned past = 0;
  for (const auto& [i, traced] : inPackets(scene, rays, together.context)) {
    PacketFilter alone(isOnDarkSquare);
    RTCRayHit expected = rays[i];
    rtcIntersect1(scene, &alone.context, &expected);
    past += isHit(expected) && alone.seen.begin()->second.front().t < expected.ray.tfar;
    RTCRay shadow = rays[i].ray;
    rtcOccluded1(scene, &alone.context, &shadow);
    ASSERT_EQ(traced.hit.ray.tfar, expected.ray.tfar) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.primID, expected.hit.primID) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.u, expected.hit.u) << "ray " << i;
    ASSERT_EQ(traced.occluded, shadow.tfar < 0) << "ray " << i;
  }
  EXPECT_GT(past, 100u) << "the filter rejected no first hit";
}

TEST_P(CoherentPackets, FilterIsNotCalledAfterAcceptedAnyHit) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  const std::vector<RTCRayHit> rays = pictureRays(64);
  PacketFilter all([](const SeenHit&) { return true; });
  all.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    alignas(64) RTCRay8 packet;
    alignas(64) int valid[N];
    std::fill_n(valid, N, -1);
    for (unsigned k = 0; k < N; k++)
      for (unsigned w = 0; w < sizeof(packet) / 4 / N; w++)
        std::memcpy((float*)&packet + w * N + k, (const float*)&rays[first + k] + w, 4);
    rtcOccluded8(valid, scene, &all.context, &packet);
  }
  EXPECT_GT(all.seen.size(), 1000u);
  for (const auto& [id, hits] : all.seen) ASSERT_EQ(hits.size(), 1u) << "ray " << id;
}

TEST_P(CoherentPackets, FilterThatRejectsAllSeesSameHitsAsForSingleRays) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  const std::vector<RTCRayHit> rays = pictureRays(64);
  PacketFilter together([](const SeenHit&) { return false; }), alone(together.accepts);
  inPackets(scene, rays, together.context);
  for (RTCRayHit ray : rays) {
    rtcIntersect1(scene, &alone.context, &ray);
    rtcOccluded1(scene, &alone.context, &ray.ray);
  }
  EXPECT_GT(alone.seen.size(), 1000u);
  ASSERT_EQ(together.seen.size(), alone.seen.size());
  for (auto& [id, hits] : alone.seen) {
    std::vector<SeenHit>& found = together.seen[id];
    ASSERT_EQ(found.size(), hits.size()) << "ray " << id;
    auto key = [](const SeenHit& s) { return std::tie(s.t, s.primID, s.u, s.v); };
    for (auto* seen : {&found, &hits})
      std::sort(seen->begin(), seen->end(), [&](const SeenHit& a, const SeenHit& b) { return key(a) < key(b); });
    for (size_t i = 0; i < hits.size(); i++) ASSERT_EQ(key(found[i]), key(hits[i])) << "ray " << id;
  }
}

// The filter function evicts the thread's cached blocks by tracing other rays.
TEST_P(CoherentPackets, FilterMayTraceRays) {
  Scene scene(device);
  SurfaceSettings of = settings();
  of.rate = 64;
  addFilteredCube(device, scene, of, filter);
  Random random(82);
  std::vector<RTCRayHit> others = raysAt(random, 100);
  std::vector<RTCRayHit> rays = pictureRays(64);
  rays.erase(rays.begin(), rays.begin() + 64 * 20);
  rays.resize(64 * 3);
  PacketFilter plain(isOnDarkSquare);
  PacketFilter busy([&](const SeenHit& s) {
    for (const RTCRayHit& other : others) {
      PacketFilter all([](const SeenHit&) { return true; });
      RTCRayHit ray = other;
      rtcIntersect1(scene, &all.context, &ray);
    }
    return isOnDarkSquare(s);
  });
  const std::map<size_t, Traced> expected = inPackets(scene, rays, plain.context),
                                 found = inPackets(scene, rays, busy.context);
  unsigned seen = 0;
  for (const auto& [i, traced] : found) {
    const Traced& e = expected.at(i);
    ASSERT_EQ(traced.hit.ray.tfar, e.hit.ray.tfar) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.primID, e.hit.hit.primID) << "ray " << i;
    ASSERT_EQ(traced.hit.hit.u, e.hit.hit.u) << "ray " << i;
    ASSERT_EQ(traced.occluded, e.occluded) << "ray " << i;
    const std::vector<SeenHit>&a = plain.seen[rays[i].ray.id], &b = busy.seen[rays[i].ray.id];
    ASSERT_EQ(a.size(), b.size()) << "ray " << i;
    for (size_t k = 0; k < a.size(); k++)
      ASSERT_TRUE(a[k].t == b[k].t && a[k].u == b[k].u && a[k].primID == b[k].primID) << "ray " << i;
    seen += unsigned(a.size());
  }
  EXPECT_GT(seen, 100u);
}

// --- faces that GRID traces ----------------------------------------------------------------------

// Packets test GRID's triangles differently: one ray in 1000 may hit the other side of an edge.
TEST_P(CoherentPackets, GridFacesInSameSceneMatchSingleRays) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  Displacement aside;
  aside.offset = {0.5f, 0.1f, 0.1f};
  SurfaceSettings ofGrid = settings();
  ofGrid.displacement = &aside;
  ofGrid.compression = RTC_COMPRESSION_NONE;
  addSurface(device, scene, cubeCage(), ofGrid);
  rtcCommitScene(scene);
  const std::vector<RTCRayHit> rays = pictureRays(96);
  unsigned hits[2] = {0, 0}, others = 0;
  for (const auto& [i, traced] : inPackets(scene, rays)) {
    const RTCRayHit expected = intersect(scene, rays[i]);
    ASSERT_EQ(traced.occluded, isHit(traced.hit)) << "ray " << i;
    if (isHit(expected)) hits[expected.hit.geomID]++;
    others += traced.hit.hit.geomID != expected.hit.geomID ||
              (isHit(expected) && !(std::fabs(traced.hit.ray.tfar - expected.ray.tfar) <= 1e-4f));
  }
  EXPECT_GT(hits[0], 1000u);
  EXPECT_GT(hits[1], 1000u);
  EXPECT_LE(others, rays.size() / 1000);
}

}} // namespace programs::test
