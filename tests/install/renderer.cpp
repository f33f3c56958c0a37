// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Intersects one ray with one triangle, and prints the path of the library.

#include <embree3/rtcore.h>
#include <dlfcn.h>
#include <cmath>
#include <cstdio>

int main() {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const unsigned indices[3] = {0, 1, 2};
  float* v = (float*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3);
  unsigned* i = (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1);
  for (int k = 0; k < 9; k++) v[k] = vertices[k];
  for (int k = 0; k < 3; k++) i[k] = indices[k];
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);

  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = {};
  ray.ray.org_x = ray.ray.org_y = 0.25f;
  ray.ray.org_z = -1;
  ray.ray.dir_z = 1;
  ray.ray.tfar = INFINITY;
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &context, &ray);
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);

  Dl_info info;
  dladdr((void*)&rtcNewDevice, &info);
  std::printf("%s\n", info.dli_fname);
  // Embree divides with the processor's approximate reciprocal: an ulp or two depend on the machine
  return ray.hit.geomID == 0 && std::fabs(ray.ray.tfar - 1) < 1e-6f ? 0 : 1;
}
