// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Uses Embree 4 as MoonRay does: subdivision surfaces that it tessellated to quads, of one or two time steps, next to
 * grids and user geometry. Instances are user geometry, whose functions transform a ray and trace another scene, on two
 * levels; instances of Embree with quaternions are on the second level, too. Filters find what belongs to a ray by its
 * ID, in the context. A first run without the interposer stores its hits in a file; a second run with it must have the
 * same, see hits.h. Depends only on the parts of host.h for Embree.
 *
 *   moonray FILE [traversables]     writes FILE if it does not exist, otherwise compares with it. `traversables`:
 *                                   queries traversables instead of scenes */

#include "../host.h"
#include "hits.h"
#include "scene_queries.h"

#include <atomic>
#include <map>

using host::Vec;
using stored_hits::Hits;

namespace {

/* --- what filters and instances share with the queries ----------------------------------------- */

struct Extension {
  unsigned numFilterCalls = 0;
  const void* surface = nullptr; // user data of the surface that the ray hit, by the innermost instance
};

struct Context {
  RTCRayQueryContext context; // the first member
  Extension* extensions;      // by ID of the ray
};

/* The user data of geometries. */
struct UserData {
  bool isSingleSided = false;
};

/* Rejects hits from behind, if the surface is single-sided. */
void filter(const RTCFilterFunctionNArguments* args) {
  const UserData& data = *(const UserData*)args->geometryUserPtr;
  for (unsigned i = 0; i < args->N; i++) {
    if (!args->valid[i]) continue;
    ((Context*)args->context)->extensions[RTCRayN_id(args->ray, args->N, i)].numFilterCalls++;
    const float cosine = RTCRayN_dir_x(args->ray, args->N, i) * RTCHitN_Ng_x(args->hit, args->N, i) +
                         RTCRayN_dir_y(args->ray, args->N, i) * RTCHitN_Ng_y(args->hit, args->N, i) +
                         RTCRayN_dir_z(args->ray, args->N, i) * RTCHitN_Ng_z(args->hit, args->N, i);
    if (data.isSingleSided && cosine > 0) args->valid[i] = 0;
  }
}

/* --- surfaces ---------------------------------------------------------------------------------- */

struct Corners {
  unsigned v[4];
};

/* A displaced sphere: each face of a cube has 40 x 40 quads, and faces share the vertices of their edges. */
class Ball {
public:
  explicit Ball(float radius) {
    std::map<std::array<unsigned, 3>, unsigned> numbers;
    for (unsigned face = 0; face < 6; face++)
      for (unsigned i = 0; i < size; i++)
        for (unsigned j = 0; j < size; j++) {
          const unsigned di[4] = {0, 1, 1, 0}, dj[4] = {0, 0, 1, 1};
          Corners quad;
          for (unsigned k = 0; k < 4; k++) {
            std::array<unsigned, 3> place;
            place[face % 3] = face < 3 ? 0 : size;
            place[(face + 1) % 3] = face < 3 ? j + dj[k] : i + di[k];
            place[(face + 2) % 3] = face < 3 ? i + di[k] : j + dj[k];
            const auto inserted = numbers.insert({place, unsigned(numbers.size())});
            if (inserted.second) addVertex(place, radius);
            quad.v[k] = inserted.first->second;
          }
          quads.push_back(quad);
        }
  }

  /* Attaches the quads to the scene, and commits them afterwards. Vertices have 16 bytes. mask: -1 for Embree's. */
  RTCGeometry attach(RTCScene scene, RTCDevice device, UserData& data, unsigned numSteps, int mask = -1,
                     RTCBuildQuality quality = RTC_BUILD_QUALITY_HIGH) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    rtcSetGeometryTimeStepCount(geometry, numSteps);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads.data(), 0, sizeof(Corners),
                               quads.size());
    for (unsigned step = 0; step < numSteps; step++)
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, vertices[step].data(), 0,
                                 16, vertices[step].size());
    finish(geometry, scene, data, mask);
    return geometry;
  }

  /* Attaches a sheet through the center as a grid. */
  static void attachSheet(RTCScene scene, RTCDevice device, UserData& data, int mask = -1) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    constexpr unsigned width = 61;
    *(RTCGrid*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid),
                                       1) = {0, width, width, width};
    Vec* vertex = (Vec*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec),
                                                width * width);
    for (unsigned i = 0; i < width; i++)
      for (unsigned j = 0; j < width; j++) {
        const float x = float(j) / 30 - 1, y = float(i) / 30 - 1;
        *vertex++ = {1.2f * x, 1.2f * y, 0.1f * std::sin(4 * x + 3 * y)};
      }
    finish(geometry, scene, data, mask);
    rtcReleaseGeometry(geometry);
  }

  void deform() {
    for (auto& point : vertices[0]) point[2] *= 1.2f;
  }

private:
  typedef std::array<float, 4> Vec4;

  static void finish(RTCGeometry geometry, RTCScene scene, UserData& data, int mask) {
    if (mask >= 0) rtcSetGeometryMask(geometry, unsigned(mask));
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    rtcSetGeometryUserData(geometry, &data);
    rtcAttachGeometry(scene, geometry);
    rtcCommitGeometry(geometry);
  }

  void addVertex(const std::array<unsigned, 3>& place, float radius) {
    Vec4 point = {0, 0, 0, 0};
    float length = 0;
    for (unsigned k = 0; k < 3; k++) {
      point[k] = 2 * float(place[k]) / float(size) - 1;
      length += point[k] * point[k];
    }
    for (unsigned k = 0; k < 3; k++) point[k] *= radius / std::sqrt(length);
    const float scale = 1 + 2 * host::heightAt(point[0], point[1], point[2]);
    for (unsigned k = 0; k < 3; k++) point[k] *= scale;
    vertices[0].push_back(point);
    point[0] += 0.3f;
    point[1] *= 1.2f;
    vertices[1].push_back(point);
  }

  static constexpr unsigned size = 40; // 9600 quads, which interposer.sh finds in the log
  std::vector<Vec4> vertices[2];       // at two time steps
  std::vector<Corners> quads;
};

/* --- user geometry ----------------------------------------------------------------------------- */

/* A quadric: a sphere of radius 0.4 at the center. */
UserData sphereData;
void boundSphere(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = {-0.4f, -0.4f, -0.4f, 0, 0.4f, 0.4f, 0.4f, 0};
}

/* Returns whether the ray hits the sphere, and the distance. */
bool hitsSphere(const RTCRay& ray, float& t) {
  const float a = ray.dir_x * ray.dir_x + ray.dir_y * ray.dir_y + ray.dir_z * ray.dir_z,
              b = ray.org_x * ray.dir_x + ray.org_y * ray.dir_y + ray.org_z * ray.dir_z,
              c = ray.org_x * ray.org_x + ray.org_y * ray.org_y + ray.org_z * ray.org_z - 0.16f, d = b * b - a * c;
  t = d < 0 ? 0 : (-b - std::sqrt(d)) / a;
  return d >= 0 && t > ray.tnear && t < ray.tfar;
}
void intersectSphere(const RTCIntersectFunctionNArguments* args) {
  CHECK(args->geometryUserPtr == &sphereData);
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; i++) {
    const RTCRay ray = rtcGetRayFromRayN(rays, args->N, i);
    float t;
    if (!args->valid[i] || !hitsSphere(ray, t)) continue;
    RTCRayN_tfar(rays, args->N, i) = t;
    RTCHit hit = host::makeRay({0, 0, 0}, {0, 0, 0}).hit;
    hit.Ng_x = ray.org_x + t * ray.dir_x;
    hit.Ng_y = ray.org_y + t * ray.dir_y;
    hit.Ng_z = ray.org_z + t * ray.dir_z;
    hit.geomID = args->geomID;
    hit.primID = args->primID;
    hit.instID[0] = args->context->instID[0];
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &hit, args->N, i);
  }
}
void occludedSphere(const RTCOccludedFunctionNArguments* args) {
  CHECK(args->geometryUserPtr == &sphereData);
  for (unsigned i = 0; i < args->N; i++) {
    float t;
    if (args->valid[i] && hitsSphere(rtcGetRayFromRayN(args->ray, args->N, i), t))
      RTCRayN_tfar(args->ray, args->N, i) = -INFINITY;
  }
}
void attachSphere(RTCScene scene, RTCDevice device) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryBoundsFunction(geometry, boundSphere, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersectSphere);
  rtcSetGeometryOccludedFunction(geometry, occludedSphere);
  rtcSetGeometryUserData(geometry, &sphereData);
  rtcAttachGeometry(scene, geometry);
  rtcCommitGeometry(geometry);
  rtcReleaseGeometry(geometry);
}

/* A moving instance: a rotation about the z axis and a translation, both linear in time. */
struct Instance : UserData {
  RTCScene scene = nullptr;
  unsigned geomID = 0;
  float angle = 0, turn = 0; // at time 0, and its change until time 1
  Vec place = {0, 0, 0}, move = {0, 0, 0};

  /* Returns a vector in the coordinates of `scene`. weight: 1 for points, 0 for directions. */
  Vec toScene(float x, float y, float z, float time, float weight) const {
    const float s = std::sin(angle + time * turn), c = std::cos(angle + time * turn);
    x -= weight * (place[0] + time * move[0]);
    y -= weight * (place[1] + time * move[1]);
    z -= weight * (place[2] + time * move[2]);
    return {c * x + s * y, c * y - s * x, z};
  }

  RTCRay toScene(RTCRay ray) const {
    const Vec org = toScene(ray.org_x, ray.org_y, ray.org_z, ray.time, 1),
              dir = toScene(ray.dir_x, ray.dir_y, ray.dir_z, ray.time, 0);
    ray.org_x = org[0];
    ray.org_y = org[1];
    ray.org_z = org[2];
    ray.dir_x = dir[0];
    ray.dir_y = dir[1];
    ray.dir_z = dir[2];
    return ray;
  }

  void attach(RTCScene outer, RTCDevice device, int mask = -1);
};

/* The box of a ball around the box of the scene, at all times. */
void boundInstance(const RTCBoundsFunctionArguments* args) {
  const Instance& instance = *(const Instance*)args->geometryUserPtr;
  RTCBounds inner;
  rtcGetSceneBounds(instance.scene, &inner);
  const Vec farthest = {std::max(-inner.lower_x, inner.upper_x), std::max(-inner.lower_y, inner.upper_y),
                        std::max(-inner.lower_z, inner.upper_z)};
  CHECK(farthest[0] > 0.5f && farthest[1] > 0.5f && farthest[2] > 0.05f && farthest[0] < 9);
  const float radius = std::sqrt(farthest[0] * farthest[0] + farthest[1] * farthest[1] + farthest[2] * farthest[2]);
  float* const lower = &args->bounds_o->lower_x;
  float* const upper = &args->bounds_o->upper_x;
  for (unsigned k = 0; k < 3; k++) {
    lower[k] = instance.place[k] + std::min(0.f, instance.move[k]) - radius;
    upper[k] = instance.place[k] + std::max(0.f, instance.move[k]) + radius;
  }
}

/* Traces the scene with a query of its own, which has the context of the outer query. */
void intersectInstance(const RTCIntersectFunctionNArguments* args) {
  const Instance& instance = *(const Instance*)args->geometryUserPtr;
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; i++) {
    if (!args->valid[i]) continue;
    RTCRayHit local = host::makeRay({0, 0, 0}, {0, 0, 0});
    local.ray = instance.toScene(rtcGetRayFromRayN(rays, args->N, i));
    RTCIntersectArguments query;
    rtcInitIntersectArguments(&query);
    query.context = args->context;
    scene_queries::intersect(instance.scene, &local, &query);
    if (!host::isHit(local)) continue;
    if (local.hit.instID[0] != local.hit.geomID) // not an instance
      ((Context*)args->context)->extensions[local.ray.id].surface =
          rtcGetGeometryUserData(rtcGetGeometry(instance.scene, local.hit.geomID));
    local.hit.geomID = local.hit.instID[0] = instance.geomID; // this is how MoonRay marks instances
    RTCRayN_tfar(rays, args->N, i) = local.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &local.hit, args->N, i);
  }
}
void occludedInstance(const RTCOccludedFunctionNArguments* args) {
  const Instance& instance = *(const Instance*)args->geometryUserPtr;
  for (unsigned i = 0; i < args->N; i++) {
    if (!args->valid[i]) continue;
    RTCRay local = instance.toScene(rtcGetRayFromRayN(args->ray, args->N, i));
    RTCOccludedArguments query;
    rtcInitOccludedArguments(&query);
    query.context = args->context;
    scene_queries::occluded(instance.scene, &local, &query);
    RTCRayN_tfar(args->ray, args->N, i) = local.tfar;
  }
}

void Instance::attach(RTCScene outer, RTCDevice device, int mask) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcSetGeometryTimeStepCount(geometry, 1);
  rtcSetGeometryBoundsFunction(geometry, boundInstance, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersectInstance);
  rtcSetGeometryOccludedFunction(geometry, occludedInstance);
  if (mask >= 0) rtcSetGeometryMask(geometry, unsigned(mask));
  rtcSetGeometryUserData(geometry, this);
  geomID = rtcAttachGeometry(outer, geometry);
  rtcCommitGeometry(geometry);
  rtcReleaseGeometry(geometry);
}

/* --- scenes ------------------------------------------------------------------------------------ */

class Program {
public:
  Program(RTCDevice device, Hits& hits) : device(device), hits(hits) {
    rays = host::randomRays(random, 3000, false);
    for (unsigned i = 0; i < rays.size(); i++) rays[i].ray.id = i;
    extensions.resize(rays.size());
    singleSided.isSingleSided = true;
  }

  void run();

private:
  RTCScene newScene(RTCBuildQuality quality = RTC_BUILD_QUALITY_HIGH) {
    const RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, quality);
    return scene;
  }
  template<unsigned N> void shootPackets(RTCScene scene);
  void shoot(RTCScene scene);
  void attachQuaternions(RTCScene outer, RTCScene inner, float x);

  void quads();
  void masks();
  void refits();
  void instances();
  void quaternions();

  const RTCDevice device;
  Hits& hits;
  std::mt19937 random{7};
  std::vector<RTCRayHit> rays;
  std::vector<Extension> extensions;
  UserData twoSided, singleSided;
  unsigned numSurfaces = 0; // rays of the last shoot() that found a surface's user data in an instance
};

template<unsigned N>
void Program::shootPackets(RTCScene scene) {
  Context context;
  rtcInitRayQueryContext(&context.context);
  context.extensions = extensions.data();
  RTCIntersectArguments query;
  rtcInitIntersectArguments(&query);
  query.context = &context.context;
  for (size_t first = 0; first + N <= 400; first += N) {
    typename host::Packet<N>::RayHits packet;
    alignas(64) int valid[N];
    for (unsigned i = 0; i < N; i++) {
      host::setRay(&packet, N, i, rays[first + i]);
      valid[i] = i % 3 != 1 ? -1 : 0;
    }
    scene_queries::intersect(valid, scene, &packet, &query);
    for (unsigned i = 0; i < N; i++) {
      RTCRayHit one = rays[first + i];
      one.ray.tfar = packet.ray.tfar[i];
      one.hit = rtcGetHitFromHitN((RTCHitN*)&packet.hit, N, i);
      hits.keep(one);
    }
  }
}

/* Single rays with a context of their own, and packets. */
void Program::shoot(RTCScene scene) {
  const Extension none;
  unsigned numCalls = 0, numHits = 0;
  numSurfaces = 0;
  for (const RTCRayHit& ray : rays) {
    Extension& extension = extensions[ray.ray.id];
    extension = none;
    Context context;
    rtcInitRayQueryContext(&context.context);
    context.extensions = extensions.data();
    RTCIntersectArguments intersect;
    rtcInitIntersectArguments(&intersect);
    RTCOccludedArguments occluded;
    rtcInitOccludedArguments(&occluded);
    intersect.context = occluded.context = &context.context;

    RTCRayHit one = ray;
    scene_queries::intersect(scene, &one, &intersect);
    hits.keep(one);
    const void* const surface = extension.surface;
    CHECK(!surface || surface == &twoSided || surface == &singleSided || surface == &sphereData);
    numSurfaces += surface != nullptr;
    RTCRay shadow = ray.ray;
    scene_queries::occluded(scene, &shadow, &occluded);
    hits.keep(shadow);
    numCalls += extension.numFilterCalls;
    numHits += host::isHit(one);
  }
  CHECK(numHits == 0 || numCalls > 0);
  shootPackets<4>(scene);
  shootPackets<8>(scene);
  shootPackets<16>(scene);
}

void Program::quads() {
  for (unsigned numSteps = 1; numSteps <= 2; numSteps++)
    for (UserData* data : {&twoSided, &singleSided}) {
      Ball ball(1);
      const RTCScene scene = newScene();
      rtcReleaseGeometry(ball.attach(scene, device, *data, numSteps));
      Ball::attachSheet(scene, device, twoSided);
      attachSphere(scene, device);
      rtcCommitScene(scene);
      shoot(scene);
      rtcReleaseScene(scene);
    }
}

/* Masks of geometries that the application sets or not, and masks of rays. */
void Program::masks() {
  const std::vector<RTCRayHit> all = rays;
  for (const int ofBall : {-1, 0, 1, 1 << 9})
    for (const int ofSheet : {-1, 0}) {
      Ball ball(1);
      const RTCScene scene = newScene();
      rtcReleaseGeometry(ball.attach(scene, device, twoSided, 1, ofBall));
      Ball::attachSheet(scene, device, twoSided, ofSheet);
      rtcCommitScene(scene);
      for (const unsigned ofRay : {0u, 1u, 1u << 9, ~0u}) {
        for (RTCRayHit& ray : rays) ray.ray.mask = ofRay;
        shoot(scene);
      }
      rtcReleaseScene(scene);
    }
  rays = all;
}

/* A geometry that the application deforms between frames. */
void Program::refits() {
  Ball ball(1);
  const RTCScene scene = newScene(RTC_BUILD_QUALITY_LOW);
  const RTCGeometry geometry = ball.attach(scene, device, twoSided, 1, 1, RTC_BUILD_QUALITY_REFIT);
  for (int frame = 0; frame < 3; frame++) {
    rtcCommitScene(scene);
    shoot(scene);
    ball.deform();
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
  }
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

/* Two levels of moving instances, and a geometry next to the instances of each level. */
void Program::instances() {
  Ball ball(0.5f), moving(0.4f);
  const RTCScene inner = newScene(), middle = newScene(), outer = newScene();
  rtcReleaseGeometry(ball.attach(inner, device, twoSided, 2));
  Ball::attachSheet(inner, device, singleSided);
  attachSphere(inner, device);
  rtcCommitScene(inner);

  Instance first, second, third;
  first.scene = second.scene = inner;
  first.place = {0.7f, 0, 0};
  first.turn = 0.8f;
  second.place = {-0.7f, 0.3f, 0.2f};
  second.move = {0, 0.5f, -0.2f};
  second.angle = 2;
  rtcReleaseGeometry(moving.attach(middle, device, singleSided, 1));
  first.attach(middle, device);
  second.attach(middle, device, 1);
  rtcCommitScene(middle);

  third.scene = middle;
  third.angle = -1;
  third.turn = 0.4f;
  third.move = {0.2f, 0.1f, 0.3f};
  attachSphere(outer, device);
  third.attach(outer, device, 3);
  first.attach(outer, device);
  rtcCommitScene(outer);
  shoot(outer);
  CHECK(numSurfaces > 500);
  rtcReleaseScene(outer);
  rtcReleaseScene(middle);
  rtcReleaseScene(inner);
}

/* Adds an instance whose rotation and translation Embree interpolates between two quaternions. */
void Program::attachQuaternions(RTCScene outer, RTCScene inner, float x) {
  const RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, inner);
  rtcSetGeometryTimeStepCount(instance, 2);
  for (unsigned step = 0; step < 2; step++) {
    RTCQuaternionDecomposition decomposition;
    rtcInitQuaternionDecomposition(&decomposition);
    const float half = step ? 0.9f : 0.1f; // of the angle
    rtcQuaternionDecompositionSetQuaternion(&decomposition, std::cos(half), 0.6f * std::sin(half), 0,
                                            0.8f * std::sin(half));
    rtcQuaternionDecompositionSetScale(&decomposition, 0.8f, 0.7f, step ? 0.6f : 0.8f);
    rtcQuaternionDecompositionSetTranslation(&decomposition, x, step ? 0.2f : -0.1f, 0);
    rtcSetGeometryTransformQuaternion(instance, step, &decomposition);
  }
  rtcAttachGeometry(outer, instance);
  rtcCommitGeometry(instance);
  rtcReleaseGeometry(instance);
}

/* Quaternions on the first level, and on the second, in an instance that is user geometry. */
void Program::quaternions() {
  Ball ball(0.7f);
  const RTCScene inner = newScene(), middle = newScene(), outer = newScene();
  rtcReleaseGeometry(ball.attach(inner, device, twoSided, 2));
  Ball::attachSheet(inner, device, twoSided);
  rtcCommitScene(inner);
  attachQuaternions(middle, inner, 0.5f);
  attachQuaternions(middle, inner, -0.6f);
  rtcCommitScene(middle);
  shoot(middle);
  Instance moving;
  moving.scene = middle;
  moving.turn = 0.5f;
  moving.move = {0, 0.1f, 0.4f};
  moving.attach(outer, device);
  attachQuaternions(outer, inner, 0);
  rtcCommitScene(outer);
  shoot(outer);
  rtcReleaseScene(outer);
  rtcReleaseScene(middle);
  rtcReleaseScene(inner);
}

void Program::run() {
  const std::pair<const char*, void (Program::*)()> uses[] = {{"quads", &Program::quads},
                                                              {"masks", &Program::masks},
                                                              {"refits", &Program::refits},
                                                              {"instances", &Program::instances},
                                                              {"quaternions", &Program::quaternions}};
  for (const auto& use : uses) {
    hits.begin(use.first);
    (this->*use.second)();
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  }
}

bool countBytes(void* sum, ssize_t bytes, bool) {
  *(std::atomic<ssize_t>*)sum += bytes;
  return true;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  scene_queries::useTraversables = argc == 3;
  if (scene_queries::useTraversables && !scene_queries::haveTraversables) return 2;
  Hits hits(argv[1]);
  const RTCDevice device = rtcNewDevice("threads=2");
  std::atomic<ssize_t> bytes{0};
  rtcSetDeviceMemoryMonitorFunction(device, countBytes, &bytes);
  Program(device, hits).run();
  hits.conclude();
  rtcReleaseDevice(device);
  CHECK(bytes == 0);
  return host::conclude("quads and instances as in MoonRay");
}
