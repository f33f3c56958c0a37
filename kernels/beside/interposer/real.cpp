// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "real.h"
#include "options.h"

#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <initializer_list>

namespace interposer {

static void* lookUp(const char* name)
{
  if (void* const next = dlsym(RTLD_NEXT, name)) return next;
  for (const char* library : {"libembree4.so.4", "libembree3.so.3"}) {
    void* const handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    if (!handle) continue;
    if (void* const function = dlsym(handle, name)) return function;
    dlclose(handle);
  }
  return nullptr;
}

void* findReal(const char* name)
{
  void* const function = lookUp(name);
  if (!function) {
    std::fprintf(stderr, "libembree_cbvh_interposer: the program calls %s, but has not loaded Embree\n", name);
    std::abort();
  }
  return function;
}

bool isActive()
{
  static const bool is = [] {
    /* exists in Embree 4, but not in Embree 3 */
    return options().isOn && lookUp("rtcInvokeIntersectFilterFromGeometry") != nullptr;
  }();
  return is;
}

} // namespace interposer
