// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files of compressed geometry: loaded geometry equals saved geometry. */

#include "support/message_parts.h"
#include "support/query_forms.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <set>
#include <thread>

namespace programs::test { namespace {

std::vector<RTCRayHit> timedRays(Random& random, unsigned count, bool moves) {
  std::vector<RTCRayHit> rays = raysAt(random, count);
  for (RTCRayHit& ray : rays) ray.ray.time = moves ? float(random.uniform(0, 1)) : 0;
  return rays;
}

// Compares all members of rays and hits that the library writes.
void expectSameToTheBit(const std::vector<RTCRayHit>& expected, const std::vector<RTCRayHit>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (size_t i = 0; i < expected.size(); i++) {
    SCOPED_TRACE(testing::Message() << "ray " << i);
    const RTCRayHit &e = expected[i], &f = found[i];
    ASSERT_EQ(std::memcmp(&e.ray.tfar, &f.ray.tfar, sizeof(float)), 0);
    ASSERT_EQ(e.hit.geomID, f.hit.geomID);
    if (isHit(e)) { ASSERT_EQ(std::memcmp(&e.hit, &f.hit, offsetof(RTCHit, instID) + sizeof(e.hit.instID)), 0); }
  }
}

size_t hitsOf(const std::vector<RTCRayHit>& rays) { return size_t(std::count_if(rays.begin(), rays.end(), isHit)); }

void expectSameStatistics(const RTCCompressionStatistics& a, const RTCCompressionStatistics& b, bool withTopLevel) {
  RTCCompressionStatistics c = a, d = b;
  if (!withTopLevel) c.topLevelBytes = d.topLevelBytes = 0;
  EXPECT_EQ(std::memcmp(&c, &d, sizeof(c)), 0);
}

// Vertices of all parts, sorted.
std::vector<std::array<float, 3>> verticesOf(RTCGeometry geometry, float time) {
  std::vector<std::array<float, 3>> all;
  forEachStoredPart(
      geometry, time,
      [](void* self, const CbvhPart* part) {
        for (unsigned i = 0; i < part->width * part->height; i++)
          ((std::vector<std::array<float, 3>>*)self)
              ->push_back({part->vertices[3 * i], part->vertices[3 * i + 1], part->vertices[3 * i + 2]});
        return true;
      },
      &all);
  std::sort(all.begin(), all.end());
  return all;
}

class OneGeometry : public Scene {
public:
  OneGeometry(RTCDevice device, RTCGeometry geometry) : Scene(device), geometry(geometry) {
    if (!geometry) return;
    attach(*this, geometry);
    rtcCommitScene(*this);
  }
  RTCGeometry geometry;
};

TEST(CompressedFiles, LoadedSurfacesMatchSavedOnes) {
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    Random random(33);
    Folder folder;
    Device device;
    const std::vector<RTCRayHit> rays = timedRays(random, 500, saveable.moves);
    std::vector<std::vector<RTCRayHit>> expected, occluded;
    RTCCompressionStatistics statistics;
    RTCBounds bounds;
    std::vector<std::array<float, 3>> vertices;
    {
      OneGeometry scene(device, saveable.make(device));
      ASSERT_TRUE(saveGeometryFile(scene.geometry, (folder / "surface.cbvh").c_str())) << device.message;
      for (QueryForm form : allQueryForms) {
        expected.push_back(closestHits(scene, rays, form));
        occluded.push_back(QueryRun(scene, form, true)(rays));
      }
      statistics = statisticsOf(scene);
      rtcGetSceneBounds(scene, &bounds);
      if (saveable.hasTriangles) vertices = verticesOf(scene.geometry, 0.5f);
      EXPECT_GT(hitsOf(expected[0]), rays.size() / 8);
    }
    OneGeometry scene(device, loadGeometryFile(device, (folder / "surface.cbvh").c_str()));
    ASSERT_NE(scene.geometry, nullptr) << device.message;
    for (size_t i = 0; i < expected.size(); i++) {
      SCOPED_TRACE(nameOf(allQueryForms[i]));
      expectSameToTheBit(expected[i], closestHits(scene, rays, allQueryForms[i]));
      expectSameToTheBit(occluded[i], QueryRun(scene, allQueryForms[i], true)(rays));
    }
    expectSameStatistics(statistics, statisticsOf(scene), true);
    RTCBounds loaded;
    rtcGetSceneBounds(scene, &loaded);
    EXPECT_EQ(std::memcmp(&bounds.lower_x, &loaded.lower_x, 3 * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(&bounds.upper_x, &loaded.upper_x, 3 * sizeof(float)), 0);
    if (saveable.hasTriangles) {
      EXPECT_EQ(vertices, verticesOf(scene.geometry, 0.5f));
      size_t found = 0;
      const auto hits = closestHits(scene, rays, QueryForm::Single);
      for (const RTCRayHit& r : hits) {
        CbvhTriangle triangle;
        if (isHit(r))
          found +=
              findStoredTriangle(scene.geometry, r.ray.time, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &triangle);
      }
      EXPECT_EQ(found, hitsOf(hits));
    }
    CbvhFile file = openFile(device, (folder / "surface.cbvh").c_str());
    EXPECT_TRUE(verifyFile(file)) << device.message;
    releaseFile(file);
    EXPECT_EQ(device.errors, 0u) << device.message;
  }
}

TEST(CompressedFiles, LoadedSurfaceIsSavedAsTheSameBytes) {
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    Folder folder;
    Device device;
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str())) << device.message;
    rtcReleaseGeometry(geometry);
    geometry = loadGeometryFile(device, (folder / "a").c_str());
    ASSERT_NE(geometry, nullptr) << device.message;
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "b").c_str())) << device.message;
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str()))
        << "saving to the file that it was loaded from: " << device.message;
    rtcReleaseGeometry(geometry);
    EXPECT_EQ(bytesOf(folder / "a"), bytesOf(folder / "b"));
    EXPECT_EQ(folder.names().size(), 2u);
  }
}

TEST(CompressedFiles, OneFileHoldsManyGeometriesWithReleasedInput) {
  Folder folder;
  Device device;
  Random random(7);
  const std::vector<Saveable> all = allSaveable();
  const std::vector<RTCRayHit> rays = timedRays(random, 2000, true);
  std::vector<RTCRayHit> expected;
  {
    Scene scene(device);
    for (const Saveable& saveable : all) attach(scene, saveable.make(device));
    rtcCommitScene(scene);
    expected = closestHits(scene, rays, QueryForm::Single);
  }
  CbvhFileWriter writer = newFileWriter(device, (folder / "all").c_str());
  ASSERT_NE(writer, nullptr) << device.message;
  EXPECT_FALSE(commitWriter(writer)) << "a file without geometries";
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  for (const Saveable& saveable : all) {
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(appendGeometry(writer, geometry)) << saveable.name << ": " << device.message;
    rtcReleaseGeometry(geometry);
  }
  EXPECT_EQ(access((folder / "all").c_str(), F_OK), -1) << "the file exists before it is complete";
  ASSERT_TRUE(commitWriter(writer)) << device.message;
  EXPECT_FALSE(commitWriter(writer));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  releaseWriter(writer);
  device.errors = 0;

  CbvhFile file = openFile(device, (folder / "all").c_str());
  ASSERT_NE(file, nullptr) << device.message;
  ASSERT_EQ(countOf(file), all.size());
  Scene scene(device);
  size_t quads = 0;
  for (unsigned i = 0; i < all.size(); i++) {
    CbvhFileSurfaceInfo description;
    ASSERT_TRUE(infoOf(file, i, &description));
    EXPECT_EQ(description.numTimeSteps > 1, all[i].moves);
    EXPECT_GT(description.numPrimitives, 0u);
    CbvhSurfaceStatistics statistics;
    ASSERT_TRUE(statisticsOf(file, i, &statistics));
    quads += statistics.numQuads;
    attach(scene, loadFromFile(device, file, i));
  }
  releaseFile(file);
  rtcCommitScene(scene);
  expectSameToTheBit(expected, closestHits(scene, rays, QueryForm::Single));
  std::set<unsigned> geomIDs;
  for (const RTCRayHit& r : expected) geomIDs.insert(r.hit.geomID);
  EXPECT_GT(geomIDs.size(), 4u);
  EXPECT_EQ(statisticsOf(scene).numQuads, quads);
  EXPECT_EQ(device.errors, 0u) << device.message;
  EXPECT_EQ(loadGeometryFile(device, (folder / "all").c_str()), nullptr) << "the file has several geometries";
}

TEST(CompressedFiles, StatisticsRequireAnOpenFileAStructAndAValidIndex) {
  Folder folder;
  Device device;
  RTCGeometry geometry = allSaveable().front().make(device);
  ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str())) << device.message;
  rtcReleaseGeometry(geometry);
  CbvhFile file = openFile(device, (folder / "a").c_str());
  ASSERT_NE(file, nullptr) << device.message;
  CbvhSurfaceStatistics statistics;
  statistics.numQuads = 12345;
  for (unsigned index : {1u, 7u, ~0u}) {
    EXPECT_FALSE(statisticsOf(file, index, &statistics)) << index;
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << index;
    EXPECT_TRUE(containsInOrder(device.message, {"index " + std::to_string(index) + ":", " 1 "}));
  }
  EXPECT_FALSE(statisticsOf(file, 0, nullptr));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"statistics", "NULL"}));
  EXPECT_FALSE(statisticsOf(CbvhFile(nullptr), 0, &statistics));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << "without a file there is no device";
  EXPECT_EQ(statistics.numQuads, 12345u) << "an error must not write";
  EXPECT_TRUE(statisticsOf(file, 0, &statistics));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE);
  EXPECT_NE(statistics.numQuads, 12345u);
  releaseFile(file);
}

TEST(CompressedFiles, GeometryCanBeLoadedSeveralTimesInOneScene) {
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    Folder folder;
    Device device;
    Random random(8);
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str()));
    const std::string before = bytesOf(folder / "a");
    // the mask of the first excludes half of the rays, the mask of the second the others
    Scene scene(device);
    for (unsigned mask : {1u, 2u, 4u}) {
      RTCGeometry loaded = mask == 4 ? geometry : loadGeometryFile(device, (folder / "a").c_str());
      ASSERT_NE(loaded, nullptr) << device.message;
      rtcSetGeometryMask(loaded, mask);
      rtcSetGeometryUserData(loaded, (void*)size_t(mask));
      if (mask != 4) rtcCommitGeometry(loaded);
      attach(scene, loaded);
    }
    rtcDisableGeometry(rtcGetGeometry(scene, 2)); // its input was released, so a mask cannot be committed
    rtcCommitScene(scene);
    std::vector<RTCRayHit> rays = timedRays(random, 300, saveable.moves), single;
    for (size_t i = 0; i < rays.size(); i++) rays[i].ray.mask = 1 + i % 2;
    OneGeometry alone(device, loadGeometryFile(device, (folder / "a").c_str()));
    single = closestHits(alone, rays, QueryForm::Single);
    size_t hits = 0;
    for (QueryForm form : {QueryForm::Single, QueryForm::Packet8}) {
      const std::vector<RTCRayHit> found = closestHits(scene, rays, form);
      for (size_t i = 0; i < rays.size(); i++) {
        ASSERT_EQ(isHit(single[i]), isHit(found[i]));
        if (!isHit(found[i])) continue;
        hits++;
#if defined(EMBREE_RAY_MASK)
        ASSERT_EQ(found[i].hit.geomID, unsigned(i % 2));
#endif
        ASSERT_LT(found[i].hit.geomID, 2u);
        ASSERT_EQ(rtcGetGeometryUserData(rtcGetGeometry(scene, found[i].hit.geomID)),
                  (void*)size_t(1 + found[i].hit.geomID));
      }
    }
    EXPECT_GT(hits, 50u);
    EXPECT_EQ(before, bytesOf(folder / "a")) << "the file was modified";
    EXPECT_EQ(device.errors, 0u) << device.message;
  }
}

TEST(CompressedFiles, FiltersInstancesAndOtherDevicesWork) {
  Folder folder;
  {
    Device device;
    RTCGeometry geometry = allSaveable()[0].make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str()));
    rtcReleaseGeometry(geometry);
  }
  Device device("subdiv_accel=cbvh.leaf,cbvh_frame_level=1");
  RTCGeometry geometry = loadGeometryFile(device, (folder / "a").c_str());
  ASSERT_NE(geometry, nullptr) << device.message;
  struct Seen {
    size_t calls = 0;
  } seen;
  rtcSetGeometryUserData(geometry, &seen);
  rtcSetGeometryIntersectFilterFunction(geometry, [](const RTCFilterFunctionNArguments* args) {
    ((Seen*)args->geometryUserPtr)->calls++;
    args->valid[0] = 0;
  });
  rtcCommitGeometry(geometry);
  OneGeometry inner(device, geometry);
  Scene outer(device);
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, inner);
  const float transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(instance);
  attach(outer, instance);
  rtcCommitScene(outer);
  Random random(4);
  const std::vector<RTCRayHit> rays = raysAt(random, 200);
  EXPECT_EQ(hitsOf(closestHits(outer, rays, QueryForm::Single)), 0u);
  EXPECT_GT(seen.calls, 200u);
  rtcSetGeometryIntersectFilterFunction(geometry, nullptr);
  rtcCommitGeometry(geometry);
  rtcCommitScene(inner);
  rtcCommitScene(outer);
  const auto found = closestHits(outer, rays, QueryForm::Single);
  EXPECT_GT(hitsOf(found), 150u);
  for (const RTCRayHit& r : found)
    if (isHit(r)) { ASSERT_EQ(r.hit.instID[0], 0u); }
  rtcDisableGeometry(geometry);
  rtcCommitScene(inner);
  EXPECT_EQ(hitsOf(closestHits(inner, rays, QueryForm::Single)), 0u);
  EXPECT_EQ(device.errors, 0u) << device.message;
}

TEST(CompressedFiles, FunctionsThatNeedACageAreRejectedWithTheReason) {
  Folder folder;
  Device device;
  for (const Saveable& saveable : allSaveable()) {
    SCOPED_TRACE(saveable.name);
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str()));
    rtcReleaseGeometry(geometry);
    geometry = loadGeometryFile(device, (folder / "a").c_str());
    ASSERT_NE(geometry, nullptr);
    float P[3];
    const std::function<void()> edits[] = {
        [&] { rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, P, 3); },
        [&] { rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, P, 3); },
        [&] { rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4); },
        [&] { rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0); },
        [&] { rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0); },
        [&] { rtcSetGeometryTessellationRate(geometry, 4); },
        [&] { rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_PIN_ALL); },
        [&] { rtcSetGeometryDisplacementFunction(geometry, Displacement::apply); },
        [&] { rtcSetGeometryVertexAttributeCount(geometry, 1); },
        [&] { rtcSetGeometryTopologyCount(geometry, 2); },
        [&] { rtcSetGeometryTimeStepCount(geometry, 7); },
        [&] { rtcGetGeometryFirstHalfEdge(geometry, 0); },
        [&] {
          RTCCompressionArguments args;
          rtcInitCompressionArguments(&args);
          args.compression = RTC_COMPRESSION_NONE;
          rtcSetGeometryCompression(geometry, &args);
        }};
    for (const auto& edit : edits) {
      SCOPED_TRACE(&edit - edits);
      edit();
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
      EXPECT_NE(device.message.find("loaded"), std::string::npos) << device.message;
    }
    rtcCommitGeometry(geometry);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    if (saveable.moves) {
      rtcSetGeometryTimeRange(geometry, 0, 2);
      rtcCommitGeometry(geometry);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    }
    rtcReleaseGeometry(geometry);
  }
}

TEST(CompressedFiles, TheTimeRangeOfTheMessageIsAccepted) {
  Folder folder;
  Device device;
  SurfaceSettings settings;
  settings.timeSteps = 2;
  settings.begin = 1e-7f;
  settings.end = 1.0f / 3;
  RTCGeometry geometry = releasing(newSurface(device, quadCage(), settings), RTC_COMPRESSION_CVERT);
  ASSERT_TRUE(saveGeometryFile(geometry, (folder / "a").c_str())) << device.message;
  rtcReleaseGeometry(geometry);
  geometry = loadGeometryFile(device, (folder / "a").c_str());
  ASSERT_NE(geometry, nullptr) << device.message;
  rtcSetGeometryTimeRange(geometry, 0, 2);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  float begin = -1, end = -1;
  const size_t at = std::min(device.message.find("expected"), device.message.size());
  EXPECT_EQ(std::sscanf(device.message.c_str() + at, "expected %f to %f", &begin, &end), 2) << device.message;
  rtcSetGeometryTimeRange(geometry, begin, end);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  rtcReleaseGeometry(geometry);
}

TEST(CompressedFiles, UncompressedGeometryIsNotSaved) {
  Folder folder;
  Device device;
  const auto refused = [&](RTCGeometry geometry, const std::string& cause) {
    EXPECT_FALSE(saveGeometryFile(geometry, (folder / "a").c_str()));
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_NE(device.message.find(cause), std::string::npos) << device.message;
    EXPECT_TRUE(folder.names().empty());
  };
  EXPECT_FALSE(saveGeometryFile(nullptr, (folder / "a").c_str()));
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  refused(geometry, "scene");
  Scene scene(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  rtcSetGeometryMask(geometry, 3);
  refused(geometry, "changed");
  const std::vector<std::function<void()>> changes = {
      [&] { rtcSetGeometryTessellationRate(geometry, 3); },
      [&] {
        const float* const old = (const float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
        const std::vector<float> copy(old, old + 24);
        void* const vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 8);
        std::memcpy(vertices, copy.data(), 24 * sizeof(float));
      }};
  for (const auto& change : changes) {
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    change();
    refused(geometry, "changed");
  }
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  rtcSetGeometryUserData(geometry, &device);
  EXPECT_TRUE(saveGeometryFile(geometry, (folder / "b").c_str())) << "files do not contain user data";
  std::remove((folder / "b").c_str());
  settings.compression = RTC_COMPRESSION_CLEAF;
  settings.rate = 300;
  OneGeometry high(device, newSurface(device, quadCage(), settings));
  refused(high.geometry, "GRID");
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  refused(instance, "compressed");
  rtcReleaseGeometry(instance);
  DicedMesh quad;
  quad.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  quad.quads = {{0, 1, 2, 3}};
  RTCGeometry rejected = newMesh(device, quad, RTC_COMPRESSION_CVERT);
  refused(rejected, "few");
  rtcReleaseGeometry(rejected);
}

// Cages in which all faces are holes, or all are at a border that is not subdivided.
TEST(CompressedFiles, SurfacesWithoutFacesAreSavedAndLoaded) {
  Folder folder;
  Device device;
  Cage holes = cubeCage(), border = quadCage();
  for (unsigned face = 0; face < holes.faces.size(); face++) holes.holes.push_back(face);
  border.mode = RTC_SUBDIVISION_MODE_NO_BOUNDARY;
  std::vector<RTCGeometry> geometries = {allSaveable()[0].make(device)};
  for (const Cage& cage : {holes, border})
    for (unsigned timeSteps : {1u, 2u, 5u})
      for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF}) {
        SurfaceSettings settings;
        settings.timeSteps = timeSteps;
        if (timeSteps > 1) {
          settings.begin = 0.25f;
          settings.end = 1.5f;
        }
        geometries.push_back(releasing(newSurface(device, cage, settings), compression));
      }
  CbvhFileWriter writer = newFileWriter(device, (folder / "all").c_str());
  for (RTCGeometry geometry : geometries) ASSERT_TRUE(appendGeometry(writer, geometry)) << device.message;
  ASSERT_TRUE(commitWriter(writer)) << device.message;
  releaseWriter(writer);
  CbvhFile file = openFile(device, (folder / "all").c_str());
  ASSERT_NE(file, nullptr) << "one geometry prevents opening the others: " << device.message;
  EXPECT_TRUE(verifyFile(file)) << device.message;
  Scene scene(device);
  for (unsigned i = 0; i < geometries.size(); i++) {
    SCOPED_TRACE(i);
    RTCGeometry loaded = loadFromFile(device, file, i);
    ASSERT_NE(loaded, nullptr) << device.message;
    ASSERT_TRUE(saveGeometryFile(geometries[i], (folder / "one").c_str())) << device.message;
    ASSERT_TRUE(saveGeometryFile(loaded, (folder / "again").c_str())) << device.message;
    EXPECT_EQ(bytesOf(folder / "one"), bytesOf(folder / "again"));
    RTCGeometry alone = loadGeometryFile(device, (folder / "one").c_str());
    EXPECT_NE(alone, nullptr) << device.message;
    if (alone) rtcReleaseGeometry(alone);
    attach(scene, loaded);
    rtcReleaseGeometry(geometries[i]);
  }
  releaseFile(file);
  rtcCommitScene(scene);
  Random random(3);
  EXPECT_GT(hitsOf(closestHits(scene, timedRays(random, 200, true), QueryForm::Single)), 50u);
  EXPECT_EQ(device.errors, 0u) << device.message;
}

TEST(CompressedFiles, GeometryThatCannotBeLoadedIsNotSaved) {
  const float infinity = std::numeric_limits<float>::infinity(), largest = std::numeric_limits<float>::max();
  Device device;
  size_t refused = 0;
  for (float begin : {-infinity, -largest, 0.0f})
    for (float end : {1.0f, largest, infinity})
      for (float size : {1.0f, 1e-38f, 0.4f * largest, largest})
        for (unsigned timeSteps : {1u, 3u}) {
          SCOPED_TRACE(testing::Message() << timeSteps << " steps, " << begin << " to " << end << ", size " << size);
          Folder folder;
          Cage cage = cubeCage();
          for (Vec& p : cage.positions)
            for (float& x : p) x *= size;
          SurfaceSettings settings;
          settings.rate = 8;
          settings.timeSteps = timeSteps;
          settings.begin = begin;
          settings.end = end;
          device.takeError();
          RTCGeometry geometry = newSurface(device, cage, settings);
          refused += device.takeError() != RTC_ERROR_NONE; // an invalid time range
          releasing(geometry, RTC_COMPRESSION_CVERT);
          if (saveGeometryFile(geometry, (folder / "a").c_str())) {
            RTCGeometry loaded = loadGeometryFile(device, (folder / "a").c_str());
            EXPECT_NE(loaded, nullptr) << device.message;
            if (loaded) rtcReleaseGeometry(loaded);
          } else {
            refused++;
            EXPECT_TRUE(folder.names().empty());
          }
          rtcReleaseGeometry(geometry);
        }
  EXPECT_GT(refused, 0u);
  EXPECT_LT(refused, 60u);
}

// A scene that compresses other geometries has a tree for it, too.
TEST(CompressedFiles, UncompressedGeometryWithoutFacesIsNotSaved) {
  Folder folder;
  Device device;
  Cage holes = cubeCage();
  for (unsigned face = 0; face < holes.faces.size(); face++) holes.holes.push_back(face);
  Scene scene(device);
  attach(scene, allSaveable()[0].make(device));
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_NONE;
  RTCGeometry geometry = newSurface(device, holes, settings);
  attach(scene, geometry);
  rtcCommitScene(scene);
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_FALSE(saveGeometryFile(geometry, (folder / "a").c_str()));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_NE(device.message.find("compression"), std::string::npos) << device.message;
  EXPECT_TRUE(folder.names().empty());
}

TEST(CompressedFiles, ManyThreadsLoadAndTraceConcurrently) {
  Folder folder;
  Device device;
  Random random(12);
  const std::vector<Saveable> all = allSaveable();
  std::vector<std::vector<RTCRayHit>> expected;
  const std::vector<RTCRayHit> rays = timedRays(random, 200, true);
  for (size_t i = 0; i < 4; i++) {
    OneGeometry scene(device, all[i].make(device));
    ASSERT_TRUE(saveGeometryFile(scene.geometry, (folder / std::to_string(i)).c_str()));
    expected.push_back(closestHits(scene, rays, QueryForm::Single));
  }
  CbvhFile open = openFile(device, (folder / "0").c_str());
  ASSERT_NE(open, nullptr);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 4; t++)
    threads.emplace_back([&, t] {
      for (size_t round = 0; round < 12; round++) {
        const size_t i = (t + round) % 4;
        OneGeometry scene(device, loadGeometryFile(device, (folder / std::to_string(i)).c_str()));
        ASSERT_NE(scene.geometry, nullptr);
        expectSameToTheBit(expected[i], closestHits(scene, rays, QueryForm::Single));
        ASSERT_TRUE(saveGeometryFile(scene.geometry, (folder / (std::to_string(t) + "-saved")).c_str()));
        OneGeometry another(device, loadFromFile(device, open, 0));
        ASSERT_NE(another.geometry, nullptr);
        expectSameToTheBit(expected[0], closestHits(another, rays, QueryForm::Single));
      }
    });
  for (std::thread& thread : threads) thread.join();
  releaseFile(open);
  EXPECT_EQ(device.errors, 0u) << device.message;
  for (size_t t = 0; t < 4; t++)
    EXPECT_EQ(bytesOf(folder / (std::to_string(t) + "-saved")), bytesOf(folder / std::to_string((t + 11) % 4)));
}

}} // namespace programs::test
