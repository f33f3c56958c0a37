// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Scenes of compressed surfaces: settings per geometry, enabling and attaching, instances, masks, filters, packets and
 * streams. */

#include "support/filtered_geometry.h"
#include "support/query_forms.h"
#include "support/random.h"
#include "support/scene.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace programs::test { namespace {

const RTCCompression allKinds[] = {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                   RTC_COMPRESSION_CVERT};

class SceneFeatures : public testing::TestWithParam<RTCCompression> {
protected:
  Device device;
  Displacement displacement;

  SurfaceSettings settings(RTCCompression compression = RTC_COMPRESSION_INHERIT) {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = compression == RTC_COMPRESSION_INHERIT ? GetParam() : compression;
    s.frameLevel = 2;
    return s;
  }

  void TearDown() override { EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message; }
};

std::string nameOf(const testing::TestParamInfo<RTCCompression>& info) { return kindName(info.param); }
INSTANTIATE_TEST_SUITE_P(Compression, SceneFeatures, testing::ValuesIn(allKinds), nameOf);

// --- geometries ----------------------------------------------------------------------------

TEST(MixedScene, EveryGeometryUsesItsOwnSettings) {
  Device device;
  Scene scene(device);
  const struct {
    RTCCompression compression;
    int frameLevel;
    float rate;
  } kinds[] = {{RTC_COMPRESSION_NONE, 0, 8},  {RTC_COMPRESSION_CGRID, 1, 16}, {RTC_COMPRESSION_CVOXEL, 2, 32},
               {RTC_COMPRESSION_CLEAF, 0, 8}, {RTC_COMPRESSION_CLEAF, 3, 8},  {RTC_COMPRESSION_CLEAF, 1, 8},
               {RTC_COMPRESSION_CVOXEL, 1, 8}};
  constexpr unsigned numKinds = 7, disabled = 5, detached = 6;
  Displacement displacement[numKinds];
  size_t blocks = 0, quads = 0;
  for (unsigned i = 0; i < numKinds; i++) {
    displacement[i].offset = {4.0f * i, 0, 0};
    SurfaceSettings settings;
    settings.displacement = &displacement[i];
    settings.compression = kinds[i].compression;
    settings.frameLevel = kinds[i].frameLevel;
    settings.rate = kinds[i].rate;
    ASSERT_EQ(addSurface(device, scene, cubeCage(), settings), i);
    if (kinds[i].compression == RTC_COMPRESSION_NONE || i >= disabled) continue;
    blocks += 6 * (size_t(1) << 2 * kinds[i].frameLevel);
    quads += 6 * size_t(kinds[i].rate * kinds[i].rate);
  }
  rtcDisableGeometry(rtcGetGeometry(scene, disabled));
  rtcDetachGeometry(scene, detached);
  rtcCommitScene(scene);
  EXPECT_EQ(statisticsOf(scene).numBlocks, blocks);
  EXPECT_EQ(statisticsOf(scene).numQuads, quads);
  EXPECT_EQ(statisticsOf(scene).numUncompressedQuads, 6u * 8 * 8);

  Random random(61);
  auto probe = [&](unsigned i) {
    Vec o, d;
    for (int k = 0; k < 3; k++) {
      o[k] = displacement[i].offset[k] + (k == 0 ? 0 : float(random.uniform(-0.2, 0.2)));
      d[k] = k == 0 ? 0 : float(random.uniform(-1, 1)); // stays next to its neighbors
    }
    return intersect(scene, makeRay(o, d));
  };
  for (unsigned i = 0; i < numKinds; i++)
    for (int repeat = 0; repeat < 200; repeat++) {
      const RTCRayHit hit = probe(i);
      ASSERT_EQ(hit.hit.geomID, i < disabled ? i : RTC_INVALID_GEOMETRY_ID);
      if (isHit(hit)) { ASSERT_LT(hit.hit.primID, 6u); }
    }

  rtcEnableGeometry(rtcGetGeometry(scene, disabled));
  rtcDisableGeometry(rtcGetGeometry(scene, 2));
  rtcCommitScene(scene);
  for (int repeat = 0; repeat < 200; repeat++) {
    ASSERT_EQ(probe(disabled).hit.geomID, disabled);
    ASSERT_FALSE(isHit(probe(2)));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(MixedScene, TrianglesNextToCompressedSurfacesAreHit) {
  Device device;
  Scene scene(device);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CLEAF;
  addSurface(device, scene, cubeCage(), settings);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
            std::vector<Vec>{{-5, -5, 2}, {5, -5, 2}, {0, 5, 2}});
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, std::vector<std::array<unsigned, 3>>{{0, 1, 2}});
  rtcCommitGeometry(geometry);
  ASSERT_EQ(rtcAttachGeometry(scene, geometry), 1u);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(intersect(scene, makeRay({0, 0, 3}, {0, 0, -1})).hit.geomID, 1u);
  EXPECT_EQ(intersect(scene, makeRay({0, 0, 1.9f}, {0, 0, -1})).hit.geomID, 0u);
  EXPECT_EQ(intersect(scene, makeRay({0, 0, 0}, {0, 0, 1})).hit.geomID, 0u);
}

// --- instances -------------------------------------------------------------------------------

// Translations by powers of two are exact, so hits are the same floats.
TEST_P(SceneFeatures, InstancesReportHitsOfTheirScene) {
  Scene inner(device), outer(device);
  addSurface(device, inner, cubeCage(), settings());
  rtcCommitScene(inner);
  for (unsigned i = 0; i < 3; i++) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, inner);
    const float xfm[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 16.0f * i, 0, 0};
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, xfm);
    rtcCommitGeometry(instance);
    ASSERT_EQ(rtcAttachGeometry(outer, instance), i);
    rtcReleaseGeometry(instance);
  }
  rtcCommitScene(outer);
  Random random(62);
  unsigned hits = 0;
  for (RTCRayHit ray : raysAt(random, 2000)) {
    // origins are on a lattice of 2^-10, so that moving them by 16 and back is exact
    for (float* o : {&ray.ray.org_x, &ray.ray.org_y, &ray.ray.org_z}) *o = std::round(*o * 1024) / 1024;
    const unsigned i = random.below(3);
    RTCRayHit moved = ray;
    moved.ray.org_x += 16.0f * i;
    moved.ray.tfar = ray.ray.tfar = 1.5f; // ends before the next instance
    const RTCRayHit a = intersect(inner, ray), b = intersect(outer, moved);
    ASSERT_EQ(isHit(a), isHit(b));
    ASSERT_EQ(occluded(outer, moved), isHit(b));
    if (!isHit(a)) continue;
    hits++;
    ASSERT_EQ(b.hit.instID[0], i);
    ASSERT_EQ(b.hit.geomID, a.hit.geomID);
    ASSERT_EQ(b.hit.primID, a.hit.primID);
    ASSERT_EQ(b.ray.tfar, a.ray.tfar);
    ASSERT_EQ(b.hit.u, a.hit.u);
    ASSERT_EQ(b.hit.v, a.hit.v);
    ASSERT_EQ(a.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  }
  EXPECT_GT(hits, 500u);
}

// --- masks -------------------------------------------------------------------------------------

TEST_P(SceneFeatures, MasksHideGeometry) {
  Scene scene(device);
  SurfaceSettings masked = settings();
  masked.mask = 2;
  addSurface(device, scene, cubeCage(), masked);
  rtcCommitScene(scene);
  Random random(63);
  unsigned seen = 0;
  for (RTCRayHit ray : raysAt(random, 500)) {
    ray.ray.mask = 5;
    ASSERT_FALSE(isHit(intersect(scene, ray)));
    ASSERT_FALSE(occluded(scene, ray));
    ray.ray.mask = 6;
    seen += isHit(intersect(scene, ray));
    ASSERT_EQ(occluded(scene, ray), isHit(intersect(scene, ray)));
  }
  EXPECT_GT(seen, 100u);
}

// --- filters -----------------------------------------------------------------------------------

struct SeenHit {
  unsigned geomID, primID, instID;
  float t, u, v, Ng[3];
};

// Records all hits that a filter sees; passed through the ray query context.
struct FilterContext {
  RTCIntersectContext context; // must be the first member
  std::function<bool(const SeenHit&)> accepts;
  std::vector<SeenHit> seen;
};

void filter(const RTCFilterFunctionNArguments* args) {
  FilterContext& self = *(FilterContext*)args->context;
  ASSERT_EQ(args->N, 1u);
  if (args->valid[0] != -1) return;
  const RTCRay& ray = *(const RTCRay*)args->ray;
  const RTCHit& hit = *(const RTCHit*)args->hit;
  const SeenHit s = {hit.geomID, hit.primID, hit.instID[0], ray.tfar, hit.u, hit.v, {hit.Ng_x, hit.Ng_y, hit.Ng_z}};
  self.seen.push_back(s);
  if (!self.accepts(s)) args->valid[0] = 0;
}

struct Filtered {
  RTCRayHit hit;
  bool occluded;
  std::vector<SeenHit> seen, seenByAnyHit;
};

Filtered traceFiltered(RTCScene scene, const RTCRayHit& ray, const std::function<bool(const SeenHit&)>& accepts) {
  Filtered result;
  FilterContext context;
  context.accepts = accepts;
  rtcInitIntersectContext(&context.context);
  result.hit = ray;
  rtcIntersect1(scene, &context.context, &result.hit);
  result.seen.swap(context.seen);
  RTCRay shadow = ray.ray;
  rtcOccluded1(scene, &context.context, &shadow);
  result.occluded = shadow.tfar < 0;
  result.seenByAnyHit.swap(context.seen);
  return result;
}

bool isSame(const SeenHit& a, const SeenHit& b) {
  return a.geomID == b.geomID && a.primID == b.primID && a.t == b.t && a.u == b.u && a.v == b.v &&
         std::equal(a.Ng, a.Ng + 3, b.Ng);
}

bool isSame(const SeenHit& a, const RTCRayHit& b) {
  return a.geomID == b.hit.geomID && a.primID == b.hit.primID && a.t == b.ray.tfar && a.u == b.hit.u &&
         a.v == b.hit.v && a.Ng[0] == b.hit.Ng_x && a.Ng[1] == b.hit.Ng_y && a.Ng[2] == b.hit.Ng_z;
}

TEST_P(SceneFeatures, FiltersSeeReportedHit) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  Random random(64);
  unsigned hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 1000)) {
    const Filtered r = traceFiltered(scene, ray, [](const SeenHit&) { return true; });
    ASSERT_EQ(isHit(r.hit), !r.seen.empty());
    ASSERT_EQ(r.occluded, isHit(r.hit));
    ASSERT_EQ(r.seenByAnyHit.size(), r.occluded ? 1u : 0u) << "any hit must end with the first accepted hit";
    if (!isHit(r.hit)) continue;
    hits++;
    ASSERT_TRUE(isSame(r.seen.back(), r.hit));
    for (const SeenHit& s : r.seen) {
      ASSERT_GE(s.t, r.hit.ray.tfar) << "accepted hits must get closer";
      ASSERT_LT(s.primID, 6u);
      ASSERT_TRUE(s.u >= 0 && s.u <= 1 && s.v >= 0 && s.v <= 1);
      ASSERT_GT(std::fabs(s.Ng[0]) + std::fabs(s.Ng[1]) + std::fabs(s.Ng[2]), 0);
    }
  }
  EXPECT_GT(hits, 300u);
}

TEST_P(SceneFeatures, FilterThatRejectsAllLeavesRayUnchanged) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  Random random(65);
  unsigned seen = 0;
  for (const RTCRayHit& ray : raysAt(random, 1000)) {
    Filtered r = traceFiltered(scene, ray, [](const SeenHit&) { return false; });
    ASSERT_FALSE(isHit(r.hit));
    ASSERT_FALSE(r.occluded);
    ASSERT_EQ(std::memcmp(&r.hit.ray, &ray.ray, sizeof(RTCRay)), 0);
    seen += !r.seen.empty();
    ASSERT_EQ(r.seen.size(), r.seenByAnyHit.size());
    for (auto* seen : {&r.seen, &r.seenByAnyHit})
      std::sort(seen->begin(), seen->end(), [](const SeenHit& a, const SeenHit& b) {
        return std::tie(a.t, a.primID, a.u, a.v) < std::tie(b.t, b.primID, b.u, b.v);
      });
    for (size_t i = 0; i < r.seen.size(); i++) ASSERT_TRUE(isSame(r.seen[i], r.seenByAnyHit[i])) << "hit " << i;
  }
  EXPECT_GT(seen, 300u);
}

void changeHit(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    if (args->valid[i] != -1) continue;
    RTCRayN_tfar(args->ray, args->N, i) *= 0.5f;
    RTCHitN_Ng_x(args->hit, args->N, i) = 1;
    RTCHitN_u(args->hit, args->N, i) = 0.125f;
    RTCHitN_primID(args->hit, args->N, i) += 100;
    RTCHitN_geomID(args->hit, args->N, i) = 7;
  }
}

// Rays from inside of a closed convex surface have one hit.
TEST_P(SceneFeatures, FilterMayChangeHitAndDecreaseTfar) {
  SurfaceSettings plain = settings();
  plain.displacement = nullptr;
  Scene scene(device), changed(device);
  addSurface(device, scene, cubeCage(), plain);
  rtcCommitScene(scene);
  addFilteredCube(device, changed, plain, changeHit);
  Random random(67);
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 480; i++)
    rays.push_back(makeRay({0, 0, 0}, {float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), 0.7f}));
  const bool hasThickLeaves = GetParam() == RTC_COMPRESSION_CVOXEL || GetParam() == RTC_COMPRESSION_CLEAF;
  for (QueryForm form : allQueryForms) {
    SCOPED_TRACE(nameOf(form));
    const std::vector<RTCRayHit> expected = closestHits(scene, rays, form), found = closestHits(changed, rays, form);
    for (size_t i = 0; i < rays.size(); i++) {
      ASSERT_TRUE(isHit(expected[i]));
      ASSERT_NEAR(found[i].ray.tfar, 0.5f * expected[i].ray.tfar,
                  (hasThickLeaves ? 2e-2f : 1e-6f) * expected[i].ray.tfar);
      ASSERT_EQ(found[i].hit.geomID, 7u);
      ASSERT_TRUE(found[i].hit.primID >= 100 && found[i].hit.primID < 106);
      ASSERT_EQ(found[i].hit.Ng_x, 1);
      ASSERT_EQ(found[i].hit.u, 0.125f);
      if (hasThickLeaves) continue; // overlapping boxes: another one may be found first
      ASSERT_EQ(found[i].hit.primID, expected[i].hit.primID + 100);
      ASSERT_EQ(found[i].hit.v, expected[i].hit.v);
    }
  }
}

// The filter decides by the position of the hit. Any hit finds an accepted one if there is one.
TEST_P(SceneFeatures, NearestAcceptedHitIsFound) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  Random random(66);
  unsigned past = 0;
  // Earlier hits affect leaves at the same position: cLEAF considers heights up to the end of the ray, and boxes, as
  // large as a quad and as thick as a leaf, extend beyond the bounds by which the top level culls.
  const float tolerance =
      GetParam() == RTC_COMPRESSION_CGRID ? 1e-5f : 2 / 16.0f + statisticsOf(scene).maxLeafThickness;
  for (const RTCRayHit& ray : raysAt(random, 2000)) {
    // not along borders of quads
    auto accepts = [](const SeenHit& s) { return (int(s.u * 5.3f + 0.37f) + int(s.v * 5.3f + 0.37f)) % 2 == 0; };
    std::vector<SeenHit> all = traceFiltered(scene, ray, [](const SeenHit&) { return false; }).seen;
    const Filtered r = traceFiltered(scene, ray, accepts);
    auto nearer = [](const SeenHit& a, const SeenHit& b) { return a.t < b.t; };
    std::stable_sort(all.begin(), all.end(), nearer);
    const auto nearest = std::find_if(all.begin(), all.end(), accepts);
    ASSERT_EQ(isHit(r.hit), nearest != all.end());
    ASSERT_EQ(r.occluded, isHit(r.hit));
    if (!isHit(r.hit)) continue;
    const Vec d = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
    ASSERT_LE(std::fabs(r.hit.ray.tfar - nearest->t) * std::hypot(d[0], d[1], d[2]), tolerance);
    past += nearest != all.begin();
  }
  EXPECT_GT(past, 100u) << "the filter rejected too few first hits";
}

// The filter rejects its first, third and further odd calls, whose order is any.
TEST_P(SceneFeatures, FilterMayRejectEveryOtherHit) {
  Scene scene(device);
  addFilteredCube(device, scene, settings(), filter);
  Random random(67);
  unsigned hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 1000)) {
    unsigned count = 0;
    const Filtered r = traceFiltered(scene, ray, [&](const SeenHit&) { return count++ % 2 == 1; });
    ASSERT_EQ(isHit(r.hit), r.seen.size() >= 2);
    if (!isHit(r.hit)) continue;
    hits++;
    bool known = false;
    for (size_t i = 1; i < r.seen.size(); i += 2) known |= isSame(r.seen[i], r.hit);
    ASSERT_TRUE(known);
  }
  EXPECT_GT(hits, 300u);
}

TEST_P(SceneFeatures, ContextFilterIsCalled) {
  Scene scene(device, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  FilterContext context;
  context.accepts = [](const SeenHit&) { return false; };
  rtcInitIntersectContext(&context.context);
  context.context.filter = filter;
  RTCRayHit ray = makeRay({0, 0, 0}, {0.1f, 0.2f, 1});
  rtcIntersect1(scene, &context.context, &ray);
  EXPECT_FALSE(isHit(ray));
  EXPECT_FALSE(context.seen.empty());
}

// The filter function evicts the thread's cached blocks by tracing other rays.
TEST_P(SceneFeatures, FilterMayTraceRays) {
  Scene scene(device);
  SurfaceSettings of = settings();
  of.rate = 64;
  addFilteredCube(device, scene, of, filter);
  Random random(73);
  const std::vector<RTCRayHit> others = raysAt(random, 600);
  unsigned seen = 0;
  for (const RTCRayHit& ray : raysAt(random, 60)) {
    for (bool accepts : {false, true}) {
      auto answer = [&](const SeenHit& s) { return accepts && s.primID % 2 == 0; };
      const Filtered expected = traceFiltered(scene, ray, answer);
      const Filtered found = traceFiltered(scene, ray, [&](const SeenHit& s) {
        for (const RTCRayHit& other : others) traceFiltered(scene, other, [](const SeenHit&) { return true; });
        return answer(s);
      });
      ASSERT_EQ(found.seen.size(), expected.seen.size());
      ASSERT_EQ(found.seenByAnyHit.size(), expected.seenByAnyHit.size());
      for (size_t i = 0; i < found.seen.size(); i++) {
        ASSERT_EQ(found.seen[i].t, expected.seen[i].t);
        ASSERT_EQ(found.seen[i].primID, expected.seen[i].primID);
        ASSERT_EQ(found.seen[i].u, expected.seen[i].u);
      }
      ASSERT_EQ(found.hit.ray.tfar, expected.hit.ray.tfar);
      ASSERT_EQ(found.occluded, expected.occluded);
      seen += unsigned(found.seen.size());
    }
  }
  EXPECT_GT(seen, 100u);
}

TEST(Filters, FilteredHitsOfCGridMatchGrid) {
  Device device;
  Displacement displacement;
  Scene scenes[2] = {Scene(device), Scene(device)};
  for (int i = 0; i < 2; i++) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = i ? RTC_COMPRESSION_CGRID : RTC_COMPRESSION_NONE;
    settings.frameLevel = 2;
    addFilteredCube(device, scenes[i], settings, filter);
  }
  Random random(68);
  unsigned hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 1000)) {
    auto accepts = [](const SeenHit& s) { return s.primID % 2 == 0; };
    const Filtered a = traceFiltered(scenes[0], ray, accepts), b = traceFiltered(scenes[1], ray, accepts);
    ASSERT_EQ(isHit(a.hit), isHit(b.hit));
    ASSERT_EQ(a.occluded, b.occluded);
    if (!isHit(a.hit)) continue;
    hits++;
    ASSERT_EQ(a.hit.hit.primID, b.hit.hit.primID);
    ASSERT_LE(std::fabs(a.hit.ray.tfar - b.hit.ray.tfar), 4 * std::numeric_limits<float>::epsilon() * a.hit.ray.tfar);
  }
  EXPECT_GT(hits, 200u);
}

// --- packets and streams -------------------------------------------------------------------------

void expectSame(const RTCRayHit& expected, const RTCRayHit& found) {
  ASSERT_EQ(found.hit.geomID, expected.hit.geomID);
  ASSERT_EQ(found.ray.tfar, expected.ray.tfar);
  if (!isHit(expected)) return;
  ASSERT_EQ(found.hit.primID, expected.hit.primID);
  ASSERT_EQ(found.hit.instID[0], expected.hit.instID[0]);
  ASSERT_EQ(found.hit.u, expected.hit.u);
  ASSERT_EQ(found.hit.v, expected.hit.v);
  ASSERT_EQ(found.hit.Ng_x, expected.hit.Ng_x);
  ASSERT_EQ(found.hit.Ng_y, expected.hit.Ng_y);
  ASSERT_EQ(found.hit.Ng_z, expected.hit.Ng_z);
}

// Members of packets are arrays of N; every fifth lane is inactive.
template<unsigned N, typename Packet>
void comparePackets(RTCScene scene, const std::vector<RTCRayHit>& rays,
                    void (*closest)(const int*, RTCScene, RTCIntersectContext*, Packet*),
                    const std::function<void(const int*, RTCIntersectContext*, Packet*)>& any,
                    RTCIntersectContextFlags flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  constexpr unsigned words = sizeof(RTCRayHit) / 4;
  for (size_t first = 0; first + N <= rays.size(); first += N) {
    alignas(64) Packet packet;
    alignas(64) int valid[N];
    float* lanes = (float*)&packet;
    auto pack = [&] {
      for (unsigned k = 0; k < N; k++) {
        valid[k] = (first + k) % 5 ? -1 : 0;
        for (unsigned w = 0; w < sizeof(Packet) / 4 / N; w++)
          std::memcpy(&lanes[w * N + k], (const float*)&rays[first + k] + w, 4);
      }
    };
    auto unpack = [&](unsigned k) {
      RTCRayHit r = rays[first + k];
      for (unsigned w = 0; w < words && w < sizeof(Packet) / 4 / N; w++)
        std::memcpy((float*)&r + w, &lanes[w * N + k], 4);
      return r;
    };
    pack();
    closest(valid, scene, &context, &packet);
    for (unsigned k = 0; k < N; k++)
      expectSame(valid[k] ? intersect(scene, rays[first + k]) : rays[first + k], unpack(k));
    pack();
    any(valid, &context, &packet);
    for (unsigned k = 0; k < N; k++) ASSERT_EQ(unpack(k).ray.tfar < 0, valid[k] && occluded(scene, rays[first + k]));
    if (testing::Test::HasFatalFailure()) return;
  }
}

void compareAllPackets(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  for (RTCIntersectContextFlags flags : {RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}) {
    comparePackets<4, RTCRayHit4>(
        scene, rays, rtcIntersect4,
        [&](const int* v, RTCIntersectContext* c, RTCRayHit4* p) { rtcOccluded4(v, scene, c, &p->ray); }, flags);
    comparePackets<8, RTCRayHit8>(
        scene, rays, rtcIntersect8,
        [&](const int* v, RTCIntersectContext* c, RTCRayHit8* p) { rtcOccluded8(v, scene, c, &p->ray); }, flags);
    comparePackets<16, RTCRayHit16>(
        scene, rays, rtcIntersect16,
        [&](const int* v, RTCIntersectContext* c, RTCRayHit16* p) { rtcOccluded16(v, scene, c, &p->ray); }, flags);
  }
}

// Rays of a picture, many per block. Some look back from the other side; some begin after the surface, end before it,
// have an empty range or mask 4.
std::vector<RTCRayHit> pictureRays(Random& random, unsigned side) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < side * side; i++) {
    const float x = 0.8f * float(i % side) / float(side) - 0.4f, y = 0.8f * float(i / side) / float(side) - 0.4f;
    const bool looksBack = random.chance(0.1);
    RTCRayHit ray = looksBack ? makeRay({x, y, -4}, {0.1f * x, 0.1f * y, 1}) : makeRay({0.1f, 0.2f, 4}, {x, y, -4});
    if (random.chance(0.05)) ray.ray.tnear = 1;
    if (random.chance(0.05)) ray.ray.tfar = 0.5f;
    if (random.chance(0.05)) std::swap(ray.ray.tnear, ray.ray.tfar);
    if (random.chance(0.05)) ray.ray.mask = 4;
    rays.push_back(ray);
  }
  return rays;
}

TEST_P(SceneFeatures, PacketsMatchSingleRays) {
  for (float rate : {3.0f, 16.0f, 40.0f}) {
    Scene scene(device);
    SurfaceSettings of = settings();
    of.rate = rate;
    const unsigned id = addSurface(device, scene, cubeCage(), of);
    rtcSetGeometryMask(rtcGetGeometry(scene, id), 3);
    rtcCommitGeometry(rtcGetGeometry(scene, id));
    rtcCommitScene(scene);
    Random random(69);
    compareAllPackets(scene, raysAt(random, 1600));
    if (HasFatalFailure()) return;
    compareAllPackets(scene, pictureRays(random, 64));
    if (HasFatalFailure()) return;
  }
}

// State from earlier packets must not survive a change of kind.
TEST(Packets, FollowChangesOfKind) {
  Device device;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  addSurface(device, scene, cubeCage(), settings);
  RTCGeometry geometry = rtcGetGeometry(scene, 0);
  Random random(72);
  const std::vector<RTCRayHit> rays = pictureRays(random, 32);
  for (RTCCompression kind : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_NONE,
                              RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CVERT}) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = kind;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    if (kind != RTC_COMPRESSION_NONE)
      compareAllPackets(scene, rays); // packets of GRID are not bit-identical to single rays
    ASSERT_FALSE(HasFatalFailure()) << kindName(kind);
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// All quads are left out, and there is no tree.
TEST(Packets, ScenesWithoutBlocksAreEmpty) {
  Device device;
  Scene scene(device);
  Displacement displacement;
  displacement.poison = [](unsigned, float, float) { return true; };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CLEAF;
  addSurface(device, scene, cubeCage(), settings);
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << "left out quads must be reported";
  Random random(74);
  const std::vector<RTCRayHit> rays = pictureRays(random, 16);
  for (const RTCRayHit& ray : rays) ASSERT_FALSE(isHit(intersect(scene, ray)));
  compareAllPackets(scene, rays);
}

// Rays through vertices and edges of quads, at the same distance on both sides, and in the plane of the surface.
TEST(Packets, RaysOnEdgesAndInPlanesMatchSingleRays) {
  Device device;
  for (float bend : {0.0f, 0.125f}) {
    Scene scene(device);
    Cage cage = sheetCage(2);
    cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
    for (Vec& p : cage.positions) p[2] = bend * p[0];
    SurfaceSettings of;
    of.compression = RTC_COMPRESSION_CVERT;
    of.rate = 16;
    addSurface(device, scene, cage, of);
    rtcCommitScene(scene);
    std::vector<RTCRayHit> rays;
    for (int y = -4; y <= 68; y++)
      for (int x = -4; x <= 68; x++) {
        const float px = x / 32.0f - 1, py = y / 32.0f - 1;
        rays.push_back(makeRay({px, py, -4}, {0, 0, 1}));
        rays.push_back(makeRay({px, py, 4}, {0, 0, -1}));
      }
    for (int y = -4; y <= 68; y++)
      for (int x = 0; x < 64; x++) {
        const float dy = x / 64.0f;
        rays.push_back(makeRay({-2, y / 32.0f - 1, -2 * bend}, {1, dy, bend}));
      }
    // nearly parallel to the surface
    for (int y = 1; y < 64; y++)
      for (int x = 1; x < 64; x++)
        rays.push_back(
            makeRay({-2, y / 32.0f - 1, -2 * bend - 1e-7f * (x / 32.0f + 1)}, {1, x / 640.0f, bend + 1e-7f}));
    // at edges between groups of 4 x 4 quads, as close as floats allow
    Random random(98);
    for (int i = 0; i < 2000; i++) {
      const Vec from = {float(random.uniform(-3, 3)), float(random.uniform(-3, 3)), -4};
      for (int k = 0; k < 8; k++) {
        const float px = random.below(9) / 4.0f - 1, py = float(random.uniform(-1, 1));
        rays.push_back(makeRay(from, {px - from[0], py - from[1], bend * px - from[2]}));
      }
    }
    size_t hits = 0;
    for (const RTCRayHit& ray : rays) hits += isHit(intersect(scene, ray));
    EXPECT_GT(hits, 20000u);
    compareAllPackets(scene, rays);
    if (HasFatalFailure()) return;
  }
}

// Active lanes with an empty range, also NaN, as in the last packet of a stream, are not changed.
template<unsigned N, typename Packet>
void expectLeftAlone(RTCScene scene, const RTCRayHit& active,
                     void (*closest)(const int*, RTCScene, RTCIntersectContext*, Packet*),
                     const std::function<void(const int*, RTCIntersectContext*, Packet*)>& any) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN(),
              t = intersect(scene, active).ray.tfar;
  const float ranges[4][2] = {{std::nextafter(t, inf), t}, {inf, -inf}, {nan, inf}, {0, nan}}; // tnear, tfar
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  alignas(64) int valid[N];
  alignas(64) Packet packet;
  for (bool isAny : {false, true}) {
    float* lanes = (float*)&packet;
    std::fill_n(valid, N, -1);
    for (unsigned k = 0; k < N; k++) {
      RTCRayHit ray = active;
      ray.ray.tnear = ranges[k % 4][0];
      ray.ray.tfar = ranges[k % 4][1];
      for (unsigned w = 0; w < sizeof(Packet) / 4 / N; w++) std::memcpy(&lanes[w * N + k], (const float*)&ray + w, 4);
    }
    const Packet before = packet;
    if (isAny) any(valid, &context, &packet);
    else closest(valid, scene, &context, &packet);
    ASSERT_EQ(std::memcmp(&before, &packet, sizeof(packet)), 0)
        << (isAny ? "any" : "closest") << " hit, packets of " << N;
  }
}

TEST_P(SceneFeatures, PacketsIgnoreRaysWithEmptyRange) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  Random random(71);
  unsigned rays = 0;
  for (const RTCRayHit& ray : raysAt(random, 300)) {
    if (!isHit(intersect(scene, ray))) continue;
    rays++;
    expectLeftAlone<4, RTCRayHit4>(scene, ray, rtcIntersect4, [&](const int* v, RTCIntersectContext* c, RTCRayHit4* p) {
      rtcOccluded4(v, scene, c, &p->ray);
    });
    expectLeftAlone<8, RTCRayHit8>(scene, ray, rtcIntersect8, [&](const int* v, RTCIntersectContext* c, RTCRayHit8* p) {
      rtcOccluded8(v, scene, c, &p->ray);
    });
    expectLeftAlone<16, RTCRayHit16>(
        scene, ray, rtcIntersect16,
        [&](const int* v, RTCIntersectContext* c, RTCRayHit16* p) { rtcOccluded16(v, scene, c, &p->ray); });
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(rays, 100u);
}

TEST_P(SceneFeatures, StreamsMatchSingleRays) {
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings());
  rtcCommitScene(scene);
  Random random(70);
  const std::vector<RTCRayHit> rays = raysAt(random, 1003);
  const unsigned n = unsigned(rays.size());
  std::vector<RTCRayHit> expected;
  for (const RTCRayHit& ray : rays) expected.push_back(intersect(scene, ray));

  for (RTCIntersectContextFlags flags : {RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    std::vector<RTCRayHit> stream = rays, shadows = rays;
    rtcIntersect1M(scene, &context, stream.data(), n, sizeof(RTCRayHit));
    rtcOccluded1M(scene, &context, &shadows[0].ray, n, sizeof(RTCRayHit));
    for (unsigned i = 0; i < n; i++) {
      expectSame(expected[i], stream[i]);
      ASSERT_EQ(shadows[i].ray.tfar < 0, isHit(expected[i]));
    }

    // pointers to arrays, one per component
    constexpr unsigned words = sizeof(RTCRayHit) / 4;
    for (bool any : {false, true}) {
      std::vector<std::vector<uint32_t>> soa(words, std::vector<uint32_t>(n));
      for (unsigned i = 0; i < n; i++)
        for (unsigned w = 0; w < words; w++) std::memcpy(&soa[w][i], (const float*)&rays[i] + w, 4);
      RTCRayHitNp p;
      auto f = [&](size_t offset) { return (float*)soa[offset / 4].data(); };
      auto u = [&](size_t offset) { return (unsigned*)soa[offset / 4].data(); };
      p.ray.org_x = f(offsetof(RTCRay, org_x));
      p.ray.org_y = f(offsetof(RTCRay, org_y));
      p.ray.org_z = f(offsetof(RTCRay, org_z));
      p.ray.dir_x = f(offsetof(RTCRay, dir_x));
      p.ray.dir_y = f(offsetof(RTCRay, dir_y));
      p.ray.dir_z = f(offsetof(RTCRay, dir_z));
      p.ray.tnear = f(offsetof(RTCRay, tnear));
      p.ray.tfar = f(offsetof(RTCRay, tfar));
      p.ray.time = f(offsetof(RTCRay, time));
      p.ray.mask = u(offsetof(RTCRay, mask));
      p.ray.id = u(offsetof(RTCRay, id));
      p.ray.flags = u(offsetof(RTCRay, flags));
      const size_t hit = offsetof(RTCRayHit, hit);
      p.hit.Ng_x = f(hit + offsetof(RTCHit, Ng_x));
      p.hit.Ng_y = f(hit + offsetof(RTCHit, Ng_y));
      p.hit.Ng_z = f(hit + offsetof(RTCHit, Ng_z));
      p.hit.u = f(hit + offsetof(RTCHit, u));
      p.hit.v = f(hit + offsetof(RTCHit, v));
      p.hit.primID = u(hit + offsetof(RTCHit, primID));
      p.hit.geomID = u(hit + offsetof(RTCHit, geomID));
      p.hit.instID[0] = u(hit + offsetof(RTCHit, instID));
      if (any) rtcOccludedNp(scene, &context, &p.ray, n);
      else rtcIntersectNp(scene, &context, &p, n);
      for (unsigned i = 0; i < n; i++) {
        RTCRayHit r = rays[i];
        for (unsigned w = 0; w < words; w++) std::memcpy((float*)&r + w, &soa[w][i], 4);
        if (any) {
          ASSERT_EQ(r.ray.tfar < 0, isHit(expected[i]));
        } else expectSame(expected[i], r);
      }
    }
  }
}

}} // namespace programs::test
