// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/random.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <unistd.h>
#include <vector>

namespace programs::test {

using Vec = std::array<float, 3>;

// Stores the last error, and counts errors.
class Device {
public:
  explicit Device(const std::string& config = "") : device(rtcNewDevice(config.c_str())) {
    if (!device) return;
    rtcSetDeviceErrorFunction(
        device,
        [](void* self, RTCError error, const char* text) {
          ((Device*)self)->lastError = error;
          ((Device*)self)->message = text ? text : "";
          ((Device*)self)->errors++;
        },
        this);
  }
  ~Device() {
    if (device) rtcReleaseDevice(device);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  operator RTCDevice() const { return device; }
  explicit operator bool() const { return device != nullptr; }

  // Returns and clears the last error.
  RTCError takeError() {
    rtcGetDeviceError(device);
    return std::exchange(lastError, RTC_ERROR_NONE);
  }
  std::string message;
  unsigned errors = 0;

private:
  RTCDevice device;
  RTCError lastError = RTC_ERROR_NONE;
};

class Scene {
public:
  explicit Scene(RTCDevice device, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE) : scene(rtcNewScene(device)) {
    rtcSetSceneFlags(scene, flags);
  }
  ~Scene() { rtcReleaseScene(scene); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  operator RTCScene() const { return scene; }

private:
  RTCScene scene;
};

struct Cage {
  std::vector<Vec> positions;
  std::vector<unsigned> faces; // numbers of corners
  std::vector<unsigned> indices;
  std::vector<std::array<unsigned, 2>> creases;
  std::vector<float> creaseWeights;
  std::vector<unsigned> corners;
  std::vector<float> cornerWeights;
  std::vector<unsigned> holes;
  RTCSubdivisionMode mode = RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;

  void addFace(std::initializer_list<unsigned> face) {
    faces.push_back(unsigned(face.size()));
    indices.insert(indices.end(), face);
  }
};

inline Cage quadCage(float size = 1) {
  Cage cage;
  cage.positions = {{0, 0, 0}, {size, 0, 0}, {size, size, 0}, {0, size, 0}};
  cage.addFace({0, 1, 2, 3});
  cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  return cage;
}

inline Cage cubeCage() {
  Cage cage;
  for (int i = 0; i < 8; i++) cage.positions.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
  cage.addFace({0, 4, 6, 2});
  cage.addFace({1, 3, 7, 5});
  cage.addFace({0, 1, 5, 4});
  cage.addFace({2, 6, 7, 3});
  cage.addFace({0, 2, 3, 1});
  cage.addFace({4, 5, 7, 6});
  return cage;
}

// Closed: two caps of n vertices and n quads. n = 3 has triangles.
inline Cage prismCage(unsigned n) {
  Cage cage;
  for (unsigned k = 0; k < 2; k++)
    for (unsigned i = 0; i < n; i++) {
      const double a = 2 * M_PI * i / n;
      cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), k ? 0.8f : -0.8f});
    }
  cage.faces = {n, n};
  for (unsigned i = 0; i < n; i++) cage.indices.push_back(n - 1 - i);
  for (unsigned i = 0; i < n; i++) cage.indices.push_back(n + i);
  for (unsigned i = 0; i < n; i++) cage.addFace({i, (i + 1) % n, n + (i + 1) % n, n + i});
  return cage;
}

// Closed: 2 n quads, poles of valence n.
inline Cage trapezohedronCage(unsigned n) {
  Cage cage;
  for (unsigned i = 0; i < 2 * n; i++) {
    const double a = M_PI * i / n;
    cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), i & 1 ? -0.3f : 0.3f});
  }
  cage.positions.push_back({0, 0, 1});
  cage.positions.push_back({0, 0, -1});
  for (unsigned i = 0; i < n; i++) {
    const unsigned a = 2 * i, b = (2 * i + 1) % (2 * n), c = (2 * i + 2) % (2 * n), d = (2 * i + 3) % (2 * n);
    cage.addFace({2 * n, a, b, c});
    cage.addFace({2 * n + 1, d, c, b});
  }
  return cage;
}

// Open: n x n quads over [-1,1]^2, slightly bent.
inline Cage sheetCage(unsigned n) {
  Cage cage;
  for (unsigned y = 0; y <= n; y++)
    for (unsigned x = 0; x <= n; x++) {
      const float u = 2.f * x / n - 1, v = 2.f * y / n - 1;
      cage.positions.push_back({u, v, 0.2f * u * v});
    }
  for (unsigned y = 0; y < n; y++)
    for (unsigned x = 0; x < n; x++) {
      const unsigned i = y * (n + 1) + x;
      cage.addFace({i, i + 1, i + n + 2, i + n + 1});
    }
  return cage;
}

// Embree regards coordinates of at least 1.844e18 as not finite.
const float notFinite[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f,
                           -2e18f};

// P += scale * amplitude * field(frequency*(P - offset)/scale). It does not depend on the normal, so faces displace
// shared vertices the same way.
struct Displacement {
  float amplitude = 0.05f, frequency = 7;
  float scale = 1;
  Vec offset = {0, 0, 0};
  float lattice = 0;                                                  // if not 0, positions are multiples of it
  std::function<bool(unsigned primID, float u, float v)> poison = {}; // vertices that become one of notFinite

  static void apply(const RTCDisplacementFunctionNArguments* args) {
    const Displacement& d = *(const Displacement*)args->geometryUserPtr;
    for (unsigned i = 0; i < args->N; i++) {
      float* P[3] = {args->P_x + i, args->P_y + i, args->P_z + i};
      double p[3];
      for (int k = 0; k < 3; k++) p[k] = (double(*P[k]) - d.offset[k]) / d.scale * d.frequency;
      const double f[3] = {std::sin(p[0] + 2 * p[1]) * std::cos(p[2]), std::sin(p[1] - p[2]),
                           std::cos(p[2] + p[0]) * std::sin(p[1])};
      for (int k = 0; k < 3; k++) *P[k] = float(*P[k] + double(d.scale) * d.amplitude * f[k]);
      if (d.lattice > 0)
        for (int k = 0; k < 3; k++) *P[k] = std::nearbyint(*P[k] / d.lattice) * d.lattice;
      if (d.poison && d.poison(args->primID, args->u[i], args->v[i]))
        *P[i % 3] = notFinite[unsigned(97 * args->u[i] + 31 * args->v[i]) % 4];
    }
  }
};

// Letters and digits only, as GoogleTest requires.
inline const char* kindName(RTCCompression compression) {
  switch (compression) {
  case RTC_COMPRESSION_CGRID: return "cGRID";
  case RTC_COMPRESSION_CVOXEL: return "cVOXEL";
  case RTC_COMPRESSION_CLEAF: return "cLEAF";
  case RTC_COMPRESSION_CVERT: return "cVERT";
  case RTC_COMPRESSION_CTILE: return "cTILE";
  default: return "GRID";
  }
}

template<typename T>
void setBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, const std::vector<T>& data) {
  if (data.empty()) return;
  void* p = rtcSetNewGeometryBuffer(geometry, type, slot, format, sizeof(T), data.size());
  std::memcpy(p, data.data(), sizeof(T) * data.size());
  /* Embree reads 16 bytes of the last vertex, and its asserts require numbers. It allocates them. */
  if (type == RTC_BUFFER_TYPE_VERTEX) std::memset((char*)p + sizeof(T) * data.size(), 0, 4);
}

struct SurfaceSettings {
  float rate = 16;
  std::vector<float> edgeRates;         // one per index of the faces; overrides rate
  Displacement* displacement = nullptr; // must outlive the scene
  RTCCompression compression = RTC_COMPRESSION_INHERIT;
  int frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT;
  float maxError = 0;         // 0: the device's value; unused if compression and frameLevel are inherited
  bool fallbackFaces = false; // cLEAF: tests are about approximate leaves
  unsigned timeSteps = 1;
  // of the cage's vertices, before scale and offset; by default 0.1 along x per step
  std::function<Vec(const Vec& position, unsigned step)> motion;
  float begin = 0, end = 1; // times of the first and the last step
  unsigned mask = ~0u;
};

// Returns a committed geometry, which the caller releases.
inline RTCGeometry newSurface(RTCDevice device, const Cage& cage, const SurfaceSettings& settings) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  const float scale = settings.displacement ? settings.displacement->scale : 1;
  const Vec offset = settings.displacement ? settings.displacement->offset : Vec{0, 0, 0};
  rtcSetGeometryTimeStepCount(geometry, settings.timeSteps);
  if (settings.timeSteps > 1) rtcSetGeometryTimeRange(geometry, settings.begin, settings.end);
  for (unsigned t = 0; t < settings.timeSteps; t++) {
    std::vector<Vec> positions = cage.positions;
    for (Vec& p : positions) {
      if (settings.motion) p = settings.motion(p, t);
      else p[0] += 0.1f * float(t);
      for (int k = 0; k < 3; k++) p[k] = offset[k] + scale * p[k];
    }
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, positions);
  }
  setBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, cage.faces);
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, cage.indices);
  setBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, 0, RTC_FORMAT_UINT2, cage.creases);
  setBuffer(geometry, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, cage.creaseWeights);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, 0, RTC_FORMAT_UINT, cage.corners);
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, 0, RTC_FORMAT_FLOAT, cage.cornerWeights);
  setBuffer(geometry, RTC_BUFFER_TYPE_HOLE, 0, RTC_FORMAT_UINT, cage.holes);
  setBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, settings.edgeRates);
  rtcSetGeometrySubdivisionMode(geometry, 0, cage.mode);
  rtcSetGeometryTessellationRate(geometry, settings.rate);
  rtcSetGeometryMask(geometry, settings.mask);
  rtcSetGeometryUserData(geometry, settings.displacement);
  if (settings.displacement) rtcSetGeometryDisplacementFunction(geometry, Displacement::apply);
  if (settings.compression != RTC_COMPRESSION_INHERIT || settings.frameLevel != RTC_COMPRESSION_FRAME_LEVEL_INHERIT) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = settings.compression;
    args.frameLevel = settings.frameLevel;
    if (settings.maxError > 0) args.maxError = settings.maxError;
    args.fallbackFaces = settings.fallbackFaces;
    rtcSetGeometryCompression(geometry, &args);
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

// Also releases the geometry.
inline unsigned attach(RTCScene scene, RTCGeometry geometry) {
  const unsigned id = rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return id;
}

inline unsigned addSurface(RTCDevice device, RTCScene scene, const Cage& cage, const SurfaceSettings& settings) {
  return attach(scene, newSurface(device, cage, settings));
}

class SurfaceScene : public Scene {
public:
  SurfaceScene(RTCDevice device, const Cage& cage, const SurfaceSettings& settings) : Scene(device) {
    addSurface(device, *this, cage, settings);
    rtcCommitScene(*this);
  }
};

// The same surface as GRID, and compressed with the given settings.
struct Twins {
  Twins(RTCDevice device, const Cage& cage, const SurfaceSettings& settings)
    : grid(device, cage, uncompressed(settings)),
      scene(device, cage, settings) {}

  SurfaceScene grid, scene;

private:
  static SurfaceSettings uncompressed(SurfaceSettings settings) {
    settings.compression = RTC_COMPRESSION_NONE;
    return settings;
  }
};

// Largest size of a thread's cache, in bytes: it must fit into the second-level cache of a core.
inline size_t cacheLimit() { return size_t(sysconf(_SC_LEVEL2_CACHE_SIZE) >= 1024 * 1024 ? 1024 : 512) << 10; }

inline RTCCompressionStatistics statisticsOf(RTCScene scene) {
  RTCCompressionStatistics stats;
  std::memset((void*)&stats, 0xFF, sizeof(stats));
  stats.structSize = sizeof(stats);
  rtcGetSceneCompressionStatistics(scene, &stats);
  return stats;
}

// Differs between blocks and tiles of the same surfaces.
inline std::pair<uint64_t, uint64_t> nodeAndLeafBytes(RTCScene scene) {
  const RTCCompressionStatistics stats = statisticsOf(scene);
  return {stats.nodeBytes, stats.leafBytes};
}

inline RTCRayHit makeRay(const Vec& org, const Vec& dir, float tnear = 0,
                         float tfar = std::numeric_limits<float>::infinity()) {
  RTCRayHit r;
  std::memset(&r, 0, sizeof(r));
  r.ray.org_x = org[0];
  r.ray.org_y = org[1];
  r.ray.org_z = org[2];
  r.ray.dir_x = dir[0];
  r.ray.dir_y = dir[1];
  r.ray.dir_z = dir[2];
  r.ray.tnear = tnear;
  r.ray.tfar = tfar;
  r.ray.mask = ~0u;
  r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

// Rays from a sphere around the origin at points near the origin.
inline std::vector<RTCRayHit> raysAt(Random& random, unsigned count, float spread = 0.45f) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < count; i++) {
    double n[3], length = 0;
    for (double& x : n) {
      x = random.normal();
      length += x * x;
    }
    Vec o, d;
    for (int k = 0; k < 3; k++) {
      o[k] = float(4 * n[k] / std::sqrt(length));
      d[k] = float(spread * random.normal()) - o[k];
    }
    rays.push_back(makeRay(o, d));
  }
  return rays;
}

inline bool isHit(const RTCRayHit& r) { return r.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

inline RTCRayHit intersect(RTCScene scene, RTCRayHit ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
  return ray;
}

inline bool occluded(RTCScene scene, const RTCRayHit& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay r = ray.ray;
  rtcOccluded1(scene, &context, &r);
  return r.tfar < 0;
}

} // namespace programs::test
