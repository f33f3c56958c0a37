// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to Embree's own functions, which this library overrides. */

#include <embree4/rtcore.h>

namespace interposer {

/* Returns Embree's function of this name: the next one after this library in the dynamic linker's search order. If
 * there is none, searches an Embree that was loaded with RTLD_LOCAL, and keeps it loaded if it has the function. Aborts
 * the program if no loaded Embree has the function. */
void* findReal(const char* name);

/* False if the environment does not request compression, or REAL finds the functions of an Embree before 4.3, whose
 * arguments or hits differ. All calls are then forwarded unchanged. */
bool isActive();

} // namespace interposer

/* Example: REAL(rtcNewScene)(device) calls Embree's rtcNewScene. Looks up the function once per call site. */
#define REAL(name) \
  ([]() -> decltype(&::name) { \
    static const auto function = (decltype(&::name))interposer::findReal(#name); \
    return function; \
  }())
