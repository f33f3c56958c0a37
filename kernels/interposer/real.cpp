// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "real.h"
#include "guarded.h"

#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <initializer_list>

namespace interposer {

/* As findReal, but returns NULL if no loaded Embree has the function. */
static void* findFunction(const char* name) {
  if (void* const next = dlsym(RTLD_NEXT, name)) return next;
  /* A plugin that the program loaded with RTLD_LOCAL also calls this library, but RTLD_NEXT does not find the plugin's
   * Embree. RTLD_NOLOAD opens only libraries that are loaded already. */
  for (const char* library : {"libembree4.so.4", "libembree3.so.3"}) {
    void* const handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    if (!handle) continue;
    if (void* const function = dlsym(handle, name)) return function; // the open handle keeps the library loaded
    dlclose(handle);
  }
  return nullptr;
}

void* findReal(const char* name) {
  void* const function = findFunction(name);
  if (!function) {
    std::fprintf(stderr,
                 "libembree_cbvh_interposer: the program calls %s, which no loaded library provides: expected "
                 "libembree4.so.4 or libembree3.so.3\n",
                 name);
    std::abort();
  }
  return function;
}

/* True if the library of REAL(rtcIntersect1) contains this function. Compares the libraries, because a program on
 * Embree 3 may have a plugin with an Embree 4 of its own. */
static bool isInRealEmbree(const char* name) {
  const void *const intersect = findFunction("rtcIntersect1"), *const function = findFunction(name);
  Dl_info real, found;
  return intersect && function && dladdr(intersect, &real) && dladdr(function, &found) &&
         real.dli_fbase == found.dli_fbase;
}

static bool isSupportedEmbree() {
  if (!isInRealEmbree("rtcInvokeIntersectFilterFromGeometry")) return false; // Embree 3
  if (isInRealEmbree("rtcGetGeometryTransformEx")) return true;
  warnOnce("the program's Embree 4 is too old, nothing is compressed: expected 4.3 or later");
  return false;
}

bool isActive() {
  static const bool active = [] {
    bool isOn = false;
    guarded("EMBREE_CBVH", [&] { isOn = options().isOn; });
    return isOn && isSupportedEmbree();
  }();
  return active;
}

} // namespace interposer
