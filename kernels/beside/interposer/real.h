// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's own functions behind those of this library that have their names. */

#include <embree4/rtcore.h>

namespace interposer {

/* Looks up a function of the Embree that the program has: that behind this library in the order of symbols, or, where a module was loaded with Embree out of
 * sight of others, that of the libembree4 that is loaded. Ends the program where there is none. */
void* findReal(const char* name);

/* Whether that is an Embree 4, and the environment does not turn us off: of Embree 3 functions of the same names have other arguments, and all are forwarded as
 * they are. */
bool isActive();

} // namespace interposer

/* REAL(rtcNewScene)(device) */
#define REAL(name) ([]() -> decltype(&::name) { static const auto function = (decltype(&::name))interposer::findReal(#name); return function; }())
