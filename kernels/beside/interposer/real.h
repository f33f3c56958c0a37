// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's original functions that this library overrides. */

#include <embree4/rtcore.h>

namespace interposer {

/* Returns the next function after this library in symbol order, or that of the loaded libembree4 if a module loaded
 * Embree with local visibility. Aborts the program if there is none. */
void* findReal(const char* name);

/* True if the program uses Embree 4, and the environment does not disable this library. Embree 3 has functions of the
 * same names with other arguments; calls are then forwarded unchanged. */
bool isActive();

} // namespace interposer

/* REAL(rtcNewScene)(device) */
#define REAL(name) \
  ([]() -> decltype(&::name) { \
    static const auto function = (decltype(&::name))interposer::findReal(#name); \
    return function; \
  }())
