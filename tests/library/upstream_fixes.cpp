// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Defects of Embree 3.13.5 that our patches fix: invalid input is rejected, left out or clamped, where Embree reads or
 * writes out of bounds; packets and devices do not hang. */

#include "support/diced_mesh.h"
#include "support/memory.h"
#include "support/message_parts.h"
#include "support/query_forms.h"

#include <gtest/gtest.h>

#include <limits.h>
#include <malloc.h>
#include <mutex>
#include <sys/mman.h>
#include <thread>
#include <unistd.h>

namespace programs::test { namespace {

// Floats that end at an unreadable page.
class BeforeUnreadable {
public:
  explicit BeforeUnreadable(const std::vector<float>& data) {
    const size_t page = size_t(sysconf(_SC_PAGESIZE)), bytes = sizeof(float) * data.size(),
                 used = (bytes + page - 1) / page * page;
    size = used + page;
    memory = (char*)mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    mprotect(memory + used, page, PROT_NONE);
    values = (float*)(memory + used - bytes);
    std::memcpy(values, data.data(), bytes);
  }
  ~BeforeUnreadable() { munmap(memory, size); }
  BeforeUnreadable(const BeforeUnreadable&) = delete;
  BeforeUnreadable& operator=(const BeforeUnreadable&) = delete;

  float* values;

private:
  char* memory;
  size_t size;
};

TEST(UpstreamFixes, InvalidAndThinGridsHideNoOthers) {
  for (unsigned timeSteps : {1u, 2u}) {
    Device device;
    Diced diced = dicedSheet(2, 16);
    diced.motion = [](const Vec& p, unsigned) { return p; };
    const Scene alone(device), beside(device);
    attach(alone, newGrids(device, diced, RTC_COMPRESSION_NONE, 0, timeSteps));
    rtcCommitScene(alone);
    const std::vector<RTCGrid> good = diced.grids,
                               bad = {{0, 0x80000000u, 3, 3},  {0, 0x55555556u, 3, 4}, {50, 0xFFFFFFF0u, 3, 3},
                                      {0xFFFFFFFEu, 33, 3, 3}, {0, 33, 0, 5},          {0, 33, 5, 0},
                                      {0, 33, 1, 4},           {0, 33, 4, 1}};
    diced.grids.clear();
    for (const RTCGrid& grid : good) {
      diced.grids.insert(diced.grids.end(), bad.begin(), bad.end());
      diced.grids.push_back(grid);
    }
    attach(beside, newGrids(device, diced, RTC_COMPRESSION_NONE, 0, timeSteps));
    rtcCommitScene(beside);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    Random random(3);
    size_t hits = 0;
    for (const RTCRayHit& ray : raysAt(random, 500)) {
      const RTCRayHit a = intersect(alone, ray), b = intersect(beside, ray);
      ASSERT_EQ(a.ray.tfar, b.ray.tfar) << timeSteps << " time steps";
      hits += isHit(a);
    }
    EXPECT_GT(hits, 100u);
  }
}

TEST(UpstreamFixes, GridsWithTooManyVerticesAreErrors) {
  Device device;
  Diced diced;
  diced.add(40000, 2, [](unsigned x, unsigned y) { return Vec{float(x), float(y), 0}; });
  rtcReleaseGeometry(newGrids(device, diced, RTC_COMPRESSION_NONE));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"grid 0 ", "40000", " 2 ", "32767"}));
}

// At u = 1 and v = 1, where the last row and column end.
TEST(UpstreamFixes, InterpolationDoesNotReadAfterAGrid) {
  Device device;
  std::vector<float> positions;
  for (unsigned y = 0; y < 5; y++)
    for (unsigned x = 0; x < 7; x++) positions.insert(positions.end(), {float(x), float(2 * y), float(x * y), 9});
  const BeforeUnreadable vertices(positions);
  const RTCGrid grid = {0, 7, 7, 5};
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.values, 0, 16, 35);
  setBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, std::vector<RTCGrid>{grid});
  rtcCommitGeometry(geometry);
  for (float u : {0.0f, 0.5f, 1.0f})
    for (float v : {0.0f, 0.5f, 1.0f}) {
      float P[3], dPdu[3], dPdv[3];
      rtcInterpolate1(geometry, 0, u, v, RTC_BUFFER_TYPE_VERTEX, 0, P, dPdu, dPdv, 3);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_NEAR(P[0], 6 * u, 1e-4) << u << ", " << v;
      EXPECT_NEAR(P[1], 8 * v, 1e-4) << u << ", " << v;
      for (const float* d : {dPdu, dPdv})
        EXPECT_TRUE(std::isfinite(d[0]) && std::isfinite(d[1]) && std::isfinite(d[2]));
    }
  rtcReleaseGeometry(geometry);
}

TEST(UpstreamFixes, BuffersThatExceedTheirMemoryAreErrors) {
  Device device;
  RTCBuffer buffer = rtcNewBuffer(device, 1200);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const struct {
    size_t offset, stride, count;
    bool isValid;
  } cases[] = {{0, 12, 100, true},  {12, 24, 50, true},   {1188, 12, 1, true},   {0, 0, 100, true},
               {0, 12, 101, false}, {0, 12, 1000, false}, {5000, 12, 10, false}, {0, size_t(1) << 63, 2, false},
               {0, 24, 51, false},  {1200, 12, 1, false}};
  for (const auto& c : cases) {
    rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, c.offset, c.stride, c.count);
    EXPECT_EQ(device.takeError(), c.isValid ? RTC_ERROR_NONE : RTC_ERROR_INVALID_ARGUMENT)
        << c.offset << " + " << c.count << " * " << c.stride;
  }
  rtcReleaseGeometry(geometry);
  rtcReleaseBuffer(buffer);
  for (size_t less : {0, 1, 15, 30}) { // the allocated size would wrap around to a few bytes
    EXPECT_EQ(rtcNewBuffer(device, ~size_t(0) - less), nullptr);
    EXPECT_EQ(device.takeError(), RTC_ERROR_OUT_OF_MEMORY) << less;
  }
}

TEST(UpstreamFixes, FacesWithInvalidIndicesAreLeftOut) {
  for (unsigned timeSteps : {1u, 2u}) {
    const Cage cage = sheetCage(8);
    const unsigned numVertices = unsigned(cage.positions.size());
    std::vector<float> positions;
    for (const Vec& p : cage.positions) positions.insert(positions.end(), {p[0], p[1], p[2], 0});
    const BeforeUnreadable vertices(positions);
    for (unsigned index : {numVertices, numVertices + 100, ~0u}) {
      Device device;
      SurfaceSettings settings;
      settings.rate = 4;
      settings.timeSteps = timeSteps;
      RTCGeometry geometry = newSurface(device, cage, settings);
      for (unsigned t = 0; t < timeSteps; t++)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, vertices.values, 0, 16,
                                   numVertices);
      ((unsigned*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0))[1] = index;
      rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0);
      rtcCommitGeometry(geometry);
      Scene scene(device);
      attach(scene, geometry);
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      Random random(6);
      size_t hits = 0;
      for (const RTCRayHit& ray : raysAt(random, 500)) {
        const RTCRayHit hit = intersect(scene, ray);
        hits += isHit(hit);
        if (isHit(hit)) { ASSERT_NE(hit.hit.primID, 0u) << "vertex " << index; }
      }
      EXPECT_GT(hits, 100u);
    }
  }
}

// Embree kept the arrays by which it sorts half-edges, 32 bytes for each, which its memory monitor does not count, and
// rounded the number of half-edges up to a power of two.
TEST(UpstreamFixes, CommittedCagesKeepNoMemoryForSorting) {
  const Cage cage = sheetCage(100);
  const auto heapBytes = [] {
    const struct mallinfo2 info = mallinfo2();
    return ssize_t(info.uordblks + info.hblkhd);
  };
  Memory memory;
  Device device;
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  rtcReleaseGeometry(newSurface(device, sheetCage(2), {})); // first use of lists that the process keeps
  const ssize_t heap = heapBytes(), monitored = memory.live;
  const RTCGeometry geometry = newSurface(device, cage, {});
  EXPECT_GT(memory.live - monitored, ssize_t(32 * cage.indices.size())) << "the half-edges themselves";
  EXPECT_LT(memory.live - monitored, ssize_t(56 * cage.indices.size())) << "half-edges, buffers and tables";
  EXPECT_LT(heapBytes() - heap - (memory.live - monitored), ssize_t(8 * cage.indices.size()));
  rtcReleaseGeometry(geometry);
}

TEST(UpstreamFixes, BuffersShorterThanTheirCageAreErrors) {
  struct Case {
    std::vector<std::string> parts;
    std::function<void(Cage&, SurfaceSettings&)> change;
  } cases[] = {
      {{"face 5 ", " 5 vertices", " 24 indices"}, [](Cage& cage, SurfaceSettings&) { cage.faces[5] = 5; }},
      {{"face 0 ", " 4294967295 vertices", " 24 indices"}, [](Cage& cage, SurfaceSettings&) { cage.faces[0] = ~0u; }},
      {{" 23 levels", " 24"}, [](Cage&, SurfaceSettings& settings) { settings.edgeRates.assign(23, 4.0f); }},
      {{" 1 ", "edge crease", " 2"},
       [](Cage& cage, SurfaceSettings&) {
         cage.creases = {{0, 1}, {1, 3}};
         cage.creaseWeights = {1};
       }},
      {{" 0 ", "edge crease", " 1"}, [](Cage& cage, SurfaceSettings&) { cage.creases = {{0, 1}}; }},
      {{" 1 ", "vertex crease", " 3"}, [](Cage& cage, SurfaceSettings&) {
         cage.corners = {0, 1, 2};
         cage.cornerWeights = {1};
       }}};
  for (const Case& c : cases)
    for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT}) {
      Device device;
      Cage cage = cubeCage();
      SurfaceSettings settings;
      settings.compression = compression;
      c.change(cage, settings);
      rtcReleaseGeometry(newSurface(device, cage, settings));
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << device.message;
      EXPECT_TRUE(containsInOrder(device.message, c.parts)) << kindName(compression);
    }

  Device device;
  RTCGeometry geometry = newSurface(device, cubeCage(), SurfaceSettings());
  rtcSetGeometryTopologyCount(geometry, 2);
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 1, RTC_FORMAT_UINT, std::vector<unsigned>(20, 0));
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {" 20 indices", "topology 1", " 24"}));
  rtcReleaseGeometry(geometry);
  geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  rtcSetGeometryTopologyCount(geometry, 2);
  setBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cubeCage().faces);
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 1, RTC_FORMAT_UINT, cubeCage().indices);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"face 0 ", " 4 vertices", " 0 indices"}));
  rtcReleaseGeometry(geometry);
}

TEST(UpstreamFixes, MissingAttributesAreNotInterpolated) {
  Device device;
  Random random(1);
  const DicedMesh mesh = meshOf(dicedSheet(1, 8), QuadOrder::Rows, random);
  for (RTCGeometry geometry : {newSurface(device, cubeCage(), SurfaceSettings()), newGrids(device, dicedSheet(1, 8)),
                               newMesh(device, mesh), newMesh(device, trianglesOf(mesh))}) {
    float P[3];
    const unsigned primID = 0;
    const float u = 0.25f, v = 0.25f;
    rtcInterpolate0(geometry, primID, u, v, RTC_BUFFER_TYPE_VERTEX, 0, P, 3);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    for (const auto& [type, slot] :
         {std::make_pair(RTC_BUFFER_TYPE_VERTEX, 3u), std::make_pair(RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0u),
          std::make_pair(RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 1000000u)}) {
      rtcInterpolate0(geometry, primID, u, v, type, slot, P, 3);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << type << ", slot " << slot;
      RTCInterpolateNArguments args = {};
      args.geometry = geometry;
      args.primIDs = &primID;
      args.u = &u;
      args.v = &v;
      args.N = 1;
      args.bufferType = type;
      args.bufferSlot = slot;
      args.P = P;
      args.valueCount = 3;
      rtcInterpolateN(&args);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << type << ", slot " << slot;
    }
    rtcReleaseGeometry(geometry);
  }
}

// Nested scenes that exceed the depth of RTCPointQueryContext.
TEST(UpstreamFixes, PointQueriesStopAtMaximumInstanceDepth) {
  for (unsigned levels : {1u, 2u, 3u}) {
    Device device;
    Random random(1);
    std::vector<RTCScene> scenes = {rtcNewScene(device)};
    attach(scenes[0], newMesh(device, meshOf(dicedSheet(1, 8), QuadOrder::Rows, random)));
    rtcCommitScene(scenes[0]);
    for (unsigned level = 0; level < levels; level++) {
      RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(instance, scenes.back());
      const float identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
      rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, identity);
      rtcCommitGeometry(instance);
      scenes.push_back(rtcNewScene(device));
      attach(scenes.back(), instance);
      rtcCommitScene(scenes.back());
    }
    struct {
      RTCPointQueryContext context;
      unsigned char guard[1024];
    } guarded;
    std::memset(&guarded, 0xAB, sizeof(guarded));
    rtcInitPointQueryContext(&guarded.context);
    RTCPointQuery query = {};
    query.radius = 10;
    unsigned calls = 0;
    rtcPointQuery(
        scenes.back(), &query, &guarded.context,
        [](RTCPointQueryFunctionArguments* args) {
          ++*(unsigned*)args->userPtr;
          return false;
        },
        &calls);
    for (unsigned char byte : guarded.guard) ASSERT_EQ(byte, 0xAB) << levels << " levels";
    EXPECT_EQ(guarded.context.instStackSize, 0u);
    EXPECT_EQ(calls > 0, levels <= RTC_MAX_INSTANCE_LEVEL_COUNT) << levels << " levels";
    for (RTCScene scene : scenes) rtcReleaseScene(scene);
  }
}

// A low-quality tree of an application, with more children and larger leaves than the builder's arrays.
TEST(UpstreamFixes, MortonTreesRespectTheirLimits) {
  Device device;
  struct Counts {
    std::mutex mutex;
    size_t primitives = 0;
    unsigned children = 0, leaf = 0;
  };
  for (const auto& [branching, leaf] : {std::make_pair(2u, 1u), std::make_pair(9u, 4u), std::make_pair(64u, 8u),
                                        std::make_pair(4u, 33u), std::make_pair(8u, 1000u)}) {
    std::vector<RTCBuildPrimitive> primitives(5000);
    Random random(2);
    for (unsigned i = 0; i < primitives.size(); i++) {
      const float x = float(random.uniform(0, 1)), y = float(random.uniform(0, 1)), z = float(random.uniform(0, 1));
      primitives[i] = {x, y, z, 0, x + 0.01f, y + 0.01f, z + 0.01f, i};
    }
    Counts counts;
    RTCBVH bvh = rtcNewBVH(device);
    RTCBuildArguments args = rtcDefaultBuildArguments();
    args.buildQuality = RTC_BUILD_QUALITY_LOW;
    args.maxBranchingFactor = branching;
    args.minLeafSize = args.maxLeafSize = leaf;
    args.bvh = bvh;
    args.primitives = primitives.data();
    args.primitiveCount = args.primitiveArrayCapacity = primitives.size();
    args.userPtr = &counts;
    args.createNode = [](RTCThreadLocalAllocator allocator, unsigned n, void* ptr) -> void* {
      Counts& c = *(Counts*)ptr;
      std::lock_guard<std::mutex> lock(c.mutex);
      c.children = std::max(c.children, n);
      return rtcThreadLocalAlloc(allocator, 16, 16);
    };
    args.setNodeChildren = [](void*, void**, unsigned, void*) {};
    args.setNodeBounds = [](void*, const RTCBounds**, unsigned, void*) {};
    args.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive*, size_t n, void* ptr) -> void* {
      Counts& c = *(Counts*)ptr;
      std::lock_guard<std::mutex> lock(c.mutex);
      c.leaf = std::max(c.leaf, unsigned(n));
      c.primitives += n;
      return rtcThreadLocalAlloc(allocator, 16, 16);
    };
    EXPECT_NE(rtcBuildBVH(&args), nullptr) << device.message;
    EXPECT_EQ(counts.primitives, primitives.size());
    EXPECT_LE(counts.children, std::min(branching, 8u));
    EXPECT_LE(counts.leaf, std::min(leaf, 32u));
    rtcReleaseBVH(bvh);
  }
}

TEST(UpstreamFixes, NonFiniteTimeRangesAreErrors) {
  Device device;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [begin, end] : {std::make_pair(0.0f, inf), std::make_pair(-inf, 1.0f), std::make_pair(-3e38f, 3e38f),
                                   std::make_pair(nan, 1.0f), std::make_pair(0.0f, nan), std::make_pair(1.0f, 0.0f)}) {
    rtcSetGeometryTimeRange(geometry, begin, end);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT) << begin << " to " << end;
  }
  rtcSetGeometryTimeRange(geometry, -1e30f, 1e30f);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE);
  rtcReleaseGeometry(geometry);
}

// Moving cages with time ranges beyond those of rays: Embree read boxes of other patches, or out of bounds.
TEST(UpstreamFixes, MovingCagesAreTheSameOnEveryDevice) {
  const std::pair<float, float> ranges[] = {{0, 1}, {0.25f, 1.5f}, {-1, 2}, {-0.001f, 1}, {0.3f, 0.6f}, {-1, 0.5f}};
  for (const auto& [begin, end] : ranges)
    for (unsigned timeSteps : {2u, 3u, 5u}) {
      SCOPED_TRACE(testing::Message() << timeSteps << " steps from " << begin << " to " << end);
      SurfaceSettings settings;
      settings.rate = 3;
      settings.compression = RTC_COMPRESSION_NONE;
      settings.timeSteps = timeSteps;
      settings.begin = begin;
      settings.end = end;
      const auto trace = [&](bool hasOthers) {
        Device device("threads=1");
        Scene scene(device), other(device);
        if (hasOthers) { // memory with different contents
          SurfaceSettings far = settings;
          far.motion = [](const Vec& p, unsigned step) { return Vec{p[0] - 1000 * float(1 + step), p[1] + 500, p[2]}; };
          addSurface(device, other, sheetCage(9), far);
          rtcCommitScene(other);
          addSurface(device, scene, prismCage(6), settings);
          rtcCommitScene(scene);
          rtcDetachGeometry(scene, 0);
        }
        addSurface(device, scene, sheetCage(7), settings);
        rtcCommitScene(scene);
        Random random(5);
        std::vector<RTCRayHit> hits;
        for (RTCRayHit ray : raysAt(random, 300)) {
          ray.ray.time = float(random.uniform(0, 1));
          hits.push_back(intersect(scene, ray));
        }
        RTCLinearBounds bounds;
        rtcGetSceneLinearBounds(scene, &bounds);
        return std::make_pair(hits, bounds);
      };
      const auto [hits, bounds] = trace(false);
      const auto [others, otherBounds] = trace(true);
      size_t count = 0;
      for (size_t i = 0; i < hits.size(); i++) {
        count += isHit(hits[i]);
        ASSERT_EQ(hits[i].ray.tfar, others[i].ray.tfar);
        ASSERT_EQ(hits[i].hit.primID, others[i].hit.primID);
      }
      EXPECT_GT(count, 20u);
      EXPECT_EQ(bounds.bounds0.lower_x, otherBounds.bounds0.lower_x);
      EXPECT_EQ(bounds.bounds1.upper_z, otherBounds.bounds1.upper_z);
    }
}

// GCC before 14 stores 16 bits of a mask on the stack and reads back 64: the other 48 must not be zero by chance.
[[gnu::noinline]] void fillStack() {
  volatile unsigned char bytes[1 << 17];
  for (size_t i = 0; i < sizeof(bytes); i++) bytes[i] = 0xFF;
}

TEST(UpstreamFixes, CoherentOcclusionOfPacketsTerminates) {
  alarm(240);
  Device device;
  Random random(4);
  const DicedMesh mesh = meshOf(dicedSheet(2, 16), QuadOrder::Rows, random);
  for (RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_COMPACT, RTC_SCENE_FLAG_ROBUST})
    for (int type = 0; type < 4; type++) {
      RTCGeometry geometry = type == 0   ? newMesh(device, trianglesOf(mesh), RTC_COMPRESSION_NONE)
                             : type == 1 ? newMesh(device, mesh, RTC_COMPRESSION_NONE)
                             : type == 2 ? newGrids(device, dicedSheet(2, 16), RTC_COMPRESSION_NONE)
                                         : newSurface(device, cubeCage(), SurfaceSettings());
      Scene scene(device, flags), outer(device, flags);
      attach(scene, geometry);
      rtcCommitScene(scene);
      RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(instance, scene);
      rtcCommitGeometry(instance);
      attach(outer, instance);
      rtcCommitScene(outer);
      for (RTCScene traced : {RTCScene(scene), RTCScene(outer)}) {
        const std::vector<RTCRayHit> rays = raysAt(random, 64);
        for (size_t first = 0; first < rays.size(); first += 16) {
          RTCRay16 packet;
          alignas(64) int valid[16];
          for (size_t i = 0; i < 16; i++) {
            const RTCRay& r = rays[first + i].ray;
            valid[i] = -1;
            packet.org_x[i] = r.org_x;
            packet.org_y[i] = r.org_y;
            packet.org_z[i] = r.org_z;
            packet.dir_x[i] = r.dir_x;
            packet.dir_y[i] = r.dir_y;
            packet.dir_z[i] = r.dir_z;
            packet.tnear[i] = r.tnear;
            packet.tfar[i] = r.tfar;
            packet.time[i] = 0;
            packet.mask[i] = ~0u;
            packet.id[i] = unsigned(i);
            packet.flags[i] = 0;
          }
          RTCIntersectContext context;
          rtcInitIntersectContext(&context);
          context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
          fillStack();
          rtcOccluded16(valid, traced, &context, &packet);
          for (size_t i = 0; i < 16; i++)
            ASSERT_EQ(packet.tfar[i] < 0, occluded(traced, rays[first + i])) << type << ", flags " << flags;
        }
      }
    }
  alarm(0);
}

TEST(UpstreamFixes, DevicesThatStartTheirThreadsDoNotHang) {
  alarm(120);
  for (int i = 0; i < 100; i++)
    for (const char* config : {"start_threads=1", "start_threads=1,threads=1", "start_threads=1,threads=2"})
      rtcReleaseDevice(rtcNewDevice(config));
  alarm(0);
}

TEST(UpstreamFixes, MoreDevicesThanKeysOfPthreads) {
  std::vector<RTCDevice> devices;
  for (int i = 0; i < PTHREAD_KEYS_MAX + 100; i++) {
    devices.push_back(rtcNewDevice("threads=1"));
    ASSERT_TRUE(devices.back()) << i << ", error " << rtcGetDeviceError(nullptr);
  }
  for (RTCDevice device : devices) rtcReleaseDevice(device);
}

TEST(UpstreamFixes, ErrorsBelongToTheirDeviceAndThread) {
  const auto invalid = RTCDeviceProperty(12345);
  const RTCDevice devices[] = {rtcNewDevice("threads=1"), rtcNewDevice("threads=1")};
  for (int round = 0; round < 2; round++) {
    rtcGetDeviceProperty(devices[0], invalid);
    rtcNewBuffer(nullptr, 1);
    for (int i = 0; i < 3; i++)
      std::thread([&] {
        for (RTCDevice device : devices) EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_NONE);
        EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
        rtcGetDeviceProperty(devices[1], invalid);
        EXPECT_EQ(rtcGetDeviceError(devices[0]), RTC_ERROR_NONE);
        if (i == 2) return; // a later thread must not see the error
        EXPECT_EQ(rtcGetDeviceError(devices[1]), RTC_ERROR_INVALID_ARGUMENT);
      }).join();
    EXPECT_EQ(rtcGetDeviceError(devices[1]), RTC_ERROR_NONE);
    for (RTCDevice device : {devices[0], RTCDevice(nullptr)}) {
      EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_INVALID_ARGUMENT);
      EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_NONE);
    }
  }
  for (RTCDevice device : devices) rtcReleaseDevice(device);
}

}} // namespace programs::test
