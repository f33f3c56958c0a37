// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Point queries of Embree 4 through instances and instance arrays. Embree calls the query's function for meshes but not
 * for subdivision surfaces. The calls must be the same with the interposer, which replaces these by user geometry.
 * Depends only on the parts of host.h for Embree.
 *
 *   points [traversables|without-function]     queries traversables instead of scenes, or runs only a query without a
 *                                              function */

#include "../host.h"
#include "scene_queries.h"

#include <set>
#include <string>
#include <utility>

namespace {

constexpr unsigned none = RTC_INVALID_GEOMETRY_ID;

/* A call of the query's function. */
struct Call {
  unsigned instID, instPrimID, geomID;

  bool operator<(const Call& b) const {
    return instID != b.instID           ? instID < b.instID
           : instPrimID != b.instPrimID ? instPrimID < b.instPrimID
                                        : geomID < b.geomID;
  }
};
typedef std::set<Call> Calls;

bool keep(RTCPointQueryFunctionArguments* args) {
  const RTCPointQueryContext& context = *args->context;
  const bool isInstanced = context.instStackSize > 0;
  ((Calls*)args->userPtr)
      ->insert({isInstanced ? context.instID[0] : none, isInstanced ? context.instPrimID[0] : none, args->geomID});
  return false;
}

std::string textOf(const Calls& calls) {
  std::string text;
  for (const Call& call : calls)
    text += " (instance " + std::to_string(int(call.instID)) + ", " + std::to_string(int(call.instPrimID)) +
            ": geometry " + std::to_string(int(call.geomID)) + ")";
  return text.empty() ? " no calls" : text;
}

constexpr unsigned arrayID = 3; // of an array in its scene

/* Both scenes contain a subdivision surface and a mesh, with the IDs 0 and 1 in `surfaceFirst`, and 1 and 0 in
 * `meshFirst`. Embree calls the function for the mesh only. */
constexpr unsigned meshOfSurfaceFirst = 1, meshOfMeshFirst = 0;

class Test {
public:
  explicit Test(RTCDevice device) : device(device), surfaceFirst(newScene(1)), meshFirst(newScene(0)) {}
  ~Test() {
    rtcReleaseScene(surfaceFirst);
    rtcReleaseScene(meshFirst);
  }

  void run();
  void queryWithoutFunction();

private:
  RTCScene newScene(unsigned meshID);
  RTCGeometry newArray(unsigned numInstances);
  void setScenes(RTCGeometry array, std::vector<RTCScene> scenes) {
    rtcSetGeometryInstancedScenes(array, scenes.data(), scenes.size());
  }
  void expect(const char* name, RTCGeometry array, const std::vector<unsigned>& geomIDs);

  void indices();
  void scenes();
  void rejectedCalls();
  void singleInstance();
  void releases();
  void ownInstances();

  const RTCDevice device;
  const RTCScene surfaceFirst, meshFirst;
};

RTCScene Test::newScene(unsigned meshID) {
  const RTCScene scene = rtcNewScene(device);
  const RTCGeometry cube = host::Cube().newInHost(device, 4), mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* const vertices = (float*)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3);
  unsigned* const indices = (unsigned*)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1);
  for (unsigned i = 0; i < 9; i++) vertices[i] = i % 4 == 0 ? 0.5f : 0;
  for (unsigned i = 0; i < 3; i++) indices[i] = i;
  rtcCommitGeometry(mesh);
  rtcAttachGeometryByID(scene, mesh, meshID);
  rtcAttachGeometryByID(scene, cube, 1 - meshID);
  rtcReleaseGeometry(mesh);
  rtcReleaseGeometry(cube);
  rtcCommitScene(scene);
  return scene;
}

/* Sets the transformations of an array: instance i is at x = 10 i. */
void place(RTCGeometry array, unsigned numInstances) {
  float* const places = (float*)rtcSetNewGeometryBuffer(array, RTC_BUFFER_TYPE_TRANSFORM, 0,
                                                        RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, 48, numInstances);
  for (unsigned i = 0; i < 12 * numInstances; i++)
    places[i] = i % 12 == 9 ? 10 * float(i / 12) : i % 12 % 4 == 0 ? 1 : 0;
}

RTCGeometry Test::newArray(unsigned numInstances) {
  const RTCGeometry array = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE_ARRAY);
  place(array, numInstances);
  return array;
}

/* Runs point queries at the instances of an array in a new scene. geomIDs: for each instance, the ID of the geometry
 * for which Embree calls the function, or `none`. */
void Test::expect(const char* name, RTCGeometry array, const std::vector<unsigned>& geomIDs) {
  rtcCommitGeometry(array);
  const RTCScene scene = rtcNewScene(device);
  rtcAttachGeometryByID(scene, array, arrayID);
  rtcCommitScene(scene);
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  Calls expected, calls;
  alignas(16) int valid[4] = {0, 0, 0, 0};
  RTCPointQuery4 packet;
  Calls packetCalls;
  void* userPtrs[4] = {&packetCalls, &packetCalls, &packetCalls, &packetCalls};
  for (unsigned i = 0; i < geomIDs.size(); i++) {
    if (geomIDs[i] != none) expected.insert({arrayID, i, geomIDs[i]});
    RTCPointQuery query = {10 * float(i), 0, 0, 0, 2};
    scene_queries::pointQuery(scene, &query, &context, keep, &calls);
    packet.x[i] = query.x;
    packet.y[i] = query.y;
    packet.z[i] = query.z;
    packet.time[i] = query.time;
    packet.radius[i] = query.radius;
    valid[i] = -1;
  }
  scene_queries::pointQuery(valid, scene, &packet, &context, keep, userPtrs);
  for (const Calls* const found : {&calls, &packetCalls})
    if (found->size() != expected.size() || textOf(*found) != textOf(expected)) {
      std::fprintf(stderr, "%s:%s, expected%s\n", name, textOf(*found).c_str(), textOf(expected).c_str());
      host::failures++;
    }
  rtcReleaseScene(scene);
}

/* The index buffer in all ways to set it, and its edits. */
void Test::indices() {
  const RTCGeometry array = newArray(4);
  setScenes(array, {surfaceFirst, meshFirst});
  unsigned* const own = (unsigned*)rtcSetNewGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, 4);
  const unsigned first[4] = {0, 1, 1, 0}, second[4] = {1, 0, 0, 1};
  std::copy(first, first + 4, own);
  const std::vector<unsigned> ofFirst = {meshOfSurfaceFirst, meshOfMeshFirst, meshOfMeshFirst, meshOfSurfaceFirst},
                              ofSecond = {meshOfMeshFirst, meshOfSurfaceFirst, meshOfSurfaceFirst, meshOfMeshFirst};
  expect("a buffer of the array", array, ofFirst);
  std::copy(second, second + 4, own);
  rtcUpdateGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0);
  expect("an edited buffer of the array", array, ofSecond);

  unsigned shared[2 + 3 * 4];
  for (unsigned& index : shared) index = 1000;
  for (unsigned i = 0; i < 4; i++) shared[2 + 3 * i] = first[i];
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, shared, 8, 12, 4);
  expect("a shared buffer", array, ofFirst);
  for (unsigned i = 0; i < 4; i++) shared[2 + 3 * i] = second[i];
  rtcUpdateGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0);
  expect("an edited shared buffer", array, ofSecond);
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, &second[1], 0, 0, 4);
  expect("a stride of 0", array, std::vector<unsigned>(4, meshOfSurfaceFirst));

#if RTC_VERSION >= 40400
  void* ownPair = nullptr;
  rtcSetNewGeometryBufferHostDevice(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, 4, &ownPair, nullptr);
  std::copy(first, first + 4, (unsigned*)ownPair);
  expect("a buffer pair of the array", array, ofFirst);
  rtcSetSharedGeometryBufferHostDevice(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, shared, nullptr, 8, 12, 4);
  expect("a shared buffer pair", array, ofSecond);
#endif

  const RTCBuffer buffer = rtcNewBuffer(device, 16 + 8 * 4);
  unsigned* const data = (unsigned*)rtcGetBufferData(buffer) + 4;
  for (unsigned i = 0; i < 4; i++) data[2 * i] = first[i], data[2 * i + 1] = 1000;
  rtcSetGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, buffer, 16, 8, 4);
  rtcReleaseBuffer(buffer); // the array holds a reference
  expect("a buffer object", array, ofFirst);
  data[2] = none;
  expect("an instance without scene", array, {meshOfSurfaceFirst, none, meshOfMeshFirst, meshOfSurfaceFirst});
  rtcReleaseGeometry(array);
}

/* The array's scenes, and their edits. */
void Test::scenes() {
  const RTCGeometry array = newArray(3);
  const unsigned indices[3] = {2, 0, 1};
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, 3);
  setScenes(array, {surfaceFirst, meshFirst, meshFirst});
  expect("three scenes", array, {meshOfMeshFirst, meshOfSurfaceFirst, meshOfMeshFirst});
  setScenes(array, {meshFirst, meshFirst, surfaceFirst});
  expect("other scenes", array, {meshOfSurfaceFirst, meshOfMeshFirst, meshOfMeshFirst});
  const unsigned lastTwo[3] = {1, 2, 1};
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, lastTwo, 0, 4, 3);
  setScenes(array, {nullptr, meshFirst, surfaceFirst});
  expect("an unused null", array, {meshOfMeshFirst, meshOfSurfaceFirst, meshOfMeshFirst});
  rtcSetGeometryInstancedScene(array, surfaceFirst);
  expect("a scene for all instances", array, std::vector<unsigned>(3, meshOfSurfaceFirst));
  setScenes(array, {meshFirst, meshFirst, meshFirst});
  expect("scenes after a scene for all instances", array, std::vector<unsigned>(3, meshOfSurfaceFirst));
  rtcReleaseGeometry(array);
}

/* Calls that Embree rejects change nothing. */
void Test::rejectedCalls() {
  const RTCGeometry array = newArray(2), instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  const unsigned indices[4] = {0, 1, 0, 0};
  const std::vector<unsigned> geomIDs = {meshOfSurfaceFirst, meshOfMeshFirst};
  setScenes(array, {surfaceFirst, meshFirst});
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, 2);
  expect("a shared buffer", array, geomIDs);
  const auto isRejected = [&] { return rtcGetDeviceError(device) != RTC_ERROR_NONE; };
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT2, indices, 0, 8, 2);
  CHECK(isRejected());
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 1, RTC_FORMAT_UINT, indices, 0, 8, 2);
  CHECK(isRejected());
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices + 1, 2, 4, 2);
  CHECK(isRejected());
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 6, 2);
  CHECK(isRejected());
#if RTC_VERSION >= 40400
  const RTCBuffer pair = rtcNewSharedBufferHostDevice(device, (void*)indices, 8);
  rtcSetGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, pair, 0, 12, 2);
  CHECK(isRejected());
  rtcReleaseBuffer(pair);
#endif
  rtcSetGeometryInstancedScene(array, nullptr);
  CHECK(isRejected());
  rtcSetGeometryInstancedScenes(array, nullptr, 2);
  CHECK(isRejected());
  expect("rejected calls", array, geomIDs);
  rtcSetGeometryInstancedScene(instance, meshFirst);
  setScenes(instance, {surfaceFirst});
  CHECK(isRejected());
  rtcSetGeometryInstancedScene(instance, nullptr);
  CHECK(isRejected());
  expect("rejected calls for an instance", instance, {meshOfMeshFirst});
  rtcReleaseGeometry(instance);
  rtcReleaseGeometry(array);
}

/* Embree 4.3 and 4.4 give a single instance the first scene, whatever its index, and keep that scene. */
void Test::singleInstance() {
  const RTCGeometry array = newArray(1);
  const unsigned indices[2] = {1, 0};
  setScenes(array, {surfaceFirst, meshFirst});
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, 1);
  expect("a single instance", array, {meshOfSurfaceFirst});
  place(array, 2);
  rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, 2);
  expect("a single instance that became two", array, {meshOfSurfaceFirst, meshOfSurfaceFirst});
  rtcReleaseGeometry(array);
}

/* An array holds references to its scenes, also to the scene that it keeps when it gets others. */
void Test::releases() {
  for (const bool isSingle : {false, true}) {
    const RTCGeometry array = newArray(isSingle ? 1 : 2);
    const unsigned indices[2] = {0, 1};
    rtcSetSharedGeometryBuffer(array, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, indices, 0, 4, isSingle ? 1 : 2);
    const RTCScene first = newScene(1), second = newScene(0);
    if (isSingle) {
      setScenes(array, {first});
      rtcCommitGeometry(array);
    } else rtcSetGeometryInstancedScene(array, first);
    setScenes(array, {second, second});
    rtcReleaseScene(second);
    rtcReleaseScene(first);
    expect("scenes that the program released", array, std::vector<unsigned>(isSingle ? 1 : 2, meshOfSurfaceFirst));
    const RTCScene outer = rtcNewScene(device);
    rtcAttachGeometry(outer, array);
    rtcCommitScene(outer);
    RTCRayHit ray = host::makeRay({0.1f, 0.1f, 5}, {0, 0, -1});
    host::intersect(outer, ray);
    CHECK(ray.hit.geomID == 0 && ray.hit.instID[0] == 0); // the subdivision surface
    rtcReleaseScene(outer);
    rtcReleaseGeometry(array);
  }
}

/* The program enters an instance itself: it puts the instance on the stack and queries the inner scene. */
void Test::ownInstances() {
  for (const auto& inner : {std::make_pair(surfaceFirst, meshOfSurfaceFirst), {meshFirst, meshOfMeshFirst}})
    for (const unsigned instID : {0u, 1u, 7u}) {
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      for (int i = 0; i < 16; i++) context.world2inst[0][i] = context.inst2world[0][i] = i % 5 == 0 ? 1 : 0;
      context.instID[0] = instID;
      context.instPrimID[0] = 0;
      context.instStackSize = 1;
      RTCPointQuery query = {0, 0, 0, 0, 2};
      Calls calls;
      scene_queries::pointQuery(inner.first, &query, &context, keep, &calls);
      const Calls expected = {{instID, 0, inner.second}};
      if (textOf(calls) != textOf(expected)) {
        std::fprintf(stderr, "a program's instance:%s, expected%s\n", textOf(calls).c_str(), textOf(expected).c_str());
        host::failures++;
      }
    }
}

void Test::queryWithoutFunction() {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query = {0, 0, 0, 0, 2};
  scene_queries::pointQuery(surfaceFirst, &query, &context, nullptr, nullptr);
}

void Test::run() {
  indices();
  scenes();
  rejectedCalls();
  singleInstance();
  releases();
  ownInstances();
}

} // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  scene_queries::useTraversables = mode == "traversables";
  if (scene_queries::useTraversables && !scene_queries::haveTraversables) return 2;
  const RTCDevice device = rtcNewDevice("threads=2");
  if (mode == "without-function") Test(device).queryWithoutFunction();
  else Test(device).run();
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseDevice(device);
  return host::conclude("point queries through instances");
}
