/* Copyright 2026 The Embree CBVH authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * Preloaded into Open3D 0.16, which leaves the masks of its rays 0: such rays hit nothing in Debian's Embree, which
 * supports masks. Sets all bits of each mask, and passes the rays on.
 *
 *   cc -shared -fPIC open3d_masks.c -ldl -o open3d_masks.so
 */

#include <embree3/rtcore.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

/* Python loads Embree as a dependency of a module, where RTLD_NEXT does not find it. */
static void* find(const char* name) {
  void *embree = dlopen("libembree3.so.3", RTLD_NOW | RTLD_NOLOAD), *found = embree ? dlsym(embree, name) : NULL;
  if (found) return found;
  fprintf(stderr, "open3d_masks: %s is not in a loaded libembree3.so.3\n", name);
  exit(1);
}

void rtcIntersect1M(RTCScene scene, struct RTCIntersectContext* context, struct RTCRayHit* rays, unsigned int count,
                    size_t stride) {
  void (*trace)(RTCScene, struct RTCIntersectContext*, struct RTCRayHit*, unsigned int, size_t);
  *(void**)&trace = find("rtcIntersect1M");
  for (unsigned int i = 0; i < count; i++) ((struct RTCRayHit*)((char*)rays + i * stride))->ray.mask = ~0u;
  trace(scene, context, rays, count, stride);
}

void rtcOccluded1M(RTCScene scene, struct RTCIntersectContext* context, struct RTCRay* rays, unsigned int count,
                   size_t stride) {
  void (*trace)(RTCScene, struct RTCIntersectContext*, struct RTCRay*, unsigned int, size_t);
  *(void**)&trace = find("rtcOccluded1M");
  for (unsigned int i = 0; i < count; i++) ((struct RTCRay*)((char*)rays + i * stride))->mask = ~0u;
  trace(scene, context, rays, count, stride);
}
