// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libembree_cbvh: hits are those of our libembree3 to the bit, input is released, errors are reported, commits can be
 * canceled. */

#include "support/diced_mesh.h"
#include "support/edge_rates.h"
#include "support/message_parts.h"
#include "support/moving_surface.h"
#include "support/saved.h"
#include "support/surface_access.h"
#include "small_cube.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <thread>

namespace programs::test { namespace {

struct Context {
  CbvhContext handle = nullptr;
  std::vector<std::pair<CbvhError, std::string>> reported;

  Context() {
    EXPECT_EQ(
        cbvhNewContext(
            nullptr,
            [](void* self, CbvhError code, const char* text) { ((Context*)self)->reported.push_back({code, text}); },
            this, &handle),
        CBVH_OK);
  }
  ~Context() { cbvhReleaseContext(handle); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  operator CbvhContext() const { return handle; }

  // This error and no other since the last call.
  void expect(CbvhError found, CbvhError code, const std::vector<std::string>& parts) {
    EXPECT_EQ(found, code);
    EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), parts));
    ASSERT_EQ(reported.size(), 1u);
    EXPECT_EQ(reported[0].first, code);
    EXPECT_EQ(reported[0].second, cbvhGetErrorText());
    reported.clear();
  }
};

struct Surface {
  CbvhSurface handle = nullptr;
  explicit Surface(CbvhContext context) { EXPECT_EQ(cbvhNewSurface(context, &handle), CBVH_OK); }
  ~Surface() { cbvhReleaseSurface(handle); }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  operator CbvhSurface() const { return handle; }
};

struct Group {
  CbvhGroup handle = nullptr;
  CbvhError committed;
  Group(CbvhContext context, const std::vector<CbvhSurface>& surfaces) {
    EXPECT_EQ(cbvhNewGroup(context, surfaces.data(), surfaces.size(), &handle), CBVH_OK);
    committed = cbvhCommitGroup(handle);
  }
  ~Group() { cbvhReleaseGroup(handle); }
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  operator CbvhGroup() const { return handle; }
};

// Our displacement with the signature of libembree_cbvh.
void displace(const CbvhDisplacementArguments* args) {
  RTCDisplacementFunctionNArguments ours = RTCDisplacementFunctionNArguments();
  ours.geometryUserPtr = args->userPtr;
  ours.primID = args->primID;
  ours.timeStep = args->timeStep;
  ours.u = args->u;
  ours.v = args->v;
  ours.Ng_x = args->Ng_x;
  ours.Ng_y = args->Ng_y;
  ours.Ng_z = args->Ng_z;
  ours.P_x = args->P_x;
  ours.P_y = args->P_y;
  ours.P_z = args->P_z;
  ours.N = args->count;
  Displacement::apply(&ours);
}

// Vertices of time steps as the API expects them, padded after the last vertex.
struct Steps {
  std::vector<std::vector<Vec>> vertices;
  std::vector<const float*> pointers;

  Steps(const std::vector<Vec>& positions, const DicedMotion& motion, unsigned numSteps) {
    for (unsigned i = 0; i < numSteps; i++) {
      vertices.push_back(movedTo(positions, motion, i));
      vertices.back().push_back({0, 0, 0});
    }
    for (const auto& step : vertices) pointers.push_back(&step[0][0]);
  }

  CbvhVertices get(float begin = 0, float end = 1) const {
    return {vertices[0].size() - 1, sizeof(Vec), pointers.data(), unsigned(vertices.size()), begin, end};
  }
};

struct CageInput {
  std::vector<unsigned> faces, indices, creases, holes;
  std::vector<float> weights;
  Steps steps;
  CbvhCage cage = CbvhCage();

  CageInput(const Cage& from, const SurfaceSettings& settings)
    : faces(from.faces.begin(), from.faces.end()),
      indices(from.indices.begin(), from.indices.end()),
      holes(from.holes.begin(), from.holes.end()),
      weights(from.creaseWeights),
      steps(from.positions, settings.motion, settings.timeSteps) {
    for (const auto& crease : from.creases) {
      creases.push_back(crease[0]);
      creases.push_back(crease[1]);
    }
    cage.numFaces = faces.size();
    cage.faceVertexCounts = faces.data();
    cage.numIndices = indices.size();
    cage.indices = indices.data();
    cage.vertices = steps.get(settings.begin, settings.end);
    cage.rate = settings.rate;
    cage.numCreases = weights.size();
    cage.creases = creases.data();
    cage.creaseSharpness = weights.data();
    cage.numHoles = holes.size();
    cage.holes = holes.data();
    if (settings.displacement) {
      cage.displacement = displace;
      cage.displacementUserPtr = settings.displacement;
    }
  }
};

// Compares bits, except for IDs of geometries and instances.
void expectSame(RTCScene scene, CbvhGroup group, const std::vector<RTCRayHit>& rays) {
  size_t hits = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit expected = intersect(scene, ray);
    CbvhRayHit found;
    CbvhRay any;
    std::memcpy(&found, &ray, sizeof(found));
    std::memcpy(&any, &ray.ray, sizeof(any));
    ASSERT_EQ(cbvhIntersect1(group, &found, nullptr) != 0, isHit(expected));
    ASSERT_EQ(cbvhOccluded1(group, &any, nullptr) != 0, isHit(expected));
    ASSERT_EQ(std::memcmp(&found.ray, &expected.ray, sizeof(found.ray)), 0);
    if (!isHit(expected)) continue;
    ASSERT_EQ(std::memcmp(&found.hit, &expected.hit, 6 * sizeof(float)), 0);
    hits++;
  }
  EXPECT_GT(hits, rays.size() / 20);
}

SurfaceSettings settingsOf(Displacement& displacement, unsigned timeSteps, float rate) {
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.rate = rate;
  settings.timeSteps = timeSteps;
  settings.motion = [](const Vec& p, unsigned i) { return i ? twisted(p, 0.3 * i) : p; };
  return settings;
}

struct Clusters {
  std::vector<std::vector<unsigned char>> data;

  template<typename Cluster>
  static void add(void* self, const Cluster* cluster) {
    ((Clusters*)self)
        ->data.emplace_back((const unsigned char*)cluster->data, (const unsigned char*)cluster->data + cluster->bytes);
    ((Clusters*)self)->data.emplace_back(cluster->indices, cluster->indices + 3 * cluster->numTriangles);
  }
};

TEST(Capi, ClustersMatchOurEmbree) {
  Context context;
  Device device;
  Displacement displacement;
  const SurfaceSettings settings = settingsOf(displacement, 2, 13);
  const Cage cage = cubeCage();
  CageInput input(cage, settings);
  Surface surface(context);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
  EXPECT_EQ(cbvhForEachCluster(surface, 0, CBVH_CLUSTER_FORMAT_DGF1, nullptr, nullptr, nullptr),
            CBVH_ERROR_INVALID_OPERATION)
      << "not committed";
  context.reported.clear();
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  Scene scene(device);
  RTCGeometry geometry = newSurface(device, cage, settings);
  attach(scene, geometry);
  rtcCommitScene(scene);
  for (int format = 0; format < 3; format++)
    for (float time : {0.0f, 0.25f, 1.0f}) {
      Clusters ours, theirs;
      CbvhClusterStatistics report;
      CbvhClusterStatistics expected;
      ASSERT_EQ(cbvhForEachCluster(
                    surface, time, CbvhClusterFormat(format),
                    [](void* self, const CbvhCluster* cluster) {
                      Clusters::add(self, cluster);
                      return 1;
                    },
                    &ours, &report),
                CBVH_OK);
      forEachStoredCluster(
          geometry, time, CbvhClusterFormat(format),
          [](void* self, const CbvhCluster* cluster) {
            Clusters::add(self, cluster);
            return true;
          },
          &theirs, &expected);
      EXPECT_GT(ours.data.size(), 0u);
      EXPECT_EQ(ours.data, theirs.data);
      EXPECT_EQ(std::memcmp(&report, &expected, sizeof(report)), 0);
    }
  size_t calls = 0;
  EXPECT_EQ(cbvhForEachCluster(
                surface, 0, CBVH_CLUSTER_FORMAT_DGF1,
                [](void* n, const CbvhCluster*) { return int(++*(size_t*)n < 3); }, &calls, nullptr),
            CBVH_OK);
  EXPECT_EQ(calls, 3u) << "a callback that returns 0 ends the calls";
  EXPECT_EQ(cbvhForEachCluster(nullptr, 0, CBVH_CLUSTER_FORMAT_DGF1, nullptr, nullptr, nullptr),
            CBVH_ERROR_INVALID_ARGUMENT);
  context.reported.clear();
  context.expect(cbvhForEachCluster(surface, 0, CbvhClusterFormat(7), nullptr, nullptr, nullptr),
                 CBVH_ERROR_INVALID_ARGUMENT, {" 7"});
}

TEST(Capi, CageHitsMatchOurEmbree) {
  Random random(91);
  Device device;
  Context context;
  Cage creased = cubeCage();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  Cage withHole = sheetCage(4);
  withHole.holes = {5};
  for (const Cage& cage : {creased, withHole, prismCage(5)})
    for (unsigned timeSteps : {1u, 3u}) {
      Displacement displacement;
      const SurfaceSettings settings = settingsOf(displacement, timeSteps, 13);
      const SurfaceScene scene(device, cage, settings);
      const Surface surface(context);
      {
        auto input = std::make_unique<CageInput>(cage, settings);
        ASSERT_EQ(cbvhSetSurfaceCage(surface, &input->cage), CBVH_OK) << cbvhGetErrorText();
        input.reset();
      }
      ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
      EXPECT_EQ(cbvhGetSurfacePrimitiveCount(surface), cage.faces.size());
      const Group group(context, {surface});
      EXPECT_EQ(group.committed, CBVH_OK);
      ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, timedRays(random, 1500)));
      CbvhGroupStatistics statistics;
      ASSERT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK);
      EXPECT_EQ(statistics.numQuads, statisticsOf(scene).numQuads);
      EXPECT_EQ(statistics.numMovingQuads, timeSteps > 1 ? statistics.numQuads : 0);
      EXPECT_GT(statistics.bytes, statistics.numQuads);
    }
  EXPECT_TRUE(context.reported.empty());
}

// The commit reads vertices of grids and meshes; they are released before rays are traced.
TEST(Capi, GridAndMeshHitsMatchOurEmbree) {
  Random random(92);
  Device device;
  Context context;
  const DicedMotion motion = [](const Vec& p, unsigned i) { return i ? twisted(p, 0.3 * i) : p; };
  Diced diced = dicedSheet(3, 16);
  diced.motion = motion;
  for (unsigned timeSteps : {1u, 2u}) {
    const auto compare = [&](RTCGeometry geometry, CbvhSurface surface, const std::vector<RTCRayHit>& rays) {
      Scene scene(device);
      attach(scene, geometry);
      rtcCommitScene(scene);
      const Group group(context, {surface});
      EXPECT_EQ(group.committed, CBVH_OK);
      expectSame(scene, group, rays);
    };
    std::vector<RTCRayHit> rays = timedRays(random, 3000);
    {
      const Surface surface(context);
      auto steps = std::make_unique<Steps>(diced.vertices, motion, timeSteps);
      std::vector<CbvhGrid> grids;
      for (const RTCGrid& g : diced.grids) grids.push_back({g.startVertexID, g.stride, g.width, g.height});
      const CbvhGrids input = {sizeof(CbvhGrids), grids.size(), grids.data(), steps->get()};
      ASSERT_EQ(cbvhSetSurfaceGrids(surface, &input), CBVH_OK);
      grids.clear();
      ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
      steps.reset();
      ASSERT_NO_FATAL_FAILURE(compare(newGrids(device, diced, RTC_COMPRESSION_CVERT, 0, timeSteps), surface, rays));
    }
    DicedMesh quads = meshOf(diced, QuadOrder::Rows, random);
    quads.motion = motion;
    for (const DicedMesh& mesh : {quads, trianglesOf(quads, 1, 2)}) {
      const Surface surface(context);
      auto steps = std::make_unique<Steps>(mesh.vertices, motion, timeSteps);
      const unsigned* const indices = mesh.isTriangleForm() ? mesh.triangles[0].data() : mesh.quads[0].data();
      const CbvhMesh input = {sizeof(CbvhMesh), mesh.isTriangleForm() ? 3u : 4u, mesh.size(), indices, steps->get()};
      ASSERT_EQ(cbvhSetSurfaceMesh(surface, &input), CBVH_OK);
      ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
      steps.reset();
      ASSERT_NO_FATAL_FAILURE(compare(newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps), surface, rays));
    }
  }
}

// No vertex moves. Without cbvhSetSurfaceLossless, surfaces use the default precision again.
TEST(Capi, LosslessHitsMatchOurEmbree) {
  Random random(95);
  Device exact("cbvh_max_error=0"), device;
  Context context;
  Displacement displacement;
  Diced diced = dicedSheet(2, 33);
  diced.motion = [](const Vec& p, unsigned i) { return i ? twisted(p, 0.3 * i) : p; };
  std::vector<CbvhGrid> grids;
  for (const RTCGrid& g : diced.grids) grids.push_back({g.startVertexID, g.stride, g.width, g.height});
  for (unsigned timeSteps : {1u, 3u}) {
    const SurfaceSettings settings = settingsOf(displacement, timeSteps, 29);
    const CageInput cage(prismCage(5), settings);
    const Steps steps(diced.vertices, diced.motion, timeSteps);
    const CbvhGrids ofGrids = {sizeof(CbvhGrids), grids.size(), grids.data(), steps.get()};
    for (bool isCage : {true, false}) {
      SCOPED_TRACE(testing::Message() << (isCage ? "a cage, " : "grids, ") << timeSteps << " time steps");
      const Surface surface(context);
      for (int lossless : {1, 0}) {
        ASSERT_EQ(isCage ? cbvhSetSurfaceCage(surface, &cage.cage) : cbvhSetSurfaceGrids(surface, &ofGrids), CBVH_OK)
            << cbvhGetErrorText();
        ASSERT_EQ(cbvhSetSurfaceLossless(surface, lossless), CBVH_OK);
        ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
        const Group group(context, {surface});
        EXPECT_EQ(group.committed, CBVH_OK);
        CbvhGroupStatistics statistics;
        ASSERT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK);
        EXPECT_EQ(statistics.maxVertexDeviation == 0, lossless == 1);
        const RTCDevice of = lossless ? exact : device;
        Scene scene(of);
        attach(scene, isCage ? newSurface(of, prismCage(5), settings)
                             : newGrids(of, diced, RTC_COMPRESSION_CVERT, 0, timeSteps));
        rtcCommitScene(scene);
        EXPECT_EQ(statisticsOf(scene).maxVertexDeviation, statistics.maxVertexDeviation);
        ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, timedRays(random, 1500)));
      }
    }
  }
  EXPECT_TRUE(context.reported.empty());
}

TEST(Capi, FilesAreInterchangeableWithOurEmbree) {
  Random random(93);
  Folder folder;
  Context context;
  for (const Saveable& saveable : allSaveable()) {
    if (!saveable.hasTriangles || saveable.name.find("cGRID") == 0) continue; // cVERT
    SCOPED_TRACE(saveable.name);
    Device device;
    RTCGeometry geometry = saveable.make(device);
    ASSERT_TRUE(saveGeometryFile(geometry, (folder / "ours").c_str())) << device.message;
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    CbvhSurface surface = nullptr;
    ASSERT_EQ(cbvhLoadSurface(context, (folder / "ours").c_str(), &surface), CBVH_OK) << cbvhGetErrorText();
    EXPECT_GT(cbvhGetSurfacePrimitiveCount(surface), 0u);
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
    {
      const Group group(context, {surface});
      EXPECT_EQ(group.committed, CBVH_OK);
      ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, timedRays(random, 500)));
    }
    ASSERT_EQ(cbvhSaveSurface(surface, (folder / "capi").c_str()), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(bytesOf(folder / "ours"), bytesOf(folder / "capi"));
    cbvhReleaseSurface(surface);
  }
  EXPECT_TRUE(context.reported.empty());

  CbvhSurface none = nullptr;
  const std::string whole = bytesOf(folder / "ours");
  writeBytes(folder / "ours", whole.substr(0, 5000));
  context.expect(cbvhLoadSurface(context, (folder / "ours").c_str(), &none), CBVH_ERROR_INVALID_ARGUMENT,
                 {folder / "ours", " 5000 ", std::to_string(whole.size())});
  context.expect(cbvhLoadSurface(context, (folder / "none").c_str(), &none), CBVH_ERROR_INVALID_ARGUMENT,
                 {folder / "none", std::strerror(ENOENT)});
  context.expect(cbvhLoadSurface(context, nullptr, &none), CBVH_ERROR_INVALID_ARGUMENT, {"path", "NULL"});
  EXPECT_EQ(none, nullptr);
  const Surface empty(context);
  context.expect(cbvhSaveSurface(empty, (folder / "empty").c_str()), CBVH_ERROR_INVALID_OPERATION,
                 {"cbvhCommitSurface"});
  context.expect(cbvhSaveSurface(empty, nullptr), CBVH_ERROR_INVALID_ARGUMENT, {"path ", "NULL"});
}

// This program contains both libraries, which have functions with the same names.
TEST(Capi, SurfacesOfOneLibraryAreRejectedByTheOther) {
  Context context;
  Device device;
  const Surface surface(context);
  EXPECT_EQ(rtcNewGeometryFromSurface(device, surface), nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"libembree_cbvh", "libembree3"}));
  EXPECT_NE(reinterpret_cast<void*>(&cbvhNewSurface), functionOfLibembree3("cbvhNewSurface"));
}

// The same as diceGeometry, whose tests check the rates.
TEST(Capi, CagesAreDicedByTheView) {
  Random random(94);
  Context context;
  Device device;
  for (unsigned steps : {1u, 3u})
    for (const auto& c : closedCages) {
      SCOPED_TRACE(c.name);
      Displacement displacement;
      CageInput input(c.cage, settingsOf(displacement, steps, 4));
      CbvhDicingArguments dicing;
      const float position[3] = {0.3f, 0.2f, 2}, ahead[3] = {0, 0, -1}, up[3] = {0, 1, 0};
      std::copy_n(position, 3, dicing.position);
      std::copy_n(ahead, 3, dicing.direction);
      std::copy_n(up, 3, dicing.up);
      dicing.pixelSize = 0.03f;
      dicing.width = dicing.height = 40;

      RTCGeometry geometry = newSurface(device, c.cage, settingsOf(displacement, steps, 4));
      rtcCommitGeometry(geometry);
      diceGeometry(geometry, &dicing);
      const float* const levels = (const float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_LEVEL, 0);
      const std::vector<float> expected(levels, levels + input.cage.numIndices);
      rtcReleaseGeometry(geometry);

      const Surface surface(context), given(context);
      std::vector<float> rates(expected.size());
      ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
      ASSERT_EQ(cbvhDiceSurface(surface, &dicing, rates.data()), CBVH_OK) << cbvhGetErrorText();
      EXPECT_EQ(rates, expected);
      EXPECT_LT(*std::min_element(rates.begin(), rates.end()), *std::max_element(rates.begin(), rates.end()));
      ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
      input.cage.rates = expected.data();
      ASSERT_EQ(cbvhSetSurfaceCage(given, &input.cage), CBVH_OK);
      ASSERT_EQ(cbvhCommitSurface(given, nullptr, nullptr), CBVH_OK);
      const Folder folder;
      ASSERT_EQ(cbvhSaveSurface(surface, (folder / "diced").c_str()), CBVH_OK);
      ASSERT_EQ(cbvhSaveSurface(given, (folder / "given").c_str()), CBVH_OK);
      EXPECT_EQ(bytesOf(folder / "diced"), bytesOf(folder / "given")) << "both ways to set rates";

      dicing.pixelSize = 0;
      // the cage has been released
      context.expect(cbvhDiceSurface(given, &dicing, nullptr), CBVH_ERROR_INVALID_OPERATION, {"cbvhSetSurfaceCage"});
      ASSERT_EQ(cbvhSetSurfaceCage(given, &input.cage), CBVH_OK);
      context.expect(cbvhDiceSurface(given, &dicing, nullptr), CBVH_ERROR_INVALID_ARGUMENT, {"pixelSize", " 0", " 0"});
      context.expect(cbvhDiceSurface(given, nullptr, nullptr), CBVH_ERROR_INVALID_ARGUMENT, {"dicing ", "NULL"});
      ASSERT_EQ(cbvhCommitSurface(given, nullptr, nullptr), CBVH_OK) << "a rejected view changes nothing";
      ASSERT_EQ(cbvhSaveSurface(given, (folder / "given").c_str()), CBVH_OK);
      EXPECT_EQ(bytesOf(folder / "diced"), bytesOf(folder / "given"));
    }
}

// The settings compress cages, and release them, whenever they are committed, which dicing must not do.
TEST(Capi, CagesAreDicedWhateverTheSettingsSelect) {
  CbvhContext context = nullptr;
  ASSERT_EQ(cbvhNewContext("subdiv_accel=cbvh,cbvh_release_input=1", nullptr, nullptr, &context), CBVH_OK);
  {
    const CbvhCage cage = cube();
    const Surface surface(context);
    std::vector<void*> blocks; // leave NaN in the heap, where the cage's vertices will be
    for (size_t bytes = 16; bytes < 2048; bytes += 16)
      for (int i = 0; i < 20; i++) {
        blocks.push_back(std::malloc(bytes));
        std::memset(blocks.back(), 0xFF, bytes);
      }
    for (void* block : blocks) std::free(block);
    CbvhDicingArguments dicing = CbvhDicingArguments();
    dicing.position[2] = 5;
    dicing.pixelSize = 0.1f;
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK);
    for (int i = 0; i < 2; i++) EXPECT_EQ(cbvhDiceSurface(surface, &dicing, nullptr), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  }
  cbvhReleaseContext(context);
}

TEST(Capi, MeshesWithoutGridsAreCompressedWithAndWithoutMotion) {
  Random random(93);
  Context context;
  Device device;
  const Surface surface(context);
  DicedMesh mesh;
  mesh.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.3 * i); };
  for (unsigned i = 0; i < 3000; i++) {
    mesh.vertices.push_back({float(random.uniform()), float(random.uniform()), float(random.uniform())});
    if (i >= 3) mesh.triangles.push_back({random.below(i), random.below(i), random.below(i)});
  }
  for (unsigned n : {1u, 2u}) {
    const Steps steps(mesh.vertices, mesh.motion, n);
    const CbvhMesh input = {sizeof(CbvhMesh), 3, mesh.size(), mesh.triangles[0].data(), steps.get()};
    ASSERT_EQ(cbvhSetSurfaceMesh(surface, &input), CBVH_OK);
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    Scene scene(device);
    attach(scene, newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, n));
    rtcCommitScene(scene);
    EXPECT_GT(statisticsOf(scene).numIrregularQuads, 0u);
    const Group group(context, {surface});
    EXPECT_EQ(group.committed, CBVH_OK);
    ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, timedRays(random, 500)));
  }
}

TEST(Capi, InvalidInputIsReportedByName) {
  Context context;
  const Surface surface(context);
  Displacement displacement;
  context.expect(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_ERROR_INVALID_OPERATION,
                 {" no ", "cage", "grids", "mesh"});
  const auto expectInvalid = [&](const std::vector<std::string>& parts, const std::function<void(CbvhCage&)>& modify) {
    SCOPED_TRACE(testing::PrintToString(parts));
    CageInput input(cubeCage(), settingsOf(displacement, 2, 4));
    modify(input.cage);
    context.expect(cbvhSetSurfaceCage(surface, &input.cage), CBVH_ERROR_INVALID_ARGUMENT, parts);
  };
  const std::vector<const float*> none(2, nullptr);
  expectInvalid({" no ", "faces", "indices"}, [](CbvhCage& c) { c.numFaces = 0; });
  expectInvalid({" no ", "faces", "indices"}, [](CbvhCage& c) { c.indices = nullptr; });
  expectInvalid({"rate", " 0", "1", "4096"}, [](CbvhCage& c) { c.rate = 0; });
  expectInvalid({"rate", "nan", "1", "4096"}, [](CbvhCage& c) { c.rate = NAN; });
  std::vector<float> rates(24, 4);
  rates[7] = 4097;
  expectInvalid({"rate", " 4097", " 7", "1", "4096"}, [&](CbvhCage& c) { c.rates = rates.data(); });
  expectInvalid({"stride", "vertices", " 10 ", "4", "12"}, [](CbvhCage& c) { c.vertices.stride = 10; });
  expectInvalid({"time steps", " 130", "1", "129"}, [](CbvhCage& c) { c.vertices.numSteps = 130; });
  expectInvalid({"time range", " 0 ", " 0"}, [](CbvhCage& c) { c.vertices.endTime = c.vertices.startTime; });
  expectInvalid({"time step 0", "NULL"}, [&](CbvhCage& c) { c.vertices.steps = none.data(); });
  expectInvalid({"time range", "-3e+38", "3e+38"}, [](CbvhCage& c) {
    c.vertices.startTime = -3e38f;
    c.vertices.endTime = 3e38f;
  });
  expectInvalid({"no vertices"}, [](CbvhCage& c) { c.vertices.numVertices = 0; });
  expectInvalid({"vertices", "4294967296", "4294967295"},
                [](CbvhCage& c) { c.vertices.numVertices = size_t(1) << 32; });
  expectInvalid({"creases", "numCreases"}, [](CbvhCage& c) {
    c.numCreases = 2;
    c.creases = nullptr;
  });
  const unsigned edge[2] = {0, 1};
  for (float wrong : {NAN, -1.0f}) {
    const std::string value = std::isnan(wrong) ? "nan" : "-1";
    expectInvalid({"creaseSharpness", " 0 ", value, "0", "infinity"}, [&](CbvhCage& c) {
      c.numCreases = 1;
      c.creases = edge;
      c.creaseSharpness = &wrong;
    });
    expectInvalid({"cornerSharpness", " 0 ", value, "0", "infinity"}, [&](CbvhCage& c) {
      c.numCorners = 1;
      c.corners = edge;
      c.cornerSharpness = &wrong;
    });
  }
  expectInvalid({"boundary", " 9", "0", "3"}, [](CbvhCage& c) { c.boundary = CbvhBoundary(9); });
  const float value = 1;
  const CbvhAttribute attribute = {&value, 1, 4, 1, nullptr, CBVH_BOUNDARY_SMOOTH};
  expectInvalid({"index 1", "attribute 0", " 4", " 1 "}, [&](CbvhCage& c) {
    c.numAttributes = 1;
    c.attributes = &attribute;
  });
  const CbvhGrid grid = {0, 2, 2, 2};
  const float corner = 0;
  const float* const steps[] = {&corner};
  for (size_t stride : {size_t(1) << 33, size_t(1) << 62}) { // four such strides are 32 GiB, and 0 modulo 2^64
    CbvhGrids grids = CbvhGrids();
    grids.numGrids = 1;
    grids.grids = &grid;
    grids.vertices = {4, stride, steps, 1, 0, 0};
    context.expect(cbvhSetSurfaceGrids(surface, &grids), CBVH_ERROR_INVALID_ARGUMENT,
                   {" 4 ", std::to_string(stride), "16 GiB"});
  }
  context.expect(cbvhSetSurfaceCage(surface, nullptr), CBVH_ERROR_INVALID_ARGUMENT, {"cage ", "NULL"});
  const CbvhAccuracy negative = {sizeof(CbvhAccuracy), -1, 0, {0, 0, 0}, 0};
  context.expect(cbvhSetSurfaceAccuracy(surface, &negative), CBVH_ERROR_INVALID_ARGUMENT, {"maxError", "-1", "0"});
  const auto refuseAccuracy = [&](const char* name, const char* value,
                                  const std::function<void(CbvhAccuracy&)>& change) {
    CbvhAccuracy accuracy = CbvhAccuracy();
    accuracy.maxPixelError = 0.5f;
    accuracy.pixelSize = 0.001f;
    EXPECT_EQ(cbvhSetSurfaceAccuracy(surface, &accuracy), CBVH_OK) << cbvhGetErrorText();
    change(accuracy);
    context.expect(cbvhSetSurfaceAccuracy(surface, &accuracy), CBVH_ERROR_INVALID_ARGUMENT, {name, value});
  };
  for (const auto& [wrong, text] :
       {std::make_pair(NAN, "nan"), std::make_pair(INFINITY, "inf"), std::make_pair(-1.0f, "-1")}) {
    const float number = wrong;
    refuseAccuracy("maxError", text, [=](CbvhAccuracy& a) { a.maxError = number; });
    refuseAccuracy("maxPixelError", text, [=](CbvhAccuracy& a) { a.maxPixelError = number; });
    refuseAccuracy("pixelSize", text, [=](CbvhAccuracy& a) { a.pixelSize = number; });
  }
  refuseAccuracy("pixelSize", " 0", [](CbvhAccuracy& a) { a.pixelSize = 0; });
  for (int k = 0; k < 3; k++)
    refuseAccuracy("cameraPosition", "nan", [=](CbvhAccuracy& a) { a.cameraPosition[k] = NAN; });
  const CbvhAccuracy unused = {sizeof(CbvhAccuracy), 0, 0, {0, 0, 0}, -1};
  EXPECT_EQ(cbvhSetSurfaceAccuracy(surface, &unused), CBVH_OK) << "without maxPixelError there is no camera";
  EXPECT_EQ(cbvhSetSurfaceAccuracy(surface, nullptr), CBVH_OK);

  EXPECT_EQ(cbvhNewSurface(nullptr, nullptr), CBVH_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(cbvhCommitGroup(nullptr), CBVH_ERROR_INVALID_ARGUMENT);
  CbvhGroup group = nullptr;
  const CbvhSurface surfaces[2] = {surface, nullptr};
  context.expect(cbvhNewGroup(context, surfaces, 2, &group), CBVH_ERROR_INVALID_ARGUMENT, {"surface 1 ", "NULL"});
  Context other;
  EXPECT_EQ(cbvhNewGroup(other, surfaces, 1, &group), CBVH_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(cbvhNewGroup(context, surfaces, 1, &group), CBVH_OK);
  context.expect(cbvhCommitGroup(group), CBVH_ERROR_INVALID_OPERATION, {"cbvhCommitSurface"});
  cbvhReleaseGroup(group);
  CbvhContext none2 = nullptr;
  EXPECT_NE(cbvhNewContext("cbvh_bogus=1", nullptr, nullptr, &none2), CBVH_OK);
  for (const char* size : {"-1", "-.5", "1e14", "1e30", "1e39", "inf", "nan"}) {
    EXPECT_EQ(cbvhNewContext((std::string("cache_size=") + size).c_str(), nullptr, nullptr, &none2),
              CBVH_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(cbvhGetErrorText(), {std::string("\"") + size + "\"", "cache_size"}));
  }
  EXPECT_EQ(none2, nullptr);
}

TEST(Capi, SharpnessOf10AndMoreIsInfinite) {
  Context context;
  const unsigned edge[2] = {4, 5}, vertex = 7;
  // distances of hits next to the edge and to the vertex
  const auto distances = [&](float ofEdge, float ofVertex) {
    CbvhCage cage = cube();
    cage.numCreases = 1;
    cage.creases = edge;
    cage.creaseSharpness = &ofEdge;
    cage.numCorners = 1;
    cage.corners = &vertex;
    cage.cornerSharpness = &ofVertex;
    const Surface surface(context);
    EXPECT_EQ(cbvhSetSurfaceCage(surface, &cage), CBVH_OK) << cbvhGetErrorText();
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    const Group group(context, {surface});
    std::vector<float> found;
    for (float x : {0.0f, 1.0f}) {
      CbvhRayHit ray = rayFromAbove();
      ray.ray.org_x = 3 * x + 0.001f;
      ray.ray.org_y = x > 0 ? 3.0f : -3.0f;
      ray.ray.org_z = 3;
      ray.ray.dir_x = -x;
      ray.ray.dir_y = x > 0 ? -1.0f : 1.0f;
      ray.ray.dir_z = -1;
      EXPECT_EQ(cbvhIntersect1(group, &ray, nullptr), 1);
      found.push_back(ray.ray.tfar);
    }
    return found;
  };
  const std::vector<float> sharp = distances(INFINITY, INFINITY);
  EXPECT_NEAR(sharp[1], 2, 0.01);
  for (float sharpness : {10.0f, 11.5f, 1e30f}) EXPECT_EQ(distances(sharpness, sharpness), sharp) << sharpness;
  EXPECT_GT(distances(INFINITY, 9.5f)[1], sharp[1] + 1e-4f);
}

// The interposer relies on it, see kernels/interposer/input.cpp.
TEST(Capi, EmbreeRoundsCornersOfLargeFiniteSharpnessLikeThoseJustBelow10) {
  const Device device;
  const auto surface = [&](float sharpness) {
    Cage cage = cubeCage();
    cage.corners = {7};
    cage.cornerWeights = {sharpness};
    const RTCGeometry geometry = newSurface(device, cage, SurfaceSettings());
    std::vector<float> points;
    for (unsigned primID = 0; primID < 6; primID++)
      for (unsigned i = 0; i < 17 * 17; i++) {
        float p[3];
        rtcInterpolate0(geometry, primID, float(i % 17) / 16, float(i / 17) / 16, RTC_BUFFER_TYPE_VERTEX, 0, p, 3);
        points.insert(points.end(), p, p + 3);
      }
    rtcReleaseGeometry(geometry);
    return points;
  };
  const std::vector<float> rounded = surface(std::nextafter(10.0f, 0.0f));
  for (float sharpness : {10.0f, 10.5f, 20.0f, 1e30f}) EXPECT_EQ(surface(sharpness), rounded) << sharpness;
  EXPECT_NE(surface(INFINITY), rounded);
}

TEST(Capi, NonFiniteDisplacementIsReported) {
  Random random(94);
  Device device;
  Context context;
  Displacement displacement;
  displacement.poison = [](unsigned primID, float u, float v) {
    return primID == 2 && u > 0.3f && u < 0.45f && v > 0.4f && v < 0.6f;
  };
  const SurfaceSettings settings = settingsOf(displacement, 1, 32);
  const SurfaceScene scene(device, cubeCage(), settings);
  const Surface surface(context);
  const CageInput input(cubeCage(), settings);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  const Group group(context, {surface});
  context.expect(group.committed, CBVH_ERROR_INVALID_ARGUMENT, {"geometry 0", "face 2"});
  ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, raysAt(random, 2000)));
}

TEST(Capi, CommitsReportProgressAndCanBeCanceled) {
  Random random(95);
  Device device;
  Context context;
  Displacement displacement;
  const SurfaceSettings settings = settingsOf(displacement, 1, 200);
  const CageInput input(sheetCage(8), settings);
  const Surface surface(context);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
  struct Reported {
    std::atomic<unsigned> calls{0};
    unsigned most;
  } reported;
  const auto progress = [](void* self, double done) {
    Reported& reported = *(Reported*)self;
    return int(done >= 0 && done <= 1 && ++reported.calls <= reported.most);
  };
  reported.most = 3;
  context.expect(cbvhCommitSurface(surface, progress, &reported), CBVH_ERROR_CANCELLED, {});
  EXPECT_GT(reported.calls, 3u);
  reported.most = ~0u;
  ASSERT_EQ(cbvhCommitSurface(surface, progress, &reported), CBVH_OK) << cbvhGetErrorText();
  const SurfaceScene scene(device, sheetCage(8), settings);
  const Group group(context, {surface});
  ASSERT_NO_FATAL_FAILURE(expectSame(scene, group, raysAt(random, 1000)));
}

TEST(Capi, AttributesAreInterpolatedAfterTheCageIsReleased) {
  Device device;
  Context context;
  Displacement displacement;
  const Cage cage = cubeCage();
  std::vector<float> ofVertices, ofCorners;
  std::vector<unsigned> corners;
  for (size_t i = 0; i < cage.positions.size(); i++) ofVertices.push_back(float(i * i));
  for (size_t i = 0; i < cage.indices.size(); i++) {
    ofCorners.push_back(float(i % 4 == 1 || i % 4 == 2));
    ofCorners.push_back(float(i % 4 >= 2));
    corners.push_back(unsigned(i));
  }
  const Surface surface(context);
  {
    CageInput input(cage, settingsOf(displacement, 1, 8));
    const CbvhAttribute attributes[2] = {
        {ofVertices.data(), ofVertices.size(), 4, 1, nullptr, CBVH_BOUNDARY_SMOOTH},
        {ofCorners.data(), corners.size(), 8, 2, corners.data(), CBVH_BOUNDARY_PIN_ALL}};
    input.cage.numAttributes = 2;
    input.cage.attributes = attributes;
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK) << cbvhGetErrorText();
  }
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  for (unsigned face = 0; face < 6; face++) {
    float uv[2], dPdu[2], dPdv[2], value = -1;
    ASSERT_EQ(cbvhInterpolateAttribute(surface, face, 0.25f, 0.75f, 1, uv, dPdu, dPdv), CBVH_OK) << cbvhGetErrorText();
    EXPECT_NEAR(uv[0], 0.25f, 1e-5f);
    EXPECT_NEAR(uv[1], 0.75f, 1e-5f);
    EXPECT_NEAR(dPdu[0], 1, 1e-4f);
    EXPECT_NEAR(dPdv[1], 1, 1e-4f);
    ASSERT_EQ(cbvhInterpolateAttribute(surface, face, 0.5f, 0.5f, 0, &value, nullptr, nullptr), CBVH_OK);
    EXPECT_TRUE(value >= 0 && value <= 49);
  }
  context.expect(cbvhInterpolateAttribute(surface, 0, 0, 0, 2, nullptr, nullptr, nullptr), CBVH_ERROR_INVALID_ARGUMENT,
                 {"attribute", " 2", " 2 "});
  context.expect(cbvhInterpolateAttribute(surface, 6, 0, 0, 0, nullptr, nullptr, nullptr), CBVH_ERROR_INVALID_ARGUMENT,
                 {"primID", " 6", " 6 "});
}

// Limits of the faces at a vertex, of the cage or of an attribute's topology.
TEST(Capi, AttributesAtVerticesWithTooManyFacesAreErrors) {
  Context context;
  Displacement displacement;
  const Cage poles = trapezohedronCage(1025), sheet = sheetCage(46);
  ASSERT_GT(sheet.faces.size(), poles.faces.size());
  for (bool isOwn : {false, true}) {
    const Cage& cage = isOwn ? sheet : poles;
    std::vector<unsigned> corners = poles.indices; // and separate values at the corners of further faces
    while (corners.size() < cage.indices.size()) corners.push_back(unsigned(poles.positions.size() + corners.size()));
    const std::vector<float> values(poles.positions.size() + cage.indices.size(), 2.0f);
    const unsigned* const indices = isOwn ? corners.data() : nullptr;
    const CbvhAttribute attribute = {values.data(), values.size(), 4, 1, indices, CBVH_BOUNDARY_SMOOTH};
    const Surface surface(context);
    CageInput input(cage, settingsOf(displacement, 1, 4));
    input.cage.numAttributes = 1;
    input.cage.attributes = &attribute;
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK) << cbvhGetErrorText();
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    float value = -1;
    const float u = 0.25f, v = 0.5f;
    CbvhInterpolationPoints points = CbvhInterpolationPoints();
    points.count = 1;
    points.u = &u;
    points.v = &v;
    points.P = &value;
    for (unsigned face : {0u, 7u, 2049u}) {
      points.primID = face;
      const std::vector<std::string> parts = {"face " + std::to_string(face) + " ", "16 ", "1024 "};
      const CbvhError error = cbvhInterpolateAttribute(surface, face, u, v, 0, &value, nullptr, nullptr);
      context.expect(error, CBVH_ERROR_INVALID_ARGUMENT, parts);
      context.expect(cbvhInterpolateAttributeAtPoints(surface, &points), CBVH_ERROR_INVALID_ARGUMENT, parts);
      EXPECT_EQ(value, -1) << "face " << face;
    }
    if (!isOwn) continue;
    ASSERT_EQ(cbvhInterpolateAttribute(surface, 2100, u, v, 0, &value, nullptr, nullptr), CBVH_OK)
        << cbvhGetErrorText();
    EXPECT_NEAR(value, 2, 1e-5f);
  }
}

TEST(Capi, ControlVerticesThatAreNotFiniteAreNamed) {
  Context context;
  Displacement displacement;
  Cage cage = sheetCage(8);
  cage.positions[31][0] = NAN;
  const CageInput bad(cage, settingsOf(displacement, 1, 4)), good(cubeCage(), settingsOf(displacement, 1, 4));
  const Surface surfaces[2] = {Surface(context), Surface(context)};
  for (const CageInput* input : {&good, &bad}) {
    const Surface& surface = surfaces[input == &bad];
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &input->cage), CBVH_OK) << cbvhGetErrorText();
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  }
  const Group group(context, {surfaces[0], surfaces[1]});
  context.expect(group.committed, CBVH_ERROR_INVALID_ARGUMENT,
                 {"geometry 1, face 10:", " vertex 31 ", "finite", " 16 face", " 256 quads"});
  CbvhGroupStatistics statistics;
  ASSERT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK);
  EXPECT_EQ(statistics.numInvalidQuads, 256u);
  EXPECT_EQ(statistics.firstInvalidSurface, 1u);
  EXPECT_EQ(statistics.firstInvalidPrimitive, 10u);
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK) << "reported once: " << cbvhGetErrorText();
}

// A missing sample of a terrain is no error.
TEST(Capi, VerticesOfGridsThatAreNotFiniteAreCountedAndNamed) {
  Context context;
  const Surface surface(context);
  std::vector<Vec> vertices;
  for (unsigned i = 0; i <= 2 * 9 * 9; i++) vertices.push_back({float(i % 9), float(i / 9), 0});
  vertices[9 * 9 + 40][2] = NAN;
  const float* const steps[] = {&vertices[0][0]};
  const CbvhGrid all[] = {{0, 9, 9, 9}, {9 * 9, 9, 9, 9}};
  CbvhGrids grids;
  grids.numGrids = 2;
  grids.grids = all;
  grids.vertices = {2 * 9 * 9, 12, steps, 1, 0, 1};
  ASSERT_EQ(cbvhSetSurfaceGrids(surface, &grids), CBVH_OK) << cbvhGetErrorText();
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  const Group group(context, {surface});
  EXPECT_EQ(group.committed, CBVH_OK) << cbvhGetErrorText();
  CbvhGroupStatistics statistics;
  ASSERT_EQ(cbvhGetGroupStatistics(group, &statistics), CBVH_OK);
  EXPECT_EQ(statistics.numInvalidQuads, 4u);
  EXPECT_EQ(statistics.firstInvalidSurface, 0u);
  EXPECT_EQ(statistics.firstInvalidPrimitive, 1u);
}

TEST(Capi, MeshesAreStoredFromOneTriangleOn) {
  Context context;
  const float vertices[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  const float* const steps[] = {vertices[0]};
  const unsigned indices[] = {0, 1, 2, 3};
  for (unsigned corners : {3u, 4u}) {
    const Surface surface(context);
    CbvhMesh mesh;
    mesh.verticesPerFace = corners;
    mesh.numFaces = 1;
    mesh.indices = indices;
    mesh.vertices = {4, 12, steps, 1, 0, 1};
    ASSERT_EQ(cbvhSetSurfaceMesh(surface, &mesh), CBVH_OK) << cbvhGetErrorText();
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
    const Group group(context, {surface});
    ASSERT_EQ(group.committed, CBVH_OK) << cbvhGetErrorText();
    CbvhRayHit ray = rayFromAbove();
    ray.ray.org_x = 0.7f;
    ray.ray.org_y = 0.1f;
    EXPECT_EQ(cbvhIntersect1(group, &ray, nullptr), 1);
    EXPECT_EQ(ray.ray.tfar, 5);
    EXPECT_EQ(ray.hit.primID, 0u);
    ray = rayFromAbove();
    ray.ray.org_x = 0.4f;
    ray.ray.org_y = 0.9f;
    EXPECT_EQ(cbvhOccluded1(group, &ray.ray, nullptr), corners == 4);
  }
}

TEST(Capi, RaysIntoGroupsThatWereNeverCommitted) {
  Context context;
  const Surface surface(context);
  Displacement displacement;
  const CageInput input(cubeCage(), settingsOf(displacement, 1, 4));
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  CbvhGroup group = nullptr;
  const CbvhSurface handle = surface;
  ASSERT_EQ(cbvhNewGroup(context, &handle, 1, &group), CBVH_OK);
  const std::vector<std::string> parts = {"group is not committed", "cbvhCommitGroup"};
  const auto expect = [&](unsigned hits) {
    EXPECT_EQ(hits, 0u);
    context.expect(CBVH_ERROR_INVALID_OPERATION, CBVH_ERROR_INVALID_OPERATION, parts);
  };
  CbvhRayHit ray = rayFromAbove();
  alignas(64) RTCRayHit16 packet = RTCRayHit16();
  expect(cbvhIntersect1(group, &ray, nullptr));
  expect(cbvhOccluded1(group, &ray.ray, nullptr));
  expect(cbvhIntersect4(group, nullptr, &packet, nullptr));
  expect(cbvhIntersect8(group, nullptr, &packet, nullptr));
  expect(cbvhIntersect16(group, nullptr, &packet, nullptr));
  expect(cbvhOccluded4(group, nullptr, &packet, nullptr));
  expect(cbvhOccluded8(group, nullptr, &packet, nullptr));
  expect(cbvhOccluded16(group, nullptr, &packet, nullptr));
  EXPECT_EQ(ray.ray.tfar, INFINITY);
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK);
  EXPECT_EQ(cbvhIntersect1(group, &ray, nullptr), 1);
  cbvhReleaseGroup(group);
}

// They have no effect, as in OpenSubdiv.
TEST(Capi, CreasesBetweenVerticesThatShareNoEdgeAreNamed) {
  Context context;
  const Surface surface(context);
  Cage cage = cubeCage();
  cage.creases = {{0, 1}, {0, 7}};
  cage.creaseWeights = {1, 1};
  Displacement displacement;
  const CageInput input(cage, settingsOf(displacement, 1, 4));
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK) << cbvhGetErrorText();
  testing::internal::CaptureStderr();
  EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(containsInOrder(text, {"crease 1 ", "vertices 0 and 7", "edge"})) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

TEST(Capi, TrianglesAreReported) {
  Random random(96);
  Context context;
  Displacement displacement;
  const SurfaceSettings settings = settingsOf(displacement, 2, 16);
  const Surface surface(context);
  const CageInput input(cubeCage(), settings);
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  const Group group(context, {surface});
  size_t hits = 0;
  for (const RTCRayHit& ray : timedRays(random, 500)) {
    CbvhRayHit r;
    std::memcpy(&r, &ray, sizeof(r));
    if (!cbvhIntersect1(group, &r, nullptr)) continue;
    hits++;
    CbvhTriangle t;
    ASSERT_TRUE(cbvhFindTriangle(surface, r.ray.time, r.hit.primID, r.hit.u, r.hit.v, &r.hit.Ng_x, &t));
    const float Ng[3] = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, o[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z},
                d[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
    double height = 0, n = 0;
    for (int k = 0; k < 3; k++) {
      height += Ng[k] * (o[k] + double(r.ray.tfar) * d[k] - t.vertices[0][k]);
      n += double(Ng[k]) * Ng[k];
    }
    ASSERT_LT(std::fabs(height), 1e-5 * std::sqrt(n));
  }
  EXPECT_GT(hits, 100u);
  CbvhTriangle t;
  EXPECT_FALSE(cbvhFindTriangle(surface, 0, 77, 0.5f, 0.5f, nullptr, &t));
  size_t quads = 0;
  ASSERT_EQ(cbvhForEachPart(
                surface, 0.5f,
                [](void* sum, const CbvhPart* part) {
                  *(size_t*)sum += size_t(part->width - 1) * (part->height - 1);
                  return 1;
                },
                &quads),
            CBVH_OK);
  EXPECT_EQ(quads, 6u * 16 * 16);
}

// Groups use surfaces as of their last commit.
TEST(Capi, ReferencedObjectsStayAlive) {
  CbvhContext context = nullptr;
  ASSERT_EQ(cbvhNewContext("threads=1", nullptr, nullptr, &context), CBVH_OK);
  Displacement displacement;
  CbvhGroup group = nullptr;
  {
    const Surface surface(context);
    const CageInput input(cubeCage(), settingsOf(displacement, 1, 16));
    ASSERT_EQ(cbvhSetSurfaceCage(surface, &input.cage), CBVH_OK);
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
    const CbvhSurface handle = surface;
    ASSERT_EQ(cbvhNewGroup(context, &handle, 1, &group), CBVH_OK);
    ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK);
    EXPECT_EQ(cbvhGetGroupSurface(group, 0), handle);
    EXPECT_EQ(cbvhGetGroupSurface(group, 1), nullptr);
  }
  cbvhReleaseContext(context);
  float lower[3], upper[3];
  cbvhGetGroupBounds(group, lower, upper);
  EXPECT_LT(lower[0], -0.3f);
  EXPECT_GT(upper[2], 0.3f);
  CbvhRayHit ray = rayFromAbove();
  ray.hit.geomID = 17;
  ray.hit.instID = 18;
  EXPECT_TRUE(cbvhIntersect1(group, &ray, nullptr));
  EXPECT_EQ(ray.hit.geomID, 0u);
  EXPECT_EQ(ray.hit.instID, 18u);
  ray.ray.dir_z = 1;
  ray.ray.tfar = INFINITY;
  ray.hit.geomID = 17;
  EXPECT_FALSE(cbvhIntersect1(group, &ray, nullptr));
  EXPECT_EQ(ray.hit.geomID, 17u);
  int mine = 0;
  cbvhSetGroupUserPtr(group, &mine);
  EXPECT_EQ(cbvhGetGroupUserPtr(group), &mine);
  cbvhReleaseGroup(group);
}

// A surface may be set and committed while a thread traces a group that contains it: rays hit the group's last commit.
TEST(Capi, GroupsAreTracedWhileTheirSurfacesAreCommitted) {
  const Context context;
  const Surface surface(context);
  const CbvhCage centered = cube();
  float far[25];
  for (int i = 0; i < 25; i++) far[i] = cubeVertices[i] + 10;
  const float* const farSteps[] = {far};
  CbvhCage moved = cube();
  moved.vertices.steps = farSteps;
  ASSERT_EQ(cbvhSetSurfaceCage(surface, &centered), CBVH_OK);
  ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  const Group group(context, {surface});
  ASSERT_EQ(group.committed, CBVH_OK);

  const auto isHit = [&] {
    CbvhRayHit ray = rayFromAbove();
    return cbvhIntersect1(group, &ray, nullptr) != 0;
  };
  std::atomic<bool> isDone{false};
  std::atomic<size_t> misses{0}, rays{0};
  std::thread tracing([&] {
    while (!isDone) {
      misses += !isHit();
      rays++;
    }
  });
  for (int i = 0; i <= 100; i++) { // the last cage is `moved`
    EXPECT_EQ(cbvhSetSurfaceCage(surface, i % 2 ? &centered : &moved), CBVH_OK);
    EXPECT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK);
  }
  while (rays == 0) std::this_thread::yield();
  isDone = true;
  tracing.join();
  EXPECT_EQ(misses, 0u);
  EXPECT_TRUE(isHit());
  EXPECT_EQ(cbvhCommitGroup(group), CBVH_OK);
  EXPECT_FALSE(isHit()) << "the new commit is elsewhere";
}

}} // namespace programs::test
