// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Without compression our library behaves as Debian's libembree3-3: the same rays have the same IDs and misses, and
 * distances, u, v and normals that differ by rounding errors.
 *
 * A process cannot load two libraries of the same name. Therefore the program runs itself as `stock_equality --trace
 * CONFIG FILE` once for each library directory in LD_LIBRARY_PATH, and compares the results. */

#include "tracing/denormals.h"

#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>
#include <sys/wait.h>

namespace {

constexpr unsigned seed = 20180717;
constexpr unsigned numRays = 1 << 14; // per scene and query

// Upstream evaluates patches in code of its lowest ISA. If ours is not Debian's (SSE2), fused multiply-adds give
// different vertices: up to 38 ulps of distance were measured, at 1/8 of the largest coordinate.
constexpr uint32_t maxUlps = SAME_LOWEST_ISA ? 4 : 64;
// of u and v, and of normals relative to their length
constexpr double maxDifference = SAME_LOWEST_ISA ? 1e-5 : 1e-3;

// Upstream's intersectors of curves iterate. GCC, Debian's compiler, also fuses multiplications and additions of
// different statements there, clang only of the same: 5 ulps of distance and differences of 9.6e-5 were measured.
#if defined(__clang__)
constexpr uint32_t maxUlpsOfCurves = std::max(maxUlps, 16u);
constexpr double maxDifferenceOfCurves = std::max(maxDifference, 3e-4);
#else
constexpr uint32_t maxUlpsOfCurves = maxUlps;
constexpr double maxDifferenceOfCurves = maxDifference;
#endif

struct Vec {
  float x, y, z;
};
struct Vec4 {
  float x, y, z, w;
};

// The hit of a ray. `occluded` is the result of the any-hit query for the same ray.
struct Record {
  uint32_t geomID, primID, instID, occluded;
  float tfar, u, v, Ngx, Ngy, Ngz;
};

// --- scenes: all inside [-1.2,1.2]^3 ---------------------------------------------------

template<typename T>
T* buffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, const std::vector<T>& data) {
  void* memory = rtcSetNewGeometryBuffer(geometry, type, slot, format, sizeof(T), data.size());
  return static_cast<T*>(std::memcpy(memory, data.data(), data.size() * sizeof(T)));
}

unsigned attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  const unsigned id = rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return id;
}

// A sphere of 2n x n quads, row by row.
std::vector<Vec> spherePoints(unsigned n, float radius) {
  std::vector<Vec> points;
  for (unsigned j = 0; j <= n; j++)
    for (unsigned i = 0; i <= 2 * n; i++) {
      const float theta = float(M_PI) * j / n, phi = float(M_PI) * i / n;
      points.push_back({radius * std::sin(theta) * std::cos(phi), radius * std::cos(theta),
                        radius * std::sin(theta) * std::sin(phi)});
    }
  return points;
}

void addTriangles(RTCDevice device, RTCScene scene) {
  const unsigned n = 24;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::vector<unsigned> index;
  for (unsigned j = 0; j < n; j++)
    for (unsigned i = 0; i < 2 * n; i++) {
      const unsigned v = j * (2 * n + 1) + i, w = v + 2 * n + 1;
      for (unsigned k : {v, v + 1, w, w + 1, w, v + 1}) index.push_back(k);
    }
  buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, spherePoints(n, 0.7f));
  std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, index.size() / 3),
              index.data(), index.size() * sizeof(unsigned));
  attach(scene, geometry);
}

void addTriangleSoup(RTCDevice device, RTCScene scene, unsigned mask) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Vec> points;
  for (unsigned i = 0; i < 2000; i++) {
    const Vec p{uniform(random), uniform(random), uniform(random)};
    for (unsigned k = 0; k < 3; k++)
      points.push_back({p.x + 0.1f * uniform(random), p.y + 0.1f * uniform(random), p.z + 0.1f * uniform(random)});
  }
  std::vector<unsigned> index;
  for (unsigned i = 0; i < points.size(); i++) index.push_back(i);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, points);
  std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, index.size() / 3),
              index.data(), index.size() * sizeof(unsigned));
  rtcSetGeometryMask(geometry, mask);
  attach(scene, geometry);
}

void addQuads(RTCDevice device, RTCScene scene) {
  const unsigned n = 16;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  std::vector<unsigned> index;
  for (unsigned j = 0; j < n; j++)
    for (unsigned i = 0; i < 2 * n; i++) {
      const unsigned v = j * (2 * n + 1) + i, w = v + 2 * n + 1;
      for (unsigned k : {v, v + 1, w + 1, w}) index.push_back(k);
    }
  buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, spherePoints(n, 0.6f));
  std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, index.size() / 4),
              index.data(), index.size() * sizeof(unsigned));
  attach(scene, geometry);
}

void addGrid(RTCDevice device, RTCScene scene) {
  const unsigned n = 20;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
  buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, spherePoints(n, 0.65f));
  buffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID,
         std::vector<RTCGrid>{{0, 2 * n + 1, uint16_t(2 * n + 1), uint16_t(n + 1)}});
  attach(scene, geometry);
}

void addCurves(RTCDevice device, RTCScene scene, RTCGeometryType type) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-0.8f, 0.8f);
  std::vector<Vec4> points;
  std::vector<unsigned> index;
  for (unsigned i = 0; i < 100; i++) {
    index.push_back(4 * i);
    const Vec p{uniform(random), uniform(random), uniform(random)};
    for (unsigned k = 0; k < 4; k++)
      points.push_back({p.x + 0.3f * uniform(random), p.y + 0.2f * k - 0.3f, p.z + 0.3f * uniform(random), 0.02f});
  }
  RTCGeometry geometry = rtcNewGeometry(device, type);
  buffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, points);
  buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, index);
  attach(scene, geometry);
}

void displace(const RTCDisplacementFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    float &x = args->P_x[i], &y = args->P_y[i], &z = args->P_z[i];
    const float h = 0.05f * std::sin(11 * x) * std::cos(13 * y) * std::sin(9 * z + 1);
    x += h * args->Ng_x[i];
    y += h * args->Ng_y[i];
    z += h * args->Ng_z[i];
  }
}

// A cube with creases, whose faces are tessellated `rate` times along an edge.
void addSubdivision(RTCDevice device, RTCScene scene, float rate, bool displaced, unsigned timeSteps = 1) {
  std::vector<Vec> points;
  for (unsigned i = 0; i < 8; i++) points.push_back({i & 1 ? 0.8f : -0.8f, i & 2 ? 0.8f : -0.8f, i & 4 ? 0.8f : -0.8f});
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  rtcSetGeometryTimeStepCount(geometry, timeSteps);
  for (unsigned t = 0; t < timeSteps; t++) {
    for (Vec& p : points) p.x += 0.1f * t;
    buffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, points);
  }
  buffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, std::vector<unsigned>(6, 4));
  buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT,
         std::vector<unsigned>{0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6});
  struct Edge {
    unsigned a, b;
  };
  buffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2,
         std::vector<Edge>{{0, 1}, {1, 3}, {3, 2}, {2, 0}});
  buffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT,
         std::vector<float>{1.5f, 2, 0.5f, INFINITY});
  rtcSetGeometryTessellationRate(geometry, rate);
  if (displaced) rtcSetGeometryDisplacementFunction(geometry, displace);
  attach(scene, geometry);
}

// Rejects hits in every second eighth of u.
void filter(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++)
    if (args->valid[i] && int(8 * RTCHitN_u(args->hit, args->N, i)) % 2 == 0) args->valid[i] = 0;
}

void addInstances(RTCDevice device, RTCScene scene) {
  RTCScene inner = rtcNewScene(device);
  addTriangles(device, inner);
  addSubdivision(device, inner, 7, true);
  rtcCommitScene(inner);
  for (unsigned i = 0; i < 6; i++) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, inner);
    const float c = 0.4f * std::cos(i), s = 0.4f * std::sin(i);
    const float xfm[12] = {
        c, 0, s, 0, 0.4f, 0, -s, 0, c, 0.3f * (i % 3) - 0.3f, 0.6f * (i % 2) - 0.3f, 0.2f * i - 0.5f};
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, xfm);
    attach(scene, geometry);
  }
  rtcReleaseScene(inner);
}

using Build = std::function<void(RTCDevice, RTCScene)>;

const std::map<std::string, Build> scenes = {
    {"triangles",
     [](RTCDevice d, RTCScene s) {
       addTriangles(d, s);
       addTriangleSoup(d, s, ~0u);
     }},
    {"masked",
     [](RTCDevice d, RTCScene s) {
       addTriangleSoup(d, s, 2);
       addTriangles(d, s);
     }},
    {"robust",
     [](RTCDevice d, RTCScene s) {
       rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
       addTriangles(d, s);
       addQuads(d, s);
     }},
    {"dynamic",
     [](RTCDevice d, RTCScene s) {
       rtcSetSceneFlags(s, RTC_SCENE_FLAG_DYNAMIC);
       addTriangles(d, s);
       addTriangleSoup(d, s, ~0u);
     }},
    {"quads", [](RTCDevice d, RTCScene s) { addQuads(d, s); }},
    {"grid", [](RTCDevice d, RTCScene s) { addGrid(d, s); }},
    {"curves",
     [](RTCDevice d, RTCScene s) {
       addCurves(d, s, RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE);
       addCurves(d, s, RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE);
     }},
    {"instances", [](RTCDevice d, RTCScene s) { addInstances(d, s); }},
    {"subdivision", [](RTCDevice d, RTCScene s) { addSubdivision(d, s, 16, false); }},
    {"displaced", [](RTCDevice d, RTCScene s) { addSubdivision(d, s, 37, true); }},
    {"moving", [](RTCDevice d, RTCScene s) { addSubdivision(d, s, 8, true, 2); }},
    {"subdivisions",
     [](RTCDevice d, RTCScene s) {
       addSubdivision(d, s, 16, true);
       addSubdivision(d, s, 1, false);
       addTriangles(d, s);
     }},
    {"filtered",
     [](RTCDevice d, RTCScene s) {
       addSubdivision(d, s, 16, true);
       addTriangles(d, s);
       for (unsigned id : {0u, 1u}) {
         RTCGeometry geometry = rtcGetGeometry(s, id);
         rtcSetGeometryIntersectFilterFunction(geometry, filter);
         rtcSetGeometryOccludedFilterFunction(geometry, filter);
         rtcCommitGeometry(geometry);
       }
     }},
};

// --- queries ------------------------------------------------------------------------

std::vector<RTCRayHit> makeRays() {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<RTCRayHit> rays(numRays);
  for (unsigned i = 0; i < numRays; i++) {
    RTCRayHit& r = rays[i];
    std::memset(&r, 0, sizeof(r));
    const float x = normal(random), y = normal(random), z = normal(random),
                scale = 3 / std::sqrt(x * x + y * y + z * z);
    r.ray.org_x = scale * x;
    r.ray.org_y = scale * y;
    r.ray.org_z = scale * z;
    r.ray.dir_x = 0.5f * normal(random) - r.ray.org_x;
    r.ray.dir_y = 0.5f * normal(random) - r.ray.org_y;
    r.ray.dir_z = 0.5f * normal(random) - r.ray.org_z;
    r.ray.tnear = i % 5 == 0 ? 0.9f * uniform(random) : 0;
    r.ray.tfar = i % 7 == 0 ? 1 + uniform(random) : INFINITY;
    r.ray.time = uniform(random);
    r.ray.mask = i % 3 == 0 ? 1 : ~0u;
    r.ray.id = i;
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  return rays;
}

template<typename Packet, unsigned N, typename F> void packets(std::vector<RTCRayHit>& rays, F ask) {
  // All packet types consist of arrays of N, like RTCRayHitN.
  alignas(64) Packet packet;
  alignas(64) int valid[N];
  for (size_t i = 0; i + N <= rays.size(); i += N) {
    float* lanes = reinterpret_cast<float*>(&packet);
    constexpr unsigned words = sizeof(Packet) / sizeof(float) / N;
    for (unsigned k = 0; k < N; k++) {
      valid[k] = -1;
      for (unsigned w = 0; w < words; w++)
        std::memcpy(&lanes[w * N + k], reinterpret_cast<float*>(&rays[i + k]) + w, 4);
    }
    ask(valid, packet);
    for (unsigned k = 0; k < N; k++)
      for (unsigned w = 0; w < words; w++)
        std::memcpy(reinterpret_cast<float*>(&rays[i + k]) + w, &lanes[w * N + k], 4);
  }
}

using Query = std::function<void(RTCScene, std::vector<RTCRayHit>&, bool occluded)>;

const std::map<std::string, Query> queries = {
    {"1",
     [](RTCScene scene, std::vector<RTCRayHit>& rays, bool occluded) {
       RTCIntersectContext context;
       rtcInitIntersectContext(&context);
       for (RTCRayHit& r : rays)
         if (occluded) rtcOccluded1(scene, &context, &r.ray);
         else rtcIntersect1(scene, &context, &r);
     }},
#define PACKET(N) \
  {#N, [](RTCScene scene, std::vector<RTCRayHit>& rays, bool occluded) { \
     RTCIntersectContext context; \
     rtcInitIntersectContext(&context); \
     packets<RTCRayHit##N, N>(rays, [&](int* valid, RTCRayHit##N& p) { \
       if (occluded) rtcOccluded##N(valid, scene, &context, &p.ray); \
       else rtcIntersect##N(valid, scene, &context, &p); \
     }); \
   }}
    PACKET(4),
    PACKET(8),
    PACKET(16),
#undef PACKET
    {"stream",
     [](RTCScene scene, std::vector<RTCRayHit>& rays, bool occluded) {
       RTCIntersectContext context;
       rtcInitIntersectContext(&context);
       if (occluded) rtcOccluded1M(scene, &context, &rays[0].ray, rays.size(), sizeof(RTCRayHit));
       else rtcIntersect1M(scene, &context, rays.data(), rays.size(), sizeof(RTCRayHit));
     }},
};

// --- tracing process ------------------------------------------------------------------

void writeString(FILE* file, const std::string& s) {
  const uint32_t size = uint32_t(s.size());
  fwrite(&size, sizeof(size), 1, file);
  fwrite(s.data(), 1, size, file);
}

int trace(const char* config, const char* path) {
  const programs::FlushDenormals fast;
  RTCDevice device = rtcNewDevice(config);
  if (!device) return 2;
  FILE* file = fopen(path, "wb");
  if (!file) return 1;
  Dl_info info;
  dladdr(reinterpret_cast<void*>(&rtcNewDevice), &info);
  writeString(file, info.dli_fname);
  const std::vector<RTCRayHit> rays = makeRays();
  for (const auto& [sceneName, build] : scenes) {
    RTCScene scene = rtcNewScene(device);
    build(device, scene);
    rtcCommitScene(scene);
    for (const auto& [queryName, query] : queries) {
      std::vector<RTCRayHit> hits = rays, shadows = rays;
      query(scene, hits, false);
      query(scene, shadows, true);
      writeString(file, sceneName + ", rays of " + queryName);
      for (unsigned i = 0; i < numRays; i++) {
        const RTCHit& h = hits[i].hit;
        const Record record{h.geomID,
                            h.geomID == RTC_INVALID_GEOMETRY_ID ? 0 : h.primID,
                            h.instID[0],
                            shadows[i].ray.tfar < 0,
                            hits[i].ray.tfar,
                            h.u,
                            h.v,
                            h.Ng_x,
                            h.Ng_y,
                            h.Ng_z};
        fwrite(&record, sizeof(record), 1, file);
      }
    }
    rtcReleaseScene(scene);
  }
  const RTCError error = rtcGetDeviceError(device);
  rtcReleaseDevice(device);
  fclose(file);
  return error == RTC_ERROR_NONE ? 0 : 3;
}

// --- comparing process ------------------------------------------------------------------

struct Trace {
  std::string library;
  std::map<std::string, std::vector<Record>> records;
};

bool readString(FILE* file, std::string& s) {
  uint32_t size;
  if (fread(&size, sizeof(size), 1, file) != 1) return false;
  s.resize(size);
  return fread(&s[0], 1, size, file) == size;
}

// Returns the exit status of the tracing process; 2 if the device rejects the configuration.
int run(const std::string& directory, const std::string& config, Trace& result) {
  char self[4096] = {}, path[] = "/tmp/stock_equality_XXXXXX";
  if (readlink("/proc/self/exe", self, sizeof(self) - 1) < 0) return 1;
  close(mkstemp(path));
  const std::string command =
      "env -u EMBREE_CBVH LD_LIBRARY_PATH='" + directory + "' '" + self + "' --trace '" + config + "' " + path;
  const int status = WEXITSTATUS(std::system(command.c_str()));
  FILE* file = fopen(path, "rb");
  readString(file, result.library);
  for (std::string name; readString(file, name);) {
    std::vector<Record>& records = result.records[name];
    records.resize(numRays);
    if (fread(records.data(), sizeof(Record), numRays, file) != numRays) break;
  }
  fclose(file);
  unlink(path);
  return status;
}

// Difference of two floats with the same sign, in ulps.
uint32_t ulps(float a, float b) {
  int32_t i, j;
  std::memcpy(&i, &a, 4);
  std::memcpy(&j, &b, 4);
  return (i ^ j) < 0 ? (a == b ? 0 : ~0u) : uint32_t(std::abs(i - j));
}

class StockEquality : public testing::TestWithParam<std::string> {};

TEST_P(StockEquality, FindsTheSameHits) {
  Trace ours, stock;
  const std::string config = GetParam();
  const int status = run(OUR_LIBRARY_DIR, config, ours);
  if (status == 2) GTEST_SKIP() << "this machine does not support " << config;
  ASSERT_EQ(status, 0);
  ASSERT_EQ(run(STOCK_LIBRARY_DIR, config, stock), 0);
  ASSERT_NE(ours.library, stock.library);
  ASSERT_EQ(ours.records.size(), scenes.size() * queries.size());
  ASSERT_EQ(stock.records.size(), ours.records.size());
  std::printf("seed %u, %s against %s\n", seed, ours.library.c_str(), stock.library.c_str());

  for (const auto& [name, expected] : stock.records) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(ours.records.count(name));
    const std::vector<Record>& found = ours.records[name];
    unsigned hits = 0, different = 0;
    uint32_t worst = 0;
    double worstDifference = 0;
    for (unsigned i = 0; i < numRays; i++) {
      const Record &a = expected[i], &b = found[i];
      hits += a.geomID != RTC_INVALID_GEOMETRY_ID;
      if (a.geomID != b.geomID || a.primID != b.primID || a.instID != b.instID || a.occluded != b.occluded) {
        if (different++ < 3)
          ADD_FAILURE() << "ray " << i << ": geometry, primitive, instance, occluded " << b.geomID << " " << b.primID
                        << " " << b.instID << " " << b.occluded << " at " << b.tfar << ", expected " << a.geomID << " "
                        << a.primID << " " << a.instID << " " << a.occluded << " at " << a.tfar;
        continue;
      }
      worst = std::max(worst, ulps(a.tfar, b.tfar));
      if (a.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      const double length = std::hypot(a.Ngx, a.Ngy, a.Ngz);
      worstDifference = std::max({worstDifference, std::fabs(double(a.u) - b.u), std::fabs(double(a.v) - b.v),
                                  std::hypot(a.Ngx - b.Ngx, a.Ngy - b.Ngy, a.Ngz - b.Ngz) / length});
    }
    EXPECT_EQ(different, 0u);
    EXPECT_GT(hits, numRays / 20) << "too many rays miss the scene";
    const bool areCurves = name.rfind("curves", 0) == 0;
    EXPECT_LE(worst, areCurves ? maxUlpsOfCurves : maxUlps);
    EXPECT_LE(worstDifference, areCurves ? maxDifferenceOfCurves : maxDifference);
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, StockEquality, testing::Values(TEST_ISAS), [](const auto& info) {
  std::string name;
  for (char c : info.param)
    if (std::isalnum(c)) name += c;
  return name;
});

} // namespace

int main(int argc, char** argv) {
  if (argc == 4 && std::string(argv[1]) == "--trace") return trace(argv[2], argv[3]);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
