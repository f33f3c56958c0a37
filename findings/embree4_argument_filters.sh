#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# Embree 4 passes a filter function in the arguments of a query. The manual says that the scene flag
# RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS enables scene support for such functions.
#
# Guess: in a scene without the flag, the function is not called.
#
# Seen (Embree 4.3.3 of Debian 13; also 4.4.1): it is called, and no error is reported. The flag changes nothing. Our
# interposer therefore calls the function in scenes without the flag, too.
. "$(dirname -- "$0")/debian_root.sh"
install_pinned trixie libembree4-4=4.3.3+dfsg-1 libembree-dev=4.3.3+dfsg-1

cat > "$root/filter.c" << 'PROGRAM'
#include <embree4/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int calls;
static void filter(const struct RTCFilterFunctionNArguments* args) {
  (void)args;
  calls++;
}

static RTCScene newScene(RTCDevice device, enum RTCSceneFlags flags) {
  const float triangle[9] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
  const unsigned indices[3] = {0, 1, 2};
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3), triangle, 36);
  memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1), indices, 12);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneFlags(scene, flags);
  rtcCommitScene(scene);
  return scene;
}

int main(void) {
  RTCDevice device = rtcNewDevice(NULL);
  const enum RTCSceneFlags flags[2] = {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS};
  for (int i = 0; i < 2; i++) {
    RTCScene scene = newScene(device, flags[i]);
    struct RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    args.filter = filter;
    args.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    struct RTCRayHit ray;
    memset(&ray, 0, sizeof(ray));
    ray.ray.org_z = 1;
    ray.ray.dir_z = -1;
    ray.ray.tfar = INFINITY;
    ray.ray.mask = -1u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    calls = 0;
    rtcIntersect1(scene, &ray, &args);
    printf("%s%d, error %d", i ? "; with it: " : "calls without the flag: ", calls, (int)rtcGetDeviceError(device));
    rtcReleaseScene(scene);
  }
  puts("");
  rtcReleaseDevice(device);
  return 0;
}
PROGRAM
usr=$root/system/usr
mkdir -p "$usr/bin"
cc -I "$usr/include" "$root/filter.c" -o "$usr/bin/filter" -Wl,--allow-shlib-undefined \
  "$(find "$usr/lib" -name 'libembree4.so.4')"
observe "one ray" "calls without the flag: 1, error 0; with it: 1, error 0" "$(in_root filter)"
