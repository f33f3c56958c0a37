// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compressed geometries are built and traced without the floating-point exceptions that Embree's device setting
 * float_exceptions=1 traps, as Embree's own geometries are. The setting traps divisions by zero, as programs also do by
 * feenableexcept(FE_DIVBYZERO), and denormal operands. The latter occur in Embree, too, which compares the unused
 * fourth components of vertices, unless denormals are zero, as Embree's manual recommends and these tests do. */

#include "support/edge_rates.h"
#include "support/float_traps.h"
#include "support/moving_surface.h"
#include "support/query_forms.h"
#include "support/same_hits.h"
#include "support/saved.h"
#include "support/surface_access.h"

namespace programs::test { namespace {

#if defined(__clang__)

// Clang computes both sides of a selection, of Embree's own reciprocals, too.
TEST(FloatExceptions, None) { GTEST_SKIP() << "with Clang, Embree's own kernels divide by zero"; }

#elif defined(CBVH_FLOAT_TRAPS)

class FloatExceptions : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, FloatExceptions, testing::Values(TEST_ISAS), nameOfIsa);

// Rays from all sides, along axes, in planes of faces, from the surface, and short ones.
std::vector<RTCRayHit> raysOfAllKinds(Random& random, unsigned count) {
  std::vector<RTCRayHit> rays = raysAt(random, count);
  for (unsigned i = 0; i < count; i++) {
    Vec o, d;
    const unsigned zeros = 1 + random.below(6); // mask of components that are 0
    for (unsigned k = 0; k < 3; k++) {
      o[k] = random.chance(0.3) ? float(random.below(9)) / 4 - 1 : float(random.uniform(-1, 1));
      d[k] = (zeros >> k) & 1 ? (random.chance(0.5) ? 0.0f : -0.0f) : float(random.uniform(-1, 1));
      if (random.chance(0.5)) o[k] -= 3 * d[k];
    }
    rays.push_back(makeRay(o, d, random.chance(0.3) ? 0.5f : 0, random.chance(0.3) ? 2 : INFINITY));
  }
  for (size_t i = 0; i < rays.size(); i += 5) rays[i].ray.time = float(random.uniform());
  for (size_t i = 1; i < rays.size(); i += 5) rays[i].ray.time = float(random.below(3)) / 2;
  return rays;
}

void queryPoints(RTCScene scene, Random& random, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    RTCPointQuery query;
    query.x = float(random.uniform(-1.2, 1.2));
    query.y = random.chance(0.3) ? 0 : float(random.uniform(-1.2, 1.2));
    query.z = random.chance(0.3) ? 1 : float(random.uniform(-1.2, 1.2));
    query.time = float(random.uniform());
    query.radius = random.chance(0.3) ? INFINITY : random.chance(0.1) ? 0 : float(random.uniform(0, 0.6));
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        scene, &query, &context,
        [](RTCPointQueryFunctionArguments* args) {
          args->query->radius *= 0.9f;
          return true;
        },
        nullptr);
  }
}

void findPoints(RTCScene scene, Random& random, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    CbvhPointQuery query = CbvhPointQuery();
    query.x = float(random.uniform(-1.2, 1.2));
    query.y = random.chance(0.3) ? 0 : float(random.uniform(-1.2, 1.2));
    query.z = random.chance(0.3) ? 1 : float(random.uniform(-1.2, 1.2));
    query.time = float(random.uniform());
    query.radius = random.chance(0.3) ? INFINITY : random.chance(0.1) ? 0 : float(random.uniform(0, 0.6));
    rtcFindClosestPoint(scene, &query, nullptr);
  }
}

void addInstances(RTCDevice device, RTCScene top, RTCScene scene) {
  const float transforms[2][12] = {{0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0.0625f},
                                   {0, 1, 0, -1, 0, 0, 0, 0, 1, 0.5f, 0, 0.0625f}};
  for (unsigned timeSteps : {1u, 2u}) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, scene);
    rtcSetGeometryTimeStepCount(instance, timeSteps);
    for (unsigned t = 0; t < timeSteps; t++)
      rtcSetGeometryTransform(instance, t, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transforms[t]);
    rtcCommitGeometry(instance);
    attach(top, instance);
  }
  rtcCommitScene(top);
}

// Builds and traces a geometry, alone and in instances, with traps, and expects none.
template<typename Make>
void expectNoTraps(const std::string& config, const Make& make) {
  FloatTraps traps;
  Device device(config + ",float_exceptions=1"); // traps in this thread
  ASSERT_TRUE(device);
  ASSERT_EQ(_mm_getcsr() & _MM_MASK_MASK, _MM_MASK_MASK & ~(_MM_MASK_DIV_ZERO | _MM_MASK_DENORM));
  const unsigned flushToZero = 1 << 15, denormalsAreZero = 1 << 6;
  _mm_setcsr(_mm_getcsr() | flushToZero | denormalsAreZero);
  RTCGeometry geometry = make(device);
  EXPECT_EQ(traps.takeReport(), "") << "commit of the geometry";
  Scene scene(device), top(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(traps.takeReport(), "") << "commit of the scene";
  addInstances(device, top, scene);
  EXPECT_EQ(traps.takeReport(), "") << "commit of instances";
  Random random(77);
  const std::vector<RTCRayHit> rays = raysOfAllKinds(random, 501);
  EXPECT_EQ(traps.takeReport(), "") << "the test's own rays";
  size_t hits = 0;
  for (RTCScene of : {RTCScene(scene), RTCScene(top)})
    for (QueryForm form : allQueryForms) {
      for (const RTCRayHit& r : closestHits(of, rays, form)) hits += isHit(r);
      EXPECT_EQ(traps.takeReport(), "") << "closest hits of " << nameOf(form) << (of == top ? " of instances" : "");
      for (const RTCRayHit& r : anyHits(of, rays, form)) hits += r.ray.tfar < 0;
      EXPECT_EQ(traps.takeReport(), "") << "any hits of " << nameOf(form) << (of == top ? " of instances" : "");
    }
  EXPECT_GT(hits, rays.size());
  queryPoints(scene, random, 100);
  queryPoints(top, random, 100);
  EXPECT_EQ(traps.takeReport(), "") << "point queries";
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  findPoints(scene, random, 100); // an error if the representation has no triangles
  EXPECT_EQ(traps.takeReport(), "") << "closest points";
}

TEST_P(FloatExceptions, NoneInAnyFormOfGeometry) {
  if (!Device(GetParam())) GTEST_SKIP() << "this machine does not support " << GetParam();
  for (const Saveable& form : allSaveable()) {
    SCOPED_TRACE(form.name);
    expectNoTraps(GetParam(), form.make);
  }
}

// Cages of all kinds and representations, with and without motion, flat or displaced.
TEST_P(FloatExceptions, NoneInAnyCage) {
  if (!Device(GetParam())) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(78);
  Cage squashed = cubeCage();
  for (Vec& p : squashed.positions) p[2] = 0;
  std::vector<std::pair<std::string, Cage>> cages = {
      {"quad", quadCage()}, {"sheet", sheetCage(3)}, {"squashed cube", squashed}};
  for (const auto& closed : closedCages) cages.push_back({closed.name, closed.cage});
  for (const auto& cage : cages)
    for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL,
                                       RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE})
      for (bool isDisplaced : {false, true})
        for (unsigned timeSteps : {1u, 3u}) {
          SCOPED_TRACE(cage.first + " as " + kindName(compression) + (isDisplaced ? ", displaced, " : ", ") +
                       std::to_string(timeSteps) + " steps");
          Displacement displacement;
          SurfaceSettings settings;
          settings.compression = compression;
          settings.timeSteps = timeSteps;
          settings.rate = 9;
          if (isDisplaced) settings.displacement = &displacement;
          expectNoTraps(GetParam(), [&](RTCDevice device) { return newSurface(device, cage.second, settings); });
          settings.edgeRates = drawRates(cage.second, random, rateSets[0].draw);
          expectNoTraps(GetParam(), [&](RTCDevice device) { return newSurface(device, cage.second, settings); });
        }
}

// Grids and meshes in a plane of two axes, through the origin or not.
TEST_P(FloatExceptions, NoneInFlatMeshes) {
  if (!Device(GetParam())) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(79);
  for (float height : {0.0f, 1.0f})
    for (unsigned timeSteps : {1u, 2u})
      for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
        Diced sheet = dicedSheet(2, 24);
        for (Vec& p : sheet.vertices) p[2] = height;
        sheet.motion = [](const Vec& p, unsigned step) { return Vec{p[0] + 0.25f * float(step), p[1], p[2]}; };
        DicedMesh quads = meshOf(sheet, QuadOrder::Rows, random), triangles = irregularTriangles(quads, random);
        quads.motion = triangles.motion = sheet.motion;
        const bool isCompressed = compression != RTC_COMPRESSION_NONE;
        const unsigned flags = isCompressed ? RTC_COMPRESSION_FLAG_RELEASE_INPUT : RTC_COMPRESSION_FLAG_NONE;
        const std::string suffix = std::string(isCompressed ? ", compressed, at " : ", at ") + std::to_string(height) +
                                   ", " + std::to_string(timeSteps) + " steps";
        SCOPED_TRACE(suffix);
        if (isCompressed || timeSteps == 1) { // Embree has no point queries of moving grids
          SCOPED_TRACE("grids");
          expectNoTraps(GetParam(),
                        [&](RTCDevice device) { return newGrids(device, sheet, compression, flags, timeSteps); });
        }
        for (const DicedMesh* mesh : {&quads, &triangles}) {
          SCOPED_TRACE(mesh == &quads ? "quads" : "triangles");
          expectNoTraps(GetParam(),
                        [&](RTCDevice device) { return newMesh(device, *mesh, compression, flags, timeSteps); });
        }
      }
}

#else

TEST(FloatExceptions, None) { GTEST_SKIP() << "requires x86-64 and Linux"; }

#endif

}} // namespace programs::test
