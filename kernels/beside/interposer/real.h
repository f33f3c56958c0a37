// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to Embree's own functions, which this library overrides. */

#include <embree4/rtcore.h>

namespace interposer {

/* Returns Embree's function: the next one after this library in the dynamic linker's search order, or else from an
 * Embree loaded with RTLD_LOCAL, which then stays loaded. Aborts the program if there is none. */
void* findReal(const char* name);

/* True if the program uses Embree 4, and the environment does not disable this library. Otherwise calls are forwarded
 * unchanged, because Embree 3 has functions of the same names with other arguments. */
bool isActive();

} // namespace interposer

/* Example: REAL(rtcNewScene)(device) calls Embree's rtcNewScene. Looks up the function once per call site. */
#define REAL(name) \
  ([]() -> decltype(&::name) { \
    static const auto function = (decltype(&::name))interposer::findReal(#name); \
    return function; \
  }())
