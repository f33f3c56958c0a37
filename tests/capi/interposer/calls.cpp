// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Uses all features of Embree 4 for subdivision geometry. A first run without the interposer stores its hits in a file;
 * a second run with it must have the same hits except for the rounding to the lattice. Depends only on the parts of
 * host.h for Embree.
 *
 *   calls FILE [traversables]     writes FILE if it does not exist, otherwise compares with it. `traversables`: queries
 *                                 traversables instead of scenes */

#include "../host.h"
#include "hits.h"
#include "scene_queries.h"

#include <atomic>
#include <chrono>
#include <dlfcn.h>
#include <sys/resource.h>
#include <thread>
#include <utility>

using host::Vec;
using stored_hits::Hits;

namespace {

/* --- features that applications use ---------------------------------------------------------- */

struct Context {
  RTCRayQueryContext context;
  unsigned magic = 4711, numCalls = 0; // the application's members after Embree's
};

int userData;

/* Rejects hits on odd faces. */
void refuseOdd(const RTCFilterFunctionNArguments* args) {
  CHECK(args->geometryUserPtr == &userData);
  Context& context = *(Context*)args->context;
  CHECK(context.magic == 4711);
  context.numCalls++;
  for (unsigned i = 0; i < args->N; i++)
    if (args->valid[i] && RTCHitN_primID(args->hit, args->N, i) % 2 == 1) args->valid[i] = 0;
}

/* Rejects hits on one side. */
void refuseLeft(const RTCFilterFunctionNArguments* args) {
  CHECK(args->geometryUserPtr == &userData);
  Context& context = *(Context*)args->context;
  CHECK(context.magic == 4711);
  context.numCalls++;
  for (unsigned i = 0; i < args->N; i++)
    if (args->valid[i] && RTCHitN_u(args->hit, args->N, i) < 0.5f) args->valid[i] = 0;
}

/* A user geometry whose intersection function is passed with the query: a square at z = 1.5. */
char squareData;
void boundSquare(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = {-0.3f, -0.3f, 1.5f, 0, 0.3f, 0.3f, 1.5f, 0};
}
void intersectSquare(const RTCIntersectFunctionNArguments* args) {
  CHECK(args->geometryUserPtr == &squareData);
  for (unsigned i = 0; i < args->N; i++) {
    RTCRayN* const ray = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN* const hit = RTCRayHitN_HitN(args->rayhit, args->N);
    if (!args->valid[i]) continue;
    const float t = (1.5f - RTCRayN_org_z(ray, args->N, i)) / RTCRayN_dir_z(ray, args->N, i);
    const float x = RTCRayN_org_x(ray, args->N, i) + t * RTCRayN_dir_x(ray, args->N, i),
                y = RTCRayN_org_y(ray, args->N, i) + t * RTCRayN_dir_y(ray, args->N, i);
    if (!(t > RTCRayN_tnear(ray, args->N, i) && t < RTCRayN_tfar(ray, args->N, i)) || std::abs(x) > 0.3f ||
        std::abs(y) > 0.3f)
      continue;
    RTCRayN_tfar(ray, args->N, i) = t;
    RTCHitN_geomID(hit, args->N, i) = args->geomID;
    RTCHitN_primID(hit, args->N, i) = args->primID;
    RTCHitN_instID(hit, args->N, i, 0) = args->context->instID[0];
    RTCHitN_instPrimID(hit, args->N, i, 0) = args->context->instPrimID[0];
    RTCHitN_u(hit, args->N, i) = RTCHitN_v(hit, args->N, i) = 0;
    RTCHitN_Ng_x(hit, args->N, i) = RTCHitN_Ng_y(hit, args->N, i) = 0;
    RTCHitN_Ng_z(hit, args->N, i) = 1;
  }
}
void occludedSquare(const RTCOccludedFunctionNArguments* args) { CHECK(args->geometryUserPtr == &squareData); }

/* A user geometry that forwards rays to the scene `inside`. */
RTCScene inside = nullptr;
void boundInside(const RTCBoundsFunctionArguments* args) { *args->bounds_o = {-1, -1, -1, 0, 1, 1, 1, 0}; }
template<typename Rays, typename Arguments>
void forwardMoved(const Arguments* args, const void* rays) {
  Rays moved = *(const Rays*)rays;
  float* const org_x = (float*)&moved; // the first member
  for (unsigned i = 0; i < args->N; i++) org_x[i] += 0.2f;
  scene_queries::forward(args, inside, &moved, 5);
}
template<typename Arguments>
void forwardRays(const Arguments* args, const void* rays) {
  CHECK(args->geometryUserPtr == &inside);
  switch (args->N) {
  case 1: return forwardMoved<RTCRay>(args, rays);
  case 4: return forwardMoved<RTCRay4>(args, rays);
  case 8: return forwardMoved<RTCRay8>(args, rays);
  case 16: return forwardMoved<RTCRay16>(args, rays);
  default: CHECK(!"a packet of 1, 4, 8 or 16 rays");
  }
}
void intersectInside(const RTCIntersectFunctionNArguments* args) { forwardRays(args, args->rayhit); }
void occludedInside(const RTCOccludedFunctionNArguments* args) { forwardRays(args, args->ray); }

struct Queries {
  RTCIntersectArguments intersect;
  RTCOccludedArguments occluded;
  Context context;

  Queries() {
    rtcInitRayQueryContext(&context.context);
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    intersect.context = occluded.context = &context.context;
  }
};

class Program {
public:
  Program(RTCDevice device, Hits& hits) : device(device), hits(hits) { rays = host::randomRays(random, 3000, false); }

  void run();

private:
  template<unsigned N> void shootPackets(RTCScene scene, Queries& queries);
  void shoot(RTCScene scene, Queries& queries);
  void shoot(RTCScene scene) {
    Queries queries;
    shoot(scene, queries);
  }
  RTCGeometry newCube(float rate = 24) { return host::Cube().newInHost(device, rate); }
  RTCScene newScene(RTCGeometry geometry, unsigned geomID = 0) {
    const RTCScene scene = rtcNewScene(device);
    rtcAttachGeometryByID(scene, geometry, geomID);
    rtcCommitScene(scene);
    return scene;
  }

  void plain();
  void filters();
  void userGeometry();
  void forwarding();
#if RTC_VERSION >= 40400
  void buffersOfDevice();
#endif
  void masks();
  void instances();
  void edits();
  void motion();
  void rejections();
  void releases();
  void meshes();
  void cancelling();
  void threads();
  void devices();
  void unknownDevice();

  const RTCDevice device;
  Hits& hits;
  std::mt19937 random{7};
  std::vector<RTCRayHit> rays;
};

template<unsigned N>
void Program::shootPackets(RTCScene scene, Queries& queries) {
  typename host::Packet<N>::RayHits packet;
  typename host::Packet<N>::Rays shadows;
  alignas(64) int valid[N];
  for (unsigned i = 0; i < N; i++) {
    host::setRay(&packet, N, i, rays[i]);
    valid[i] = i % 3 != 1 ? -1 : 0;
  }
  shadows = packet.ray;
  scene_queries::intersect(valid, scene, &packet, &queries.intersect);
  scene_queries::occluded(valid, scene, &shadows, &queries.occluded);
  for (unsigned i = 0; i < N; i++) {
    RTCRayHit one = rays[i];
    one.ray.tfar = packet.ray.tfar[i];
    one.hit.geomID = packet.hit.geomID[i];
    one.hit.primID = packet.hit.primID[i];
    one.hit.instID[0] = packet.hit.instID[0][i];
    one.hit.instPrimID[0] = packet.hit.instPrimID[0][i];
    one.hit.u = packet.hit.u[i];
    one.hit.v = packet.hit.v[i];
    one.hit.Ng_x = packet.hit.Ng_x[i];
    one.hit.Ng_y = packet.hit.Ng_y[i];
    one.hit.Ng_z = packet.hit.Ng_z[i];
    hits.keep(one);
    one.hit.geomID = shadows.tfar[i] < 0 ? 1000 : RTC_INVALID_GEOMETRY_ID;
    one.hit.primID = 0;
    one.hit.u = one.hit.v = 0;
    hits.keep(one);
  }
}

void Program::shoot(RTCScene scene, Queries& queries) {
  for (const RTCRayHit& ray : rays) {
    RTCRayHit one = ray;
    scene_queries::intersect(scene, &one, &queries.intersect);
    hits.keep(one);
    RTCRay shadow = ray.ray;
    scene_queries::occluded(scene, &shadow, &queries.occluded);
    one = ray;
    if (shadow.tfar < 0) one.hit.geomID = 1000;
    one.hit.primID = 0;
    hits.keep(one);
  }
  shootPackets<4>(scene, queries);
  shootPackets<8>(scene, queries);
  shootPackets<16>(scene, queries);
}

void Program::plain() {
  const RTCGeometry geometry = newCube();
  rtcSetGeometryUserData(geometry, &userData);
  rtcCommitGeometry(geometry);
  const RTCScene scene = newScene(geometry, 7);
  CHECK(rtcGetGeometry(scene, 7) == geometry);
  CHECK(rtcGetGeometryThreadSafe(scene, 7) == geometry);
  CHECK(rtcGetGeometryUserData(geometry) == &userData);
  CHECK(scene_queries::getUserData(scene, 7) == &userData);
  CHECK(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0) != nullptr);
  CHECK(rtcGetGeometryNextHalfEdge(geometry, 3) == 0);
  CHECK(rtcGetGeometryFace(geometry, 5) == 1);
  rtcReleaseGeometry(geometry); // the scene holds a reference
  float P[3] = {0, 0, 0};
  rtcInterpolate0(rtcGetGeometry(scene, 7), 1, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, P, 3);
  CHECK(P[2] > 0.3f && P[2] < 0.8f);
  RTCBounds bounds;
  rtcGetSceneBounds(scene, &bounds);
  CHECK(bounds.lower_x < -0.4f && bounds.lower_x > -0.7f && bounds.upper_z > 0.4f && bounds.upper_z < 0.7f);
  shoot(scene);
  rtcReleaseScene(scene);
}

void Program::filters() {
  const RTCGeometry geometry = newCube();
  rtcSetGeometryUserData(geometry, &userData);
  rtcSetGeometryIntersectFilterFunction(geometry, refuseOdd);
  rtcSetGeometryOccludedFilterFunction(geometry, refuseOdd);
  rtcCommitGeometry(geometry);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
  CHECK(rtcAttachGeometry(scene, geometry) == 0);
  rtcCommitScene(scene);

  Queries ofGeometry;
  shoot(scene, ofGeometry);
  CHECK(ofGeometry.context.numCalls > 0);

  Queries both, neither;
  both.intersect.filter = both.occluded.filter = neither.intersect.filter = neither.occluded.filter = refuseLeft;
  both.intersect.flags = both.occluded.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  shoot(scene, both);
  shoot(scene, neither); // neither the query nor the geometry enables the filter

  rtcSetGeometryIntersectFilterFunction(geometry, nullptr);
  rtcSetGeometryOccludedFilterFunction(geometry, nullptr);
  rtcSetGeometryEnableFilterFunctionFromArguments(geometry, true);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  Queries ofArguments;
  ofArguments.intersect.filter = ofArguments.occluded.filter = refuseLeft;
  shoot(scene, ofArguments);
  CHECK(ofArguments.context.numCalls > 0);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

void Program::userGeometry() {
  const RTCGeometry geometry = newCube(), square = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(square, 1);
  rtcSetGeometryUserData(square, &squareData);
  rtcSetGeometryBoundsFunction(square, boundSquare, nullptr);
  rtcCommitGeometry(square);
  const RTCScene scene = rtcNewScene(device);
  rtcAttachGeometry(scene, square);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  CHECK(rtcGetGeometry(scene, 0) == square && rtcGetGeometry(scene, 1) == geometry);
  std::vector<unsigned> near;
  RTCPointQuery point = {0.1f, 0.1f, 1, 0, 2};
  RTCPointQueryContext pointContext;
  rtcInitPointQueryContext(&pointContext);
  scene_queries::pointQuery(
      scene, &point, &pointContext,
      [](RTCPointQueryFunctionArguments* args) {
        ((std::vector<unsigned>*)args->userPtr)->push_back(args->geomID);
        return false;
      },
      &near);
  CHECK(near == std::vector<unsigned>{0}); // Embree does not call the function for subdivision surfaces
  Queries queries;
  queries.intersect.intersect = intersectSquare;
  queries.occluded.occluded = occludedSquare;
  shoot(scene, queries);
  rtcReleaseGeometry(square);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

/* A user geometry forwards rays to a scene with filters. The functions are the geometry's, then the query's. */
void Program::forwarding() {
  const RTCGeometry geometry = newCube(), portal = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserData(geometry, &userData);
  rtcSetGeometryIntersectFilterFunction(geometry, refuseOdd);
  rtcSetGeometryOccludedFilterFunction(geometry, refuseOdd);
  rtcCommitGeometry(geometry);
  inside = rtcNewScene(device);
  const RTCScene outer = rtcNewScene(device);
  for (const RTCScene scene : {inside, outer}) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);
  rtcAttachGeometry(inside, geometry);
  rtcCommitScene(inside);

  rtcSetGeometryUserPrimitiveCount(portal, 1);
  rtcSetGeometryUserData(portal, &inside);
  rtcSetGeometryBoundsFunction(portal, boundInside, nullptr);
  rtcSetGeometryIntersectFunction(portal, intersectInside);
  rtcSetGeometryOccludedFunction(portal, occludedInside);
  rtcCommitGeometry(portal);
  rtcAttachGeometry(outer, portal);
  rtcCommitScene(outer);
  Queries ofGeometry, ofQuery;
  ofGeometry.intersect.filter = ofGeometry.occluded.filter = refuseLeft;
  ofGeometry.intersect.flags = ofGeometry.occluded.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  shoot(outer, ofGeometry);
  CHECK(ofGeometry.context.numCalls > 0);
  rtcSetGeometryIntersectFunction(portal, nullptr);
  rtcSetGeometryOccludedFunction(portal, nullptr);
  rtcCommitGeometry(portal);
  rtcCommitScene(outer);
  ofQuery.intersect.intersect = intersectInside;
  ofQuery.occluded.occluded = occludedInside;
  shoot(outer, ofQuery);
  CHECK(ofQuery.context.numCalls > 0);
  rtcReleaseGeometry(geometry);
  rtcReleaseGeometry(portal);
  rtcReleaseScene(outer);
  rtcReleaseScene(inside);
}

#if RTC_VERSION >= 40400
/* Buffers in the memory of the device, which is that of the host. */
void Program::buffersOfDevice() {
  const host::Cube cube;
  const RTCGeometry geometry = newCube(17); // 1734 quads, which interposer.sh finds in the log
  void *vertices = nullptr, *ofDevice = nullptr;
  rtcSetNewGeometryBufferHostDevice(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 8, &vertices,
                                    &ofDevice);
  CHECK(vertices && ofDevice == vertices);
  CHECK(rtcGetGeometryBufferDataDevice(geometry, RTC_BUFFER_TYPE_VERTEX, 0) == vertices);
  std::memcpy(vertices, cube.vertices[1].data(), 8 * 12);
  unsigned faces[6] = {4, 4, 4, 4, 4, 4}, rejected[6] = {5, 4, 4, 4, 4, 3};
  rtcSetSharedGeometryBufferHostDevice(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, faces, nullptr, 0, 4, 6);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcSetSharedGeometryBufferHostDevice(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, rejected, rejected, 0, 4, 6);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT); // a CPU's device has no other memory
  rtcCommitGeometry(geometry);
  const RTCScene scene = newScene(geometry);
  shoot(scene);

  const RTCBuffer buffer = rtcNewBufferHostDevice(device, 8 * 12 + 4);
  CHECK(rtcGetBufferDataDevice(buffer) == rtcGetBufferData(buffer));
  std::memcpy(rtcGetBufferData(buffer), cube.vertices[0].data(), 8 * 12);
  rtcCommitBuffer(buffer);
  rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 0, 12, 8);
  rtcReleaseBuffer(buffer);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}
#endif

void Program::masks() {
  const RTCGeometry geometry = newCube();
  rtcSetGeometryMask(geometry, 6);
  rtcCommitGeometry(geometry);
  const RTCScene scene = newScene(geometry);
  const std::vector<RTCRayHit> all = rays;
  for (size_t i = 0; i < rays.size(); i++) rays[i].ray.mask = 1u << (i % 4);
  shoot(scene);
  rays = all;
  rtcSetGeometryMask(geometry, 1);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);
  rtcReleaseScene(scene);
  rtcReleaseGeometry(geometry);
}

void Program::instances() {
  const RTCGeometry geometry = newCube(), instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE),
                    array = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY);
  const RTCScene inner = newScene(geometry, 2), outer = rtcNewScene(device);
  rtcReleaseGeometry(geometry);
  const float place[12] = {0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 0.5f, 0.4f, 0, 0};
  rtcSetGeometryInstancedScene(instance, inner);
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, place);
  rtcSetGeometryMask(instance, ~0u);
  rtcCommitGeometry(instance);
  rtcSetGeometryInstancedScene(array, inner);
  float* const places =
      (float*)rtcSetNewGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, 48, 2);
  for (int i = 0; i < 24; i++) places[i] = place[i % 12] - (i % 12 == 9 ? 0.9f : 0) + (i == 22 ? 0.8f : 0);
  rtcSetGeometryMask(array, ~0u);
  rtcCommitGeometry(array);
  rtcReleaseScene(inner); // the instances hold references
  rtcAttachGeometry(outer, instance);
  rtcAttachGeometry(outer, array);
  rtcReleaseGeometry(instance);
  rtcReleaseGeometry(array);
  rtcCommitScene(outer);
  shoot(outer);
  rtcReleaseScene(outer);
}

void Program::edits() {
  const RTCGeometry geometry = newCube();
  const RTCScene scene = newScene(geometry, 3), other = newScene(geometry, 5);
  rtcAttachGeometryByID(scene, geometry, 9); // attached a second time
  rtcCommitScene(scene);
  hits.numbersMatter = false;
  shoot(scene);

  float* const vertices = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  vertices[3] += 0.4f;
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcSetGeometryTessellationRate(geometry, 13);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  rtcCommitScene(other);
  shoot(scene);
  shoot(other);

  hits.numbersMatter = true;
  rtcDetachGeometry(scene, 3);
  rtcDisableGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);
  rtcEnableGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);

  /* a geometry that changes to Embree's kernel and back */
  unsigned* const indices = (unsigned*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0);
  CHECK(indices[4] == 4);
  unsigned* const faces = (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, 4, 5);
  for (int i = 0; i < 5; i++) faces[i] = 4; // one side is open
  for (const RTCSubdivisionMode mode :
       {RTC_SUBDIVISION_MODE_NO_BOUNDARY, RTC_SUBDIVISION_MODE_PIN_CORNERS, RTC_SUBDIVISION_MODE_NO_BOUNDARY}) {
    rtcSetGeometrySubdivisionMode(geometry, 0, mode);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    CHECK(rtcGetGeometry(scene, 9) == geometry);
    shoot(scene);
  }
  rtcCommitScene(other);
  shoot(other);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
  rtcReleaseScene(other);
}

void Program::motion() {
  const host::Cube cube;
  const RTCGeometry geometry = newCube(11); // 726 quads, which interposer.sh finds in the log
  rtcSetGeometryTimeStepCount(geometry, 2);
  // Embree 4.3.3 itself shows subdivision surfaces outside of other time ranges, too
  rtcSetGeometryTimeRange(geometry, 0, 1);
  rtcSetGeometryTimeRange(geometry, 1, 0); // rejected: the range stays 0 to 1
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT);
  for (unsigned i = 0; i < 2; i++)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3, cube.vertices[i].data(), 0, 12,
                               8);
  rtcCommitGeometry(geometry);
  const RTCScene scene = newScene(geometry);
  shoot(scene);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

/* Embree keeps the previous values if it rejects a call. */
void Program::rejections() {
  const RTCGeometry geometry = newCube();
  const RTCBuffer buffer = rtcNewBuffer(device, 8 * 12 + 4);
  std::memcpy(rtcGetBufferData(buffer), host::Cube().vertices[0].data(), 8 * 12);
  rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 0, 12, 8);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcCommitGeometry(geometry);
  const RTCScene scene = newScene(geometry);
  shoot(scene);

  const std::pair<size_t, size_t> ranges[] = {{1 << 20, 8}, {0, 1 << 20}}; // offset and count, past the end
  for (const auto& range : ranges) {
    rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, range.first, 12, range.second);
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    shoot(scene);
  }
  rtcReleaseBuffer(buffer);

  unsigned errors = 0;
  const RTCGrid grid = {0, 2, 2, 2};
  rtcSetDeviceErrorFunction(device, [](void* count, RTCError, const char*) { ++*(unsigned*)count; }, &errors);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, &grid, 0, sizeof(grid), 1);
  CHECK(errors == 1 && rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT);
  rtcSetDeviceErrorFunction(device, nullptr, nullptr);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

void Program::cancelling() {
  const RTCGeometry geometry = newCube(200);
  const RTCScene scene = rtcNewScene(device);
  rtcAttachGeometry(scene, geometry);
  bool goesOn = false;
  rtcSetSceneProgressMonitorFunction(scene, [](void* goesOn, double) { return *(bool*)goesOn; }, &goesOn);
  rtcCommitScene(scene);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_CANCELLED);
  goesOn = true;
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);

  /* If a commit of several threads is canceled, waiting threads do not start again. */
  struct Joined {
    std::atomic<int> waiting{0}, calls{0}, canceled{0};
  } joined;
  rtcSetSceneProgressMonitorFunction(
      scene,
      [](void* ptr, double) {
        Joined& joined = *(Joined*)ptr;
        if (joined.calls++ > 0) return true;
        while (joined.waiting < 4) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        return false;
      },
      &joined);
  rtcCommitGeometry(geometry);
  std::vector<std::thread> all;
  for (int k = 0; k < 4; k++)
    all.emplace_back([&] {
      joined.waiting++;
      rtcJoinCommitScene(scene);
      if (rtcGetDeviceError(device) == RTC_ERROR_CANCELLED) joined.canceled++;
    });
  for (std::thread& thread : all) thread.join();
  CHECK(joined.canceled > 0);
  RTCBounds bounds;
  rtcGetSceneBounds(scene, &bounds);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_INVALID_OPERATION); // the scene was not committed
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

/* A sheet of 200 x 200 quads. */
class Sheet {
public:
  Sheet() {
    for (unsigned y = 0; y < width; y++)
      for (unsigned x = 0; x < width; x++) {
        const float s = 2 * float(x) / float(size) - 1, t = 2 * float(y) / float(size) - 1;
        vertices.push_back({s, t, 0.2f * std::sin(5 * s) * std::cos(4 * t)});
      }
    vertices.push_back({0, 0, 0}); // padding after the last vertex, which may be read
  }

  /* Returns a committed geometry of quads, of triangles, or of grids with quadsOfGrid x quadsOfGrid quads. */
  RTCGeometry newGeometry(RTCDevice device, RTCGeometryType type, RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM,
                          unsigned quadsOfGrid = size) const {
    const RTCGeometry geometry = rtcNewGeometry(device, type);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0, 12,
                               width * width);
    if (type == RTC_GEOMETRY_TYPE_GRID) setGrids(geometry, quadsOfGrid);
    else setFaces(geometry, type == RTC_GEOMETRY_TYPE_QUAD);
    rtcSetGeometryMask(geometry, ~0u);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcCommitGeometry(geometry);
    return geometry;
  }

private:
  void setGrids(RTCGeometry geometry, unsigned quads) const {
    RTCGrid* grids = (RTCGrid*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID,
                                                       sizeof(RTCGrid), (size / quads) * (size / quads));
    for (unsigned y = 0; y < size; y += quads)
      for (unsigned x = 0; x < size; x += quads)
        *grids++ = {y * width + x, width, (unsigned short)(quads + 1), (unsigned short)(quads + 1)};
  }

  void setFaces(RTCGeometry geometry, bool areQuads) const {
    unsigned* indices = (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                           areQuads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
                                                           areQuads ? 16 : 12, (areQuads ? 1 : 2) * size * size);
    for (unsigned y = 0; y < size; y++)
      for (unsigned x = 0; x < size; x++) {
        const unsigned a = y * width + x, quad[4] = {a, a + 1, a + width + 1, a + width},
                       triangles[6] = {a, a + 1, a + width, a + width + 1, a + width, a + 1};
        for (unsigned i = 0; i < (areQuads ? 4u : 6u); i++) *indices++ = areQuads ? quad[i] : triangles[i];
      }
  }

  static constexpr unsigned size = 200, width = size + 1;
  std::vector<Vec> vertices;
};

/* A sheet as a grid, quads and triangles, which the interposer compresses, and then as small grids and as triangles
 * that the application will refit, which it leaves to Embree. */
void Program::meshes() {
  const Sheet sheet;
  for (const RTCGeometry geometry :
       {sheet.newGeometry(device, RTC_GEOMETRY_TYPE_GRID), sheet.newGeometry(device, RTC_GEOMETRY_TYPE_QUAD),
        sheet.newGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE),
        sheet.newGeometry(device, RTC_GEOMETRY_TYPE_GRID, RTC_BUILD_QUALITY_MEDIUM, 2),
        sheet.newGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE, RTC_BUILD_QUALITY_REFIT)}) {
    const RTCScene scene = newScene(geometry, 4);
    CHECK(rtcGetGeometry(scene, 4) == geometry);
    shoot(scene);
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
  }
}

/* All memory is freed, independently of the order of releases. */
void Program::releases() {
  const auto peak = [] {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  long before = 0;
  for (int i = 0; i < 400; i++) {
    if (i == 100) before = peak();
    const RTCGeometry geometry = newCube(120), instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    const RTCScene inner = newScene(geometry), outer = rtcNewScene(device);
    rtcSetGeometryInstancedScene(instance, inner);
    rtcCommitGeometry(instance);
    rtcAttachGeometry(outer, instance);
    rtcCommitScene(outer);
    rtcRetainGeometry(geometry);
    rtcRetainScene(inner);
    rtcReleaseGeometry(geometry);
    if (i % 2) {
      rtcReleaseScene(inner);
      rtcReleaseScene(inner);
      rtcReleaseGeometry(geometry);
    }
    if (i % 3 == 0) rtcDetachGeometry(outer, 0);
    rtcReleaseGeometry(instance);
    rtcReleaseScene(outer);
    if (i % 2 == 0) {
      rtcDetachGeometry(inner, 0);
      rtcReleaseScene(inner);
      rtcReleaseGeometry(geometry);
      rtcReleaseScene(inner);
    }
  }
  CHECK(peak() - before < 16 << 10); // KiB: a third of the memory of three hundred objects
}

void Program::threads() {
  std::vector<std::thread> all;
  std::vector<RTCScene> scenes(4);
  const RTCGeometry shared = newCube();
  for (int k = 0; k < 4; k++)
    all.emplace_back([&, k] {
      for (int i = 0; i < 20; i++) {
        const RTCGeometry own = newCube(float(4 + k));
        const RTCScene scene = rtcNewScene(device);
        rtcAttachGeometry(scene, k % 2 ? own : shared);
        rtcCommitScene(scene);
        rtcReleaseGeometry(own);
        if (i < 19) rtcReleaseScene(scene);
        else scenes[size_t(k)] = scene;
      }
    });
  for (std::thread& thread : all) thread.join();
  all.clear();
  rtcReleaseGeometry(shared);
  for (const RTCScene scene : scenes) {
    shoot(scene);
    rtcReleaseScene(scene);
  }
  /* one commit of several threads */
  const RTCGeometry geometry = newCube();
  const RTCScene scene = rtcNewScene(device);
  rtcAttachGeometry(scene, geometry);
  for (int k = 0; k < 4; k++) all.emplace_back([scene] { rtcJoinCommitScene(scene); });
  for (std::thread& thread : all) thread.join();
  shoot(scene);
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

/* References to a device, also from rtcGetSceneDevice. Geometry is compressed until the last one is released. */
void Program::devices() {
  const RTCDevice own = rtcNewDevice("threads=1");
  rtcRetainDevice(own);
  rtcReleaseDevice(own);
  const RTCScene scene = rtcNewScene(own);
  const RTCDevice same = rtcGetSceneDevice(scene);
  CHECK(same == own);
  rtcReleaseDevice(own); // `same` holds a reference
  const RTCGeometry geometry = host::Cube().newInHost(same, 24);
  rtcAttachGeometryByID(scene, geometry, 2);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  CHECK(rtcGetDeviceError(same) == RTC_ERROR_NONE);
  shoot(scene);
  rtcReleaseScene(scene);
  rtcReleaseDevice(same); // after its scenes, as Embree 4.4 requires
}

/* A device that another function than rtcNewDevice returned, such as one for GPUs. The interposer must leave its
 * geometry to Embree. */
void Program::unknownDevice() {
  void* const embree = dlopen("libembree4.so.4", RTLD_LAZY | RTLD_NOLOAD);
  const auto newDevice = (decltype(&rtcNewDevice))dlsym(embree, "rtcNewDevice"); // not the interposer's
  const RTCDevice unknown = newDevice("threads=1");
  const RTCGeometry geometry = host::Cube().newInHost(unknown, 19); // 2166 quads, for which interposer.sh looks
  const RTCScene scene = rtcNewScene(unknown);
  rtcAttachGeometryByID(scene, geometry, 2);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  shoot(scene);
  rtcReleaseScene(scene);
  rtcReleaseDevice(unknown);
  dlclose(embree);
}

void Program::run() {
  const std::pair<const char*, void (Program::*)()> uses[] = {
#if RTC_VERSION >= 40400
      {"device buffers", &Program::buffersOfDevice},
#endif
      {"plain", &Program::plain},
      {"filters", &Program::filters},
      {"user geometry", &Program::userGeometry},
      {"forwarding", &Program::forwarding},
      {"masks", &Program::masks},
      {"instances", &Program::instances},
      {"edits", &Program::edits},
      {"motion", &Program::motion},
      {"rejections", &Program::rejections},
      {"meshes", &Program::meshes},
      {"threads", &Program::threads},
      {"cancelling", &Program::cancelling},
      {"devices", &Program::devices},
      {"unknown device", &Program::unknownDevice}};
  releases();
  for (const auto& use : uses) {
    hits.begin(use.first);
    (this->*use.second)();
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) std::fprintf(stderr, "%s: error %d of Embree\n", use.first, int(error));
    CHECK(error == RTC_ERROR_NONE);
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  scene_queries::useTraversables = argc == 3;
  if (scene_queries::useTraversables && !scene_queries::haveTraversables) return 2;
  Hits hits(argv[1]);
  const RTCDevice device = rtcNewDevice("threads=2");
  Program(device, hits).run();
  hits.conclude();
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseDevice(device);
  return host::conclude("the same calls");
}
