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

static bool isRealEmbree4() {
  /* Compares the libraries, because a program on Embree 3 may have a plugin with an Embree 4 of its own. */
  const void* const intersect = findFunction("rtcIntersect1");
  const void* const onlyIn4 = findFunction("rtcInvokeIntersectFilterFromGeometry");
  Dl_info real, embree4;
  return intersect && onlyIn4 && dladdr(intersect, &real) && dladdr(onlyIn4, &embree4) &&
         real.dli_fbase == embree4.dli_fbase;
}

bool isActive() {
  static const bool active = [] {
    bool isOn = false;
    guarded("EMBREE_CBVH", [&] { isOn = options().isOn; });
    return isOn && isRealEmbree4();
  }();
  return active;
}

} // namespace interposer
