// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Searches for collisions of a box with a scene of a box and a compressed cube. Embree supports only user geometry, so
 * this program requires the interposer, which must report collisions with the box only. */

#include "../host.h"

#include <mutex>
#include <set>

namespace {

constexpr unsigned boxID = 3, cubeID = 1;

struct Found {
  std::mutex mutex;
  std::set<unsigned> geomIDs;
};

void bound(const RTCBoundsFunctionArguments* args) { *args->bounds_o = {-0.1f, -0.1f, -0.9f, 0, 0.1f, 0.1f, 0.9f, 0}; }

void keep(void* ptr, RTCCollision* collisions, unsigned count) {
  Found& found = *(Found*)ptr;
  const std::lock_guard<std::mutex> lock(found.mutex);
  for (unsigned i = 0; i < count; i++) {
    CHECK(collisions[i].geomID0 == boxID && collisions[i].primID0 == 0 && collisions[i].primID1 == 0);
    found.geomIDs.insert(collisions[i].geomID1);
  }
}

RTCScene newScene(RTCDevice device, bool hasCube) {
  const RTCScene scene = rtcNewScene(device);
  const RTCGeometry box = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER), cube = host::Cube().newInHost(device, 8);
  rtcSetGeometryUserPrimitiveCount(box, 1);
  rtcSetGeometryBoundsFunction(box, bound, nullptr);
  rtcCommitGeometry(box);
  rtcAttachGeometryByID(scene, box, boxID);
  if (hasCube) rtcAttachGeometryByID(scene, cube, cubeID);
  rtcReleaseGeometry(box);
  rtcReleaseGeometry(cube);
  rtcCommitScene(scene);
  return scene;
}

} // namespace

int main() {
  const RTCDevice device = rtcNewDevice("threads=2");
  const RTCScene box = newScene(device, false), both = newScene(device, true);
  Found found;
  rtcCollide(box, both, keep, &found);
  CHECK(found.geomIDs == std::set<unsigned>{boxID});
  CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  rtcReleaseScene(box);
  rtcReleaseScene(both);
  rtcReleaseDevice(device);
  return host::conclude("collisions");
}
