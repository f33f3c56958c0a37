// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A foreign Embree, 3.13 or 4 depending on the include path, with a displaced cube. Requires only a compiler, Embree
 * and our headers. */

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <cbvh/embree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <vector>

namespace host {

using Vec = std::array<float, 3>;

// --- failures ----------------------------------------------------------------------------------

inline unsigned failures = 0;
#define CHECK(condition) \
  do { \
    if (!(condition) && host::failures++ < 20) \
      std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
  } while (0)
#define OK(call) \
  do { \
    const CbvhError error = (call); \
    if (error != CBVH_OK) { \
      host::failures++; \
      std::fprintf(stderr, "%s:%d: error %d: %s\n", __FILE__, __LINE__, int(error), cbvhGetErrorText()); \
    } \
  } while (0)

inline int conclude(const char* what) {
  if (failures == 0) std::printf("passed: %s next to Embree %s\n", what, RTC_VERSION_STRING);
  return failures ? 1 : 0;
}

// --- queries of both versions of Embree ---------------------------------------------------------

struct Query {
  bool isCoherent = false;
  RTCFilterFunctionN filter = nullptr;
};

#if RTC_VERSION_MAJOR >= 4
struct Arguments {
  CbvhFilterContext context;
  RTCIntersectArguments intersect;
  RTCOccludedArguments occluded;

  explicit Arguments(const Query& query) {
    rtcInitRayQueryContext(&context.context);
    context.filter = query.filter;
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    intersect.context = occluded.context = &context.context;
    if (query.isCoherent) intersect.flags = occluded.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  }
};
inline void intersect(RTCScene scene, RTCRayHit& ray, const Query& query = {}) {
  Arguments a(query);
  rtcIntersect1(scene, &ray, &a.intersect);
}
inline void occluded(RTCScene scene, RTCRay& ray, const Query& query = {}) {
  Arguments a(query);
  rtcOccluded1(scene, &ray, &a.occluded);
}
#define HOST_PACKET(N) \
  inline void intersect(const int* valid, RTCScene scene, RTCRayHit##N& rays, const Query& query = {}) { \
    Arguments a(query); \
    rtcIntersect##N(valid, scene, &rays, &a.intersect); \
  } \
  inline void occluded(const int* valid, RTCScene scene, RTCRay##N& rays, const Query& query = {}) { \
    Arguments a(query); \
    rtcOccluded##N(valid, scene, &rays, &a.occluded); \
  }
constexpr unsigned contextFilters = CBVH_GEOMETRY_FLAG_CONTEXT_FILTERS;
#else
struct Arguments {
  RTCIntersectContext context;

  explicit Arguments(const Query& query) {
    rtcInitIntersectContext(&context);
    context.filter = query.filter;
    if (query.isCoherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
};
inline void intersect(RTCScene scene, RTCRayHit& ray, const Query& query = {}) {
  Arguments a(query);
  rtcIntersect1(scene, &a.context, &ray);
}
inline void occluded(RTCScene scene, RTCRay& ray, const Query& query = {}) {
  Arguments a(query);
  rtcOccluded1(scene, &a.context, &ray);
}
#define HOST_PACKET(N) \
  inline void intersect(const int* valid, RTCScene scene, RTCRayHit##N& rays, const Query& query = {}) { \
    Arguments a(query); \
    rtcIntersect##N(valid, scene, &a.context, &rays); \
  } \
  inline void occluded(const int* valid, RTCScene scene, RTCRay##N& rays, const Query& query = {}) { \
    Arguments a(query); \
    rtcOccluded##N(valid, scene, &a.context, &rays); \
  }
constexpr unsigned contextFilters = CBVH_GEOMETRY_FLAG_FILTERS;
#endif
HOST_PACKET(4)
HOST_PACKET(8)
HOST_PACKET(16)

template<unsigned N> struct Packet;
template<> struct Packet<4> {
  typedef RTCRayHit4 RayHits;
  typedef RTCRay4 Rays;
};
template<> struct Packet<8> {
  typedef RTCRayHit8 RayHits;
  typedef RTCRay8 Rays;
};
template<> struct Packet<16> {
  typedef RTCRayHit16 RayHits;
  typedef RTCRay16 Rays;
};

// RTCRayN and RTCHitN are arrays of words. The members of an RTCHit before instID are 7 words.
using Word = unsigned int __attribute__((may_alias));
constexpr unsigned rayWords = 12;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
constexpr unsigned hitWords = 7 + 2 * RTC_MAX_INSTANCE_LEVEL_COUNT;
#else
constexpr unsigned hitWords = 7 + RTC_MAX_INSTANCE_LEVEL_COUNT;
#endif
// Sets ray i of a packet of N.
inline void setRay(void* packet, unsigned N, unsigned i, const RTCRayHit& ray) {
  const auto copy = [&](unsigned first, const void* from, unsigned count) {
    for (unsigned word = 0; word < count; word++) ((Word*)packet)[(first + word) * N + i] = ((const Word*)from)[word];
  };
  copy(0, &ray.ray, rayWords);
  copy(rayWords, &ray.hit, hitWords);
}

// --- rays ----------------------------------------------------------------------------------------

inline RTCRayHit makeRay(const Vec& org, const Vec& dir, float time = 0) {
  RTCRayHit r;
  std::memset(&r, 0, sizeof(r));
  r.ray.org_x = org[0];
  r.ray.org_y = org[1];
  r.ray.org_z = org[2];
  r.ray.dir_x = dir[0];
  r.ray.dir_y = dir[1];
  r.ray.dir_z = dir[2];
  r.ray.time = time;
  r.ray.tfar = INFINITY;
  r.ray.mask = ~0u;
  r.hit.geomID = r.hit.primID = RTC_INVALID_GEOMETRY_ID;
  for (unsigned& id : r.hit.instID) id = RTC_INVALID_GEOMETRY_ID;
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  for (unsigned& id : r.hit.instPrimID) id = RTC_INVALID_GEOMETRY_ID;
#endif
  return r;
}

// Rays from outside at the center. Coherent ones are neighbors in a picture.
inline std::vector<RTCRayHit> randomRays(std::mt19937& random, size_t count, bool areCoherent, float spread = 0.9f) {
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  std::vector<RTCRayHit> rays;
  Vec org{3, 2, 2.5f};
  const size_t side = size_t(std::sqrt(double(count)));
  for (size_t i = 0; i < count; i++) {
    if (!areCoherent) {
      float length = 0;
      for (float& x : org) {
        x = normal(random);
        length += x * x;
      }
      for (float& x : org) x *= 4 / std::sqrt(length);
    }
    const float u = areCoherent ? 2 * float(i % side) / float(side) - 1 : 2 * uniform(random) - 1,
                v = areCoherent ? 2 * float(i / side) / float(side) - 1 : 2 * uniform(random) - 1;
    Vec dir;
    for (int k = 0; k < 3; k++)
      dir[k] = -org[k] + spread * (k == 0 ? u : k == 1 ? v : areCoherent ? -u - v : uniform(random) - 0.5f);
    rays.push_back(makeRay(org, dir, uniform(random)));
  }
  return rays;
}

inline bool isHit(const RTCRayHit& r) { return r.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

// --- a cube ----------------------------------------------------------------------------------------

inline float heightAt(float x, float y, float z) { return 0.03f * std::sin(11 * x + 3 * y) * std::cos(7 * z - 5 * y); }

inline void displace(const CbvhDisplacementArguments* args) {
  for (unsigned i = 0; i < args->count; i++) {
    const float h = heightAt(args->P_x[i], args->P_y[i], args->P_z[i]);
    args->P_x[i] += h * args->Ng_x[i];
    args->P_y[i] += h * args->Ng_y[i];
    args->P_z[i] += h * args->Ng_z[i];
  }
}

inline void displaceInHost(const RTCDisplacementFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    const float h = heightAt(args->P_x[i], args->P_y[i], args->P_z[i]);
    args->P_x[i] += h * args->Ng_x[i];
    args->P_y[i] += h * args->Ng_y[i];
    args->P_z[i] += h * args->Ng_z[i];
  }
}

struct Cube {
  std::vector<Vec> vertices[2]; // at two time steps
  std::vector<unsigned> faceVertexCounts = {4, 4, 4, 4, 4, 4};
  std::vector<unsigned> indices = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
  const float* steps[2];

  explicit Cube(const Vec& middle = {0, 0, 0}, float size = 0.8f) {
    for (int step = 0; step < 2; step++)
      for (int i = 0; i < 8; i++)
        vertices[step].push_back({middle[0] + size * (i & 1 ? 1.f : -1.f) + 0.1f * float(step) * float(i & 2),
                                  middle[1] + size * (i & 2 ? 1.f : -1.f),
                                  middle[2] + size * (i & 4 ? 1.f : -1.f) + 0.2f * float(step)});
    for (auto& step : vertices) step.push_back({0, 0, 0}); // padding after the last vertex, which may be read
    steps[0] = &vertices[0][0][0];
    steps[1] = &vertices[1][0][0];
  }

  CbvhCage cage(float rate, unsigned numSteps = 1) const {
    CbvhCage cage = CbvhCage();
    cage.numFaces = faceVertexCounts.size();
    cage.faceVertexCounts = faceVertexCounts.data();
    cage.numIndices = indices.size();
    cage.indices = indices.data();
    cage.vertices = {8, sizeof(Vec), steps, numSteps, 0, 1};
    cage.rate = rate;
    cage.displacement = displace;
    return cage;
  }

  // The same cube as a geometry of the foreign Embree.
  RTCGeometry newInHost(RTCDevice device, float rate, unsigned numSteps = 1) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    rtcSetGeometryTimeStepCount(geometry, numSteps);
    for (unsigned i = 0; i < numSteps; i++) {
      void* const data = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, 12, 8);
      std::memcpy(data, steps[i], 96);
    }
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, 4, 6),
                faceVertexCounts.data(), 24);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, 24), indices.data(),
                96);
    rtcSetGeometryTessellationRate(geometry, rate);
    rtcSetGeometryDisplacementFunction(geometry, displaceInHost);
    rtcSetGeometryMask(geometry, ~0u); // the default of Embree 4 is 1
    rtcCommitGeometry(geometry);
    return geometry;
  }
};

// One or more committed cubes: a large one, or overlapping ones.
class Group {
public:
  // A group with one surface.
  Group(CbvhContext context, CbvhSurface surface) {
    OK(cbvhNewGroup(context, &surface, 1, &group));
    OK(cbvhCommitGroup(group));
  }
  explicit Group(CbvhContext context, float rate = 32, unsigned count = 1, unsigned numSteps = 1, int first = -1) {
    std::vector<CbvhSurface> surfaces;
    for (unsigned i = 0; i < count; i++) {
      const unsigned n = unsigned(std::max(first, 0)) + i;
      const Cube cube = count == 1 && first < 0 ? Cube() : Cube({0.4f * float(n), 0.1f * float(n % 3), 0}, 0.3f);
      const CbvhCage cage = cube.cage(rate, numSteps);
      CbvhSurface surface = nullptr;
      OK(cbvhNewSurface(context, &surface));
      OK(cbvhSetSurfaceCage(surface, &cage));
      OK(cbvhCommitSurface(surface, nullptr, nullptr));
      surfaces.push_back(surface);
    }
    OK(cbvhNewGroup(context, surfaces.data(), surfaces.size(), &group));
    OK(cbvhCommitGroup(group));
    for (CbvhSurface surface : surfaces) cbvhReleaseSurface(surface);
  }
  ~Group() { cbvhReleaseGroup(group); }
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  operator CbvhGroup() const { return group; }

private:
  CbvhGroup group = nullptr;
};

// A committed scene that contains the group with ID 0, or an uncommitted empty one.
class Scene {
public:
  Scene(RTCDevice device, CbvhGroup group, unsigned flags = 0) : scene(rtcNewScene(device)) {
#if RTC_VERSION_MAJOR < 4
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
#else
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
#endif
    if (!group) return;
    geometry = cbvhNewGeometry(device, group, flags);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~Scene() { rtcReleaseScene(scene); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  operator RTCScene() const { return scene; }

  RTCGeometry geometry = nullptr;

private:
  RTCScene scene;
};

} // namespace host
