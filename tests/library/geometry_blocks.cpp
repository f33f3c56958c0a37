// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Blocks belong to their geometry: they are built only if its surface changed, and scenes share them, each with its own
 * IDs. */

#include "support/memory.h"
#include "support/scene.h"

#include <atomic>
#include <sys/mman.h>

namespace programs::test { namespace {

struct CountedDisplacement : Displacement {
  std::atomic<size_t> vertices{0};

  static void apply(const RTCDisplacementFunctionNArguments* args) {
    ((CountedDisplacement*)(Displacement*)args->geometryUserPtr)->vertices += args->N;
    Displacement::apply(args);
  }
};

RTCGeometry newCounted(RTCDevice device, CountedDisplacement& displacement,
                       SurfaceSettings settings = SurfaceSettings()) {
  settings.displacement = &displacement;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  rtcSetGeometryDisplacementFunction(geometry, CountedDisplacement::apply);
  rtcCommitGeometry(geometry);
  return geometry;
}

void expectCommit(const Device& device, RTCScene scene) {
  rtcCommitScene(scene);
  EXPECT_EQ(const_cast<Device&>(device).takeError(), RTC_ERROR_NONE) << device.message;
}

const char* const kinds[] = {"vert", "leaf", "voxel", "grid"};

TEST(GeometryBlocks, OnlyChangedSurfacesAreBuilt) {
  for (const char* kind : kinds) {
    SCOPED_TRACE(kind);
    Device device(std::string("subdiv_accel=cbvh.") + kind);
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    CountedDisplacement displacements[3];
    RTCGeometry geometries[3];
    for (int i = 0; i < 3; i++) {
      displacements[i].offset = {4.f * i, 0, 0};
      geometries[i] = newCounted(device, displacements[i]);
      attach(scene, geometries[i]);
    }
    const auto built = [&] {
      for (auto& displacement : displacements) displacement.vertices = 0;
      expectCommit(device, scene);
      int mask = 0;
      for (int i = 0; i < 3; i++) mask |= (displacements[i].vertices != 0) << i;
      return mask;
    };
    EXPECT_EQ(built(), 7);
    const RTCRayHit down = makeRay({4, 0, 5}, {0, 0, -1});
    EXPECT_EQ(intersect(scene, down).hit.geomID, 1u);

    // visibility does not affect blocks
    rtcSetGeometryMask(geometries[1], 2);
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 0) << "mask";
    rtcSetGeometryIntersectFilterFunction(geometries[1],
                                          [](const RTCFilterFunctionNArguments* args) { args->valid[0] = 0; });
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 0) << "filter";
    EXPECT_FALSE(isHit(intersect(scene, down)));
    rtcSetGeometryIntersectFilterFunction(geometries[1], nullptr);
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 0);
    EXPECT_TRUE(isHit(intersect(scene, down)));
    rtcDisableGeometry(geometries[1]);
    EXPECT_EQ(built(), 0) << "disabled";
    EXPECT_FALSE(isHit(intersect(scene, down)));
    rtcEnableGeometry(geometries[1]);
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 0) << "enabled";
    EXPECT_TRUE(isHit(intersect(scene, down)));

    // the surface itself changes
    float* x = (float*)rtcGetGeometryBufferData(geometries[1], RTC_BUFFER_TYPE_VERTEX, 0);
    const float before = intersect(scene, down).ray.tfar;
    for (int i = 0; i < 8; i++) x[3 * i + 2] *= 2;
    rtcUpdateGeometryBuffer(geometries[1], RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 2) << "vertices";
    EXPECT_LT(intersect(scene, down).ray.tfar, before - 0.2f);
    rtcSetGeometryTessellationRate(geometries[2], 32);
    rtcCommitGeometry(geometries[2]);
    EXPECT_EQ(built(), 4) << "rate";
    rtcSetGeometryUserData(geometries[0], &displacements[0]);
    rtcSetGeometryMask(geometries[0], 2);
    rtcCommitGeometry(geometries[0]);
    EXPECT_EQ(built(), 1) << "user data is passed to displacement functions";
    rtcCommitGeometry(geometries[0]);
    EXPECT_EQ(built(), 1) << "the displacement function may behave differently";
    rtcEnableGeometry(geometries[0]);
    rtcCommitGeometry(geometries[0]);
    EXPECT_EQ(built(), 1) << "enabling an enabled geometry is no change";
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.maxError = 0.001f;
    rtcSetGeometryCompression(geometries[2], &args);
    rtcCommitGeometry(geometries[2]);
    EXPECT_EQ(built(), 4) << "settings";
    const std::vector<std::array<unsigned, 2>> creases = {{0, 1}};
    const std::vector<float> weights = {5};
    setBuffer(geometries[1], RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, creases);
    setBuffer(geometries[1], RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, weights);
    rtcSetGeometryMask(geometries[1], 4);
    rtcCommitGeometry(geometries[1]);
    EXPECT_EQ(built(), 2) << "creases and a mask changed";
    rtcDetachGeometry(scene, 0);
    EXPECT_EQ(built(), 0) << "detached";
    EXPECT_FALSE(isHit(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1}))));
    EXPECT_TRUE(isHit(intersect(scene, makeRay({8, 0, 5}, {0, 0, -1}))));
    rtcRetainGeometry(geometries[1]);
    rtcDetachGeometry(scene, 1);
    rtcAttachGeometryByID(scene, geometries[1], 0);
    rtcReleaseGeometry(geometries[1]);
    EXPECT_EQ(built(), 0) << "attached under another ID";
    EXPECT_EQ(intersect(scene, down).hit.geomID, 0u);
  }
}

TEST(GeometryBlocks, ScenesShareBlocksUnderTheirOwnIDs) {
  for (const char* kind : kinds)
    for (bool requestsCompression : {true, false}) {
      SCOPED_TRACE(testing::Message() << kind << ", " << requestsCompression);
      Memory memory;
      Device device(std::string("subdiv_accel=cbvh.") + kind);
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      CountedDisplacement displacement, other;
      SurfaceSettings settings;
      settings.rate = 64;
      settings.compression = requestsCompression ? RTC_COMPRESSION_INHERIT : RTC_COMPRESSION_NONE;
      RTCGeometry shared = newCounted(device, displacement, settings);
      Scene first(device);
      rtcAttachGeometryByID(first, shared, 7);
      other.offset = {4, 0, 0};
      RTCGeometry another = newCounted(device, other);
      rtcAttachGeometryByID(first, another, 0); // a compressed geometry
      expectCommit(device, first);
      const ssize_t live = memory.live;
      displacement.vertices = other.vertices = 0;
      {
        Scene second(device);
        rtcAttachGeometryByID(second, shared, 2);
        rtcAttachGeometryByID(second, another, 7);
        expectCommit(device, second);
        EXPECT_EQ(displacement.vertices, 0u);
        EXPECT_EQ(other.vertices, 0u);
        EXPECT_LT(memory.live, live + 16 * 1024);
        rtcReleaseGeometry(shared);
        rtcReleaseGeometry(another);
        Random random(3);
        unsigned hits = 0;
        for (const RTCRayHit& ray : raysAt(random, 500)) {
          const RTCRayHit a = intersect(first, ray), b = intersect(second, ray);
          ASSERT_EQ(isHit(a), isHit(b));
          ASSERT_EQ(occluded(second, ray), isHit(b));
          if (!isHit(a)) continue;
          hits++;
          ASSERT_EQ(a.ray.tfar, b.ray.tfar);
          ASSERT_EQ(a.hit.primID, b.hit.primID);
          ASSERT_TRUE((a.hit.geomID == 7 && b.hit.geomID == 2) || (a.hit.geomID == 0 && b.hit.geomID == 7))
              << a.hit.geomID << " " << b.hit.geomID;
        }
        EXPECT_GT(hits, 200u);
        EXPECT_EQ(statisticsOf(first).numQuads, statisticsOf(second).numQuads);
        rtcDetachGeometry(first, 7);
        expectCommit(device, first);
        EXPECT_EQ(intersect(second, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 2u)
            << "the first scene no longer contains it";
        EXPECT_FALSE(isHit(intersect(first, makeRay({0, 0, 5}, {0, 0, -1}))));
      }
      EXPECT_LT(memory.live, live / 2) << "no scene contains it any longer";
    }
}

// For coincident surfaces, independently of the order of creation.
TEST(GeometryBlocks, LowerIDInTheSceneWins) {
  for (const char* kind : kinds) {
    SCOPED_TRACE(kind);
    Device device(std::string("subdiv_accel=cbvh.") + kind);
    RTCGeometry a = newSurface(device, cubeCage(), SurfaceSettings()),
                b = newSurface(device, cubeCage(), SurfaceSettings());
    Scene one(device), other(device), twice(device);
    rtcAttachGeometryByID(one, a, 3);
    rtcAttachGeometryByID(one, b, 5);
    rtcAttachGeometryByID(other, a, 5);
    rtcAttachGeometryByID(other, b, 3);
    rtcAttachGeometryByID(twice, a, 5);
    rtcAttachGeometryByID(twice, a, 3);
    rtcReleaseGeometry(a);
    rtcReleaseGeometry(b);
    expectCommit(device, one);
    expectCommit(device, other);
    expectCommit(device, twice);
    const bool isEither = std::string(kind) == "grid"; // as in Embree
    Random random(4);
    size_t hits = 0;
    for (const RTCRayHit& ray : raysAt(random, 300))
      for (RTCScene scene : {RTCScene(one), RTCScene(other), RTCScene(twice)}) {
        const RTCRayHit hit = intersect(scene, ray);
        if (!isHit(hit)) continue;
        hits++;
        ASSERT_TRUE(hit.hit.geomID == 3 || (isEither && hit.hit.geomID == 5)) << hit.hit.geomID;
      }
    EXPECT_GT(hits, 300u);
  }
}

TEST(GeometryBlocks, InstancedScenesShareBlocks) {
  Device device("subdiv_accel=cbvh.vert");
  RTCGeometry geometry = newSurface(device, cubeCage(), SurfaceSettings());
  Scene below(device), above(device);
  rtcAttachGeometryByID(below, geometry, 9);
  expectCommit(device, below);
  rtcAttachGeometryByID(above, geometry, 1);
  rtcReleaseGeometry(geometry);
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, below);
  const float transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 4, 0, 0};
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(instance);
  rtcAttachGeometryByID(above, instance, 4);
  rtcReleaseGeometry(instance);
  expectCommit(device, above);
  EXPECT_EQ(intersect(above, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 1u);
  const RTCRayHit hit = intersect(above, makeRay({4, 0, 5}, {0, 0, -1}));
  EXPECT_EQ(hit.hit.geomID, 9u);
  EXPECT_EQ(hit.hit.instID[0], 4u);
}

TEST(GeometryBlocks, IDsAreCorrectInScenesThatStopCompressing) {
  Device device;
  CountedDisplacement displacement;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  RTCGeometry geometry = newCounted(device, displacement);
  rtcAttachGeometryByID(scene, geometry, 6);
  for (RTCCompression kind :
       {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_NONE, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_NONE}) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = kind;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    expectCommit(device, scene);
    EXPECT_EQ(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 6u);
  }
  rtcReleaseGeometry(geometry);
}

// Surfaces with motion blur, compressed and as Embree's GRID, next to other geometries.
TEST(GeometryBlocks, MotionBlurNextToOthersKeepsIDs) {
  for (RTCCompression still : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT})
    for (RTCCompression first : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT})
      for (RTCCompression second : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT}) {
        Device device;
        Scene scene(device);
        unsigned id = 3;
        for (RTCCompression compression : {still, first, second}) {
          Displacement displacement;
          displacement.offset = {4.0f * float(id - 3), 0, 0};
          displacement.amplitude = 0;
          SurfaceSettings settings;
          settings.displacement = &displacement;
          settings.compression = compression;
          settings.timeSteps = id == 3 ? 1 : 2;
          RTCGeometry geometry = newSurface(device, cubeCage(), settings);
          rtcSetGeometryDisplacementFunction(geometry, nullptr);
          rtcCommitGeometry(geometry);
          rtcAttachGeometryByID(scene, geometry, id++);
          rtcReleaseGeometry(geometry);
        }
        expectCommit(device, scene);
        for (unsigned i = 0; i < 3; i++)
          EXPECT_EQ(intersect(scene, makeRay({4.0f * float(i), 0, 5}, {0, 0, -1})).hit.geomID, 3 + i)
              << still << first << second;
      }
}

TEST(GeometryBlocks, MotionBlurByTheDeviceKeepsIDs) {
  Device device("subdiv_accel=cbvh.vert");
  Displacement displacement;
  displacement.offset = {4, 0, 0};
  SurfaceSettings moving;
  moving.displacement = &displacement;
  moving.timeSteps = 2;
  Scene scene(device);
  RTCGeometry a = newSurface(device, cubeCage(), SurfaceSettings()), b = newSurface(device, cubeCage(), moving);
  rtcAttachGeometryByID(scene, a, 3);
  rtcAttachGeometryByID(scene, b, 8);
  rtcReleaseGeometry(a);
  rtcReleaseGeometry(b);
  expectCommit(device, scene);
  EXPECT_EQ(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 3u);
  EXPECT_EQ(intersect(scene, makeRay({4, 0, 5}, {0, 0, -1})).hit.geomID, 8u);
}

// --- released input -----------------------------------------------------------------------------

// Memory of the application; accesses after its release crash.
class Mapped {
public:
  template<typename T>
  explicit Mapped(const std::vector<T>& data) : bytes(sizeof(T) * data.size() + 16) {
    memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    std::memcpy(memory, data.data(), sizeof(T) * data.size());
  }
  ~Mapped() { munmap(memory, bytes); }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;

  void* memory;

private:
  size_t bytes;
};

struct Progress {
  std::atomic<unsigned> calls{0};
  std::atomic<bool> cancels{false};

  static bool monitor(void* self, double n) {
    Progress& p = *(Progress*)self;
    EXPECT_GE(n, 0);
    EXPECT_LE(n, 1);
    p.calls++;
    return !p.cancels;
  }
};

void askForRelease(RTCGeometry geometry, Progress* progress = nullptr) {
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
  args.progress = progress ? Progress::monitor : nullptr;
  args.progressUserPtr = progress;
  rtcSetGeometryCompression(geometry, &args);
}

// A committed geometry whose cage is in released memory. attribute: 8 numbers and padding for
// reads of four, or NULL.
RTCGeometry newReleased(Device& device, Displacement& displacement, const float* attribute) {
  const Cage cage = cubeCage();
  const Mapped vertices(cage.positions), faces(cage.faces), indices(cage.indices),
      levels(std::vector<float>(24, 20.0f));
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.memory, 0, sizeof(Vec),
                             cage.positions.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, faces.memory, 0, 4, cage.faces.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices.memory, 0, 4,
                             cage.indices.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, levels.memory, 0, 4, 24);
  if (attribute) {
    rtcSetGeometryVertexAttributeCount(geometry, 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT, attribute, 0, 4, 8);
  }
  rtcSetGeometryUserData(geometry, &displacement);
  rtcSetGeometryDisplacementFunction(geometry, Displacement::apply);
  askForRelease(geometry);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  return geometry;
}

TEST(ReleasedInput, IsNotReadAgain) {
  for (const char* kind : kinds)
    for (bool hasAttribute : {false, true}) {
      SCOPED_TRACE(testing::Message() << kind << ", " << hasAttribute);
      Device device(std::string("subdiv_accel=cbvh.") + kind);
      Displacement displacement;
      // padded, because Embree reads four floats at a time
      const std::vector<float> attribute = {0, 1, 2, 3, 4, 5, 6, 7, 7, 7, 7, 7};
      RTCGeometry geometry = newReleased(device, displacement, hasAttribute ? attribute.data() : nullptr);
      SurfaceSettings settings;
      settings.rate = 20;
      settings.fallbackFaces = true;
      settings.displacement = &displacement;
      const SurfaceScene kept(device, cubeCage(), settings);
      Scene scene(device), other(device, RTC_SCENE_FLAG_DYNAMIC);
      rtcAttachGeometryByID(scene, geometry, 5);
      rtcAttachGeometryByID(other, geometry, 0);
      expectCommit(device, scene);
      expectCommit(device, other);
      Random random(5);
      unsigned hits = 0;
      for (const RTCRayHit& ray : raysAt(random, 500)) {
        const RTCRayHit a = intersect(kept, ray), b = intersect(scene, ray);
        ASSERT_EQ(isHit(a), isHit(b));
        if (!isHit(a)) continue;
        hits++;
        ASSERT_EQ(a.ray.tfar, b.ray.tfar);
        ASSERT_EQ(b.hit.geomID, 5u);
        ASSERT_EQ(a.hit.u, b.hit.u);
      }
      EXPECT_GT(hits, 100u);
      rtcSetGeometryMask(geometry, 2);
      rtcCommitGeometry(geometry);
      expectCommit(device, other);
      EXPECT_EQ(intersect(other, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 0u);
      float value = -1;
      if (hasAttribute) {
        rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, &value, 1);
        EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
        EXPECT_GT(value, 0);
      }
      // operations that need it
      rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, &value, 1);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
      rtcSetGeometryTessellationRate(geometry, 8);
      rtcCommitGeometry(geometry);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
      EXPECT_NE(device.message.find("RTC_COMPRESSION_FLAG_RELEASE_INPUT"), std::string::npos) << device.message;
      // replaces all input
      const Cage cage = prismCage(5);
      setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, cage.positions);
      setBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cage.faces);
      setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cage.indices);
      if (hasAttribute) rtcSetGeometryVertexAttributeCount(geometry, 0);
      rtcCommitGeometry(geometry);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      expectCommit(device, other);
      EXPECT_EQ(statisticsOf(other).numQuads, 5u * 64 + 10 * 16);
      rtcReleaseGeometry(geometry);
    }
}

TEST(ReleasedInput, IsKeptIfCommitIsCancelled) {
  Device device("subdiv_accel=cbvh.vert");
  Progress progress;
  Displacement displacement;
  SurfaceSettings settings;
  settings.rate = 64;
  settings.displacement = &displacement;
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  askForRelease(geometry, &progress);
  progress.cancels = true;
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_CANCELLED);
  EXPECT_GT(progress.calls, 0u);
  progress.cancels = false;
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  Scene scene(device);
  attach(scene, geometry);
  expectCommit(device, scene);
  EXPECT_EQ(statisticsOf(scene).numQuads, 6u * 64 * 64);
}

// Memory is limited to growing amounts: nothing leaks when it is refused.
TEST(ReleasedInput, IsKeptIfOutOfMemory) {
  for (const char* kind : kinds) {
    SCOPED_TRACE(kind);
    Memory memory;
    {
      Device device(std::string("subdiv_accel=cbvh.") + kind);
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      Displacement displacement;
      SurfaceSettings settings;
      settings.rate = 64;
      settings.displacement = &displacement;
      RTCGeometry geometry = newSurface(device, cubeCage(), settings);
      askForRelease(geometry);
      const ssize_t before = memory.live;
      unsigned refused = 0;
      for (ssize_t more = 1000;; more += more / 4) {
        memory.most = before + more;
        rtcCommitGeometry(geometry);
        const RTCError error = device.takeError();
        if (error == RTC_ERROR_NONE) break;
        ASSERT_EQ(error, RTC_ERROR_OUT_OF_MEMORY) << device.message;
        // half-edges are kept, blocks are not
        EXPECT_LT(memory.live, before + 20000) << more;
        refused++;
      }
      EXPECT_GT(refused, 10u);
      memory.most = std::numeric_limits<ssize_t>::max();
      Scene scene(device);
      attach(scene, geometry);
      expectCommit(device, scene);
      EXPECT_EQ(statisticsOf(scene).numQuads, 6u * 64 * 64);
      EXPECT_EQ(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 0u);
    }
    EXPECT_EQ(memory.live, 0);
  }
}

TEST(ReleasedInput, StaysIfNothingIsCompressed) {
  Device device;
  Cage cage = cubeCage();
  cage.positions.push_back({0, 0, 0}); // Embree reads one float after the last one that it uses
  RTCGeometry geometry = newSurface(device, cage, SurfaceSettings());
  askForRelease(geometry);
  rtcCommitGeometry(geometry);
  float p[3];
  rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, p, 3);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  rtcReleaseGeometry(geometry);
}

TEST(ReleasedInput, UnknownFlagsAreRejected) {
  Device device;
  RTCGeometry geometry = newSurface(device, cubeCage(), SurfaceSettings());
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.flags = 6;
  rtcSetGeometryCompression(geometry, &args);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  rtcReleaseGeometry(geometry);
}

}} // namespace programs::test
