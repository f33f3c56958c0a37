// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays have the same hits on the device and on the CPU, in every representation. */

#include "agreement.h"
#include "support/diced_mesh.h"
#include "support/odd_rays.h"

#include <algorithm>

namespace programs::test { namespace {

class VulkanHits : public VulkanAgreement {
protected:
  Displacement displacement;

  SurfaceSettings settings(RTCCompression compression, float rate = 16) {
    return displacedSettings(displacement, compression, rate);
  }
};

struct NamedCage {
  const char* name;
  Cage cage;
};

std::vector<NamedCage> cagesOfEverySort() {
  Cage creased = cubeCage();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  Cage withHole = sheetCage(4);
  withHole.holes = {5};
  return {{"cube", cubeCage()},
          {"creases", creased},
          {"hole and borders", withHole},
          {"triangles", prismCage(3)},
          {"pentagons", prismCage(5)},
          {"heptagons", prismCage(7)},
          {"valence 9", trapezohedronCage(9)}};
}

TEST_F(VulkanHits, CagesMatchCpu) {
  for (RTCCompression kind : allKinds) {
    Agreement sum;
    for (const NamedCage& c : cagesOfEverySort())
      for (float rate : {1.f, 2.f, 5.f, 16.f, 64.f}) {
        SCOPED_TRACE(testing::Message() << kindName(kind) << ", " << c.name << ", rate " << rate);
        const SurfaceScene scene(embree, c.cage, settings(kind, rate));
        compare(scene, raysAt(random, 2000), sum, rate == 5 ? RTC_VULKAN_MEMORY_COPY : RTC_VULKAN_MEMORY_AUTO);
      }
    SCOPED_TRACE(kindName(kind));
    sum.expect();
  }
}

TEST_F(VulkanHits, DifferentEdgeRatesMatchCpu) {
  for (RTCCompression kind : allKinds) {
    Agreement sum;
    for (int i = 0; i < 8; i++) {
      SurfaceSettings s = settings(kind);
      const Cage cage = cubeCage();
      /* symmetric in a and b: the same rate on both sides of an edge */
      for (size_t f = 0, k = 0; f < cage.faces.size(); k += cage.faces[f++])
        for (unsigned e = 0; e < cage.faces[f]; e++) {
          const unsigned a = cage.indices[k + e], b = cage.indices[k + (e + 1) % cage.faces[f]];
          s.edgeRates.push_back(float(1 + (a * 7 + b * 7 + a * b * 3 + unsigned(i) * 5) % 23));
        }
      const SurfaceScene scene(embree, cage, s);
      compare(scene, raysAt(random, 3000), sum);
    }
    SCOPED_TRACE(kindName(kind));
    sum.expect();
  }
}

// Quads around vertices that are not finite are left out. Blocks without a usable frame are left to GRID.
TEST_F(VulkanHits, SurfacesWithNaNHolesMatchCpu) {
  displacement.poison = [](unsigned primID, float u, float v) {
    return primID % 2 == 0 && u > 0.3f && u < 0.45f && v > 0.4f && v < 0.6f;
  };
  for (RTCCompression kind : {RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                              RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
    Agreement sum;
    const SurfaceScene scene(embree, cubeCage(), settings(kind, 32));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT); // reports the vertices
    compare(scene, raysAt(random, 20000), sum);
    SCOPED_TRACE(kindName(kind));
    sum.expect();
  }
}

TEST_F(VulkanHits, DegenerateBlocksLeftToGridMatchCpu) {
  Cage cage = quadCage();
  for (Vec& p : cage.positions) p[1] = p[2] = 0;
  cage.addFace({0, 1, 2, 3});
  cage.positions.insert(cage.positions.end(), {{-1, -1, -1}, {1, -1, -1}, {1, 1, -0.8f}, {-1, 1, -1}});
  cage.addFace({4, 5, 6, 7});
  Agreement sum;
  SurfaceSettings s = settings(RTC_COMPRESSION_CLEAF);
  s.displacement = nullptr;
  const SurfaceScene scene(embree, cage, s);
  compare(scene, raysAt(random, 5000), sum);
  sum.expect();
}

// --- other features of scenes -----------------------------------------------------------------

void addTriangles(RTCDevice device, RTCScene scene, Random& random, unsigned count, unsigned mask = ~0u) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::vector<Vec> vertices;
  std::vector<std::array<unsigned, 3>> triangles;
  for (unsigned i = 0; i < count; i++) {
    Vec center;
    for (float& x : center) x = float(random.uniform(-1.5, 1.5));
    for (unsigned k = 0; k < 3; k++) {
      Vec p = center;
      for (float& x : p) x += float(random.uniform(-0.3, 0.3));
      vertices.push_back(p);
    }
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  vertices.push_back({NAN, 0, 0});
  triangles.push_back({0, 1, unsigned(vertices.size() - 1)}); // is left out
  triangles.push_back({0, 1, 1u << 30});
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices);
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles);
  rtcSetGeometryMask(geometry, mask);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
}

TEST_F(VulkanHits, CompressedGridsMatchCpu) {
  Agreement sum;
  for (const Diced& diced : {dicedSheet(1, 50), dicedSheet(12, 4), dicedSheet(6, 8), dicedSheet(3, 16),
                             dicedSheet(1, 64), dicedSheet(1, 1000), dicedBall(2, 11)}) {
    Scene scene(embree);
    rtcAttachGeometryByID(scene, newGrids(embree, diced, RTC_COMPRESSION_CVERT), 3);
    rtcReleaseGeometry(rtcGetGeometry(scene, 3));
    addSurface(embree, scene, sheetCage(2), settings(RTC_COMPRESSION_CLEAF));
    rtcCommitScene(scene);
    compare(scene, raysAt(random, 4000), sum);
  }
  sum.expect();
}

TEST_F(VulkanHits, CompressedMeshesMatchCpu) {
  Agreement sum;
  for (QuadOrder order : allQuadOrders) {
    const DicedMesh quads = meshOf(dicedSheet(3, 16), order, random), ball = meshOf(dicedBall(2, 8), order, random);
    const DicedMesh triangles = trianglesOf(ball, 0, 1);
    const DicedMesh halves = halvesApart(triangles), turned = withTurnedTriangles(triangles, random);
    for (const DicedMesh& mesh : {quads, trianglesOf(quads, 1, 2), ball, triangles, halves, turned}) {
      Scene scene(embree);
      rtcAttachGeometryByID(scene, newMesh(embree, mesh, RTC_COMPRESSION_CVERT), 3);
      rtcReleaseGeometry(rtcGetGeometry(scene, 3));
      rtcCommitScene(scene);
      ASSERT_GT(statisticsOf(scene).numMeshQuads, 1000u);
      compare(scene, raysAt(random, 2000), sum);
    }
  }
  sum.expect();
}

// Vertices that use all bits of floats: blocks with remainders.
TEST_F(VulkanHits, LosslessGeometryMatchesCpu) {
  const Device exact("cbvh_max_error=0");
  Agreement sum;
  for (const Diced& diced : {dicedSheet(1, 50), dicedSheet(6, 8), dicedBall(2, 16)}) {
    Scene scene(exact);
    attach(scene, newGrids(exact, diced, RTC_COMPRESSION_CVERT));
    rtcCommitScene(scene);
    ASSERT_EQ(statisticsOf(scene).maxVertexSpacing, 0);
    compare(scene, raysAt(random, 3000), sum);
  }
  for (const NamedCage& c : cagesOfEverySort()) {
    SCOPED_TRACE(c.name);
    const SurfaceScene scene(exact, c.cage, settings(RTC_COMPRESSION_CVERT, 16));
    compare(scene, raysAt(random, 2000), sum);
  }
  sum.expect();
}

TEST_F(VulkanHits, TrianglesMatchCpuInRobustAndFastMode) {
  for (RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST}) {
    Agreement sum;
    Scene scene(embree, flags);
    addTriangles(embree, scene, random, 1);
    addTriangles(embree, scene, random, 500);
    rtcCommitScene(scene);
    compare(scene, raysAt(random, 20000), sum);
    sum.expect();
  }
}

TEST_F(VulkanHits, MixedScenesMatchCpu) {
  Scene scene(embree);
  Displacement displacements[6];
  std::vector<RTCGeometry> surfaces;
  addSurfacesOfAllKinds(embree, scene, displacements);
  addTriangles(embree, scene, random, 30, 1u << 5);
  rtcDetachGeometry(scene, 2);
  rtcDisableGeometry(rtcGetGeometry(scene, 1));
  rtcCommitScene(scene);
  Agreement sum;
  std::vector<RTCRayHit> rays = raysAt(random, 30000, 0.9f);
  for (RTCRayHit& ray : rays) ray.ray.mask = unsigned(random.below(64));
  compare(scene, rays, sum);
  sum.expect();
}

void copyTo(float out[12], const double columns[3][3], const Vec& origin) {
  for (int c = 0; c < 3; c++)
    for (int r = 0; r < 3; r++) out[3 * c + r] = float(columns[c][r]);
  for (int r = 0; r < 3; r++) out[9 + r] = origin[r];
}

TEST_F(VulkanHits, InstancesMatchCpu) {
  Scene leaves(embree), triangles(embree), scene(embree);
  SurfaceSettings s = settings(RTC_COMPRESSION_CLEAF);
  s.fallbackFaces = true;
  addSurface(embree, leaves, cubeCage(), s);
  addSurface(embree, leaves, sheetCage(3), settings(RTC_COMPRESSION_CVERT));
  rtcCommitScene(leaves);
  addTriangles(embree, triangles, random, 50);
  rtcCommitScene(triangles);
  addTriangles(embree, scene, random, 5);
  for (unsigned i = 0; i < 60; i++) {
    RTCGeometry instance = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, i % 3 ? leaves : triangles);
    double m[3][3];
    for (auto& column : m)
      for (double& x : column) x = 0.25 * random.normal();
    float transform[12];
    copyTo(transform, m,
           {float(random.uniform(-1.2, 1.2)), float(random.uniform(-1.2, 1.2)), float(random.uniform(-1.2, 1.2))});
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
    rtcSetGeometryMask(instance, 1u << (i % 4));
    rtcCommitGeometry(instance);
    attach(scene, instance);
  }
  rtcCommitScene(scene);
  for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_COPY, RTC_VULKAN_MEMORY_AUTO}) {
    Agreement sum;
    std::vector<RTCRayHit> rays = raysAt(random, 30000, 0.8f);
    for (size_t i = 0; i < rays.size(); i += 2) rays[i].ray.mask = unsigned(random.below(16));
    compare(scene, rays, sum, memory);
    sum.expect();
  }
}

TEST_F(VulkanHits, HitsAreBetweenTnearAndTfar) {
  for (RTCCompression kind : allKinds) {
    const SurfaceScene scene(embree, cubeCage(), settings(kind));
    std::vector<RTCRayHit> rays = raysAt(random, 20000);
    for (RTCRayHit& ray : rays) { // directions have a length of about 4
      ray.ray.tnear = float(random.uniform(0.5, 1.3));
      ray.ray.tfar = ray.ray.tnear + float(random.uniform(0, 0.5));
    }
    Agreement sum;
    compare(scene, rays, sum);
    EXPECT_GT(sum.hits, 2000u);
    EXPECT_LE(sum.otherHit, 1u) << kindName(kind);
    EXPECT_LE(sum.otherPlace, 2u) << kindName(kind);
    EXPECT_EQ(sum.otherAny, 0u) << kindName(kind);
  }
}

TEST_F(VulkanHits, NonFiniteRaysMiss) {
  for (RTCCompression kind : allKinds) {
    const SurfaceScene scene(embree, cubeCage(), settings(kind));
    const VulkanScene onDevice = newVulkanScene(device, scene);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    std::vector<RTCRayHit> rays = raysAt(random, 4096);
    for (size_t i = 0; i < rays.size(); i += 2) spoil(rays[i].ray, random);
    std::vector<RTCRayHit> found = rays;
    std::vector<RTCRay> any;
    for (const RTCRayHit& ray : rays) any.push_back(ray.ray);
    intersectOnDevice(onDevice, found);
    occludedOnDevice(onDevice, any);
    for (size_t i = 0; i < rays.size(); i += 2) {
      ASSERT_EQ(std::memcmp(&found[i], &rays[i], sizeof(RTCRayHit)), 0) << kindName(kind) << ", ray " << i;
      ASSERT_EQ(std::memcmp(&any[i], &rays[i].ray, sizeof(RTCRay)), 0) << kindName(kind) << ", any hit, ray " << i;
    }
    size_t others = 0;
    for (size_t i = 1; i < rays.size(); i += 2)
      others += isHit(found[i]) != isHit(intersect(scene, rays[i])) || (any[i].tfar < 0) != isHit(found[i]);
    EXPECT_LE(others, 1u) << kindName(kind);
  }
}

// Rays from inside a closed surface: all of them hit, except for those that pass through edges of GRID's triangles.
TEST_F(VulkanHits, DirectionLengthDoesNotChangeHits) {
  for (RTCCompression kind : allKinds) {
    AllVertices recorder;
    Scene scene(embree);
    recorder.build(embree, scene, cubeCage(), settings(kind, 32));
    const VulkanScene onDevice = newVulkanScene(device, scene);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    const std::vector<RTCRayHit> rays = raysNextToVertices(random, recorder.taken(), 4096);
    std::vector<RTCRayHit> ofUnitLength = rays;
    intersectOnDevice(onDevice, ofUnitLength);
    for (int exponent : oddExponents) {
      std::vector<RTCRayHit> found = withDirections(rays, std::ldexp(1.0f, exponent));
      std::vector<RTCRay> any;
      for (const RTCRayHit& ray : found) any.push_back(ray.ray);
      intersectOnDevice(onDevice, found);
      occludedOnDevice(onDevice, any);
      size_t leaks = 0, others = 0;
      for (size_t i = 0; i < rays.size(); i++) {
        leaks += !isHit(found[i]) && kind != RTC_COMPRESSION_NONE && kind != RTC_COMPRESSION_CGRID;
        others += isHit(found[i]) != isHit(ofUnitLength[i]) || isHit(found[i]) != (any[i].tfar < 0);
      }
      EXPECT_EQ(leaks, 0u) << kindName(kind) << ", length 2^" << exponent;
      EXPECT_EQ(others, 0u) << kindName(kind) << ", length 2^" << exponent;
    }
  }
}

TEST_F(VulkanHits, SortedRaysHaveTheSameHits) {
  const SurfaceScene scene(embree, cubeCage(), settings(RTC_COMPRESSION_CLEAF));
  const VulkanScene onDevice = newVulkanScene(device, scene);
  ASSERT_NE(onDevice, nullptr) << embree.message;
  for (unsigned count : {1u, 2u, 4097u, 20011u}) {
    const std::vector<RTCRayHit> rays = raysAt(random, count);
    std::vector<RTCRayHit> plain = rays, sorted = rays;
    std::vector<RTCRay> plainAny, sortedAny;
    for (const RTCRayHit& ray : rays) plainAny.push_back(ray.ray);
    sortedAny = plainAny;
    rtcSetVulkanSceneRaySorting(onDevice.get(), false);
    intersectOnDevice(onDevice, plain);
    occludedOnDevice(onDevice, plainAny);
    rtcSetVulkanSceneRaySorting(onDevice.get(), true);
    intersectOnDevice(onDevice, sorted);
    occludedOnDevice(onDevice, sortedAny);
    EXPECT_EQ(std::memcmp(plain.data(), sorted.data(), sizeof(RTCRayHit) * count), 0) << count;
    EXPECT_EQ(std::memcmp(plainAny.data(), sortedAny.data(), sizeof(RTCRay) * count), 0) << count;
  }
}

// Three surfaces at the same position.
TEST_F(VulkanHits, EqualDistancesReportTheSameSurface) {
  Scene scene(embree);
  for (int i = 0; i < 3; i++) addSurface(embree, scene, cubeCage(), settings(RTC_COMPRESSION_CVERT));
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 20000; i++)
    rays.push_back(makeRay({0, 0, 0}, {float(random.normal()), float(random.normal()), float(random.normal())}));
  const VulkanScene onDevice = newVulkanScene(device, scene);
  ASSERT_NE(onDevice, nullptr) << embree.message;
  const std::vector<RTCRayHit> traced = traceAll(onDevice.get(), rays);
  for (size_t i = 0; i < rays.size(); i++) {
    const RTCRayHit expected = intersect(scene, rays[i]);
    ASSERT_EQ(expected.hit.geomID, 0u);
    ASSERT_EQ(traced[i].hit.geomID, 0u) << "ray " << i;
    ASSERT_EQ(traced[i].hit.primID, expected.hit.primID) << "ray " << i;
    ASSERT_EQ(traced[i].ray.tfar, expected.ray.tfar);
  }
}

}} // namespace programs::test
