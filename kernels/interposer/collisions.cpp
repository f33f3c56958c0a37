// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Overrides Embree's search for collisions, which supports only user geometry. Collisions of substitutes, which are
 * user geometry, are not passed on: the application does not know their primitives. */

#include "objects.h"
#include "options.h"

namespace interposer { namespace {

struct Collisions {
  RTCScene scenes[2];
  RTCCollideFunc function;
  void* userPtr;
};

bool isSubstituted(RTCScene scene, unsigned int geomID) {
  RTCPointQueryContext noInstances;
  noInstances.instStackSize = 0;
  return Objects::get().findSubstitute(scene, noInstances, 0, geomID) != nullptr;
}

/* Called by several threads at the same time, each with its own array. */
void callWithoutSubstitutes(void* ptr, RTCCollision* collisions, unsigned int count) {
  const Collisions& search = *(const Collisions*)ptr;
  unsigned int numKept = 0;
  for (unsigned int i = 0; i < count; i++)
    if (!isSubstituted(search.scenes[0], collisions[i].geomID0) &&
        !isSubstituted(search.scenes[1], collisions[i].geomID1))
      collisions[numKept++] = collisions[i];
  if (numKept > 0) search.function(search.userPtr, collisions, numKept);
}

}} // namespace interposer

using namespace interposer;

RTC_API void rtcCollide(RTCScene scene0, RTCScene scene1, RTCCollideFunc callback, void* userPtr) {
  if (!hasSubstitutes() || !isActive()) {
    REAL(rtcCollide)(scene0, scene1, callback, userPtr);
    return;
  }
  warnOnce("rtcCollide does not find compressed geometry");
  Collisions search = {{scene0, scene1}, callback, userPtr};
  REAL(rtcCollide)(scene0, scene1, callWithoutSubstitutes, &search);
}
