// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* random_numbers.h, lights.h and path.h compile as C++ and as GLSL with these definitions, so the CPU's picture is
 * the reference of the Vulkan device's.
 *
 * Shared code consists of free functions on plain values: no references, no member functions, and no braces around
 * values. */

#ifndef PATH_LANGUAGE_H
#define PATH_LANGUAGE_H

#ifdef VULKAN // defined by glslc

#define PATH_BEGIN
#define PATH_END
#define PATH_FUNCTION
#define PATH_CONSTANT const
#define uint32_t uint
#define TracedScene uvec2 // address for cbvhIntersect

vec3 vector(float x, float y, float z) { return vec3(x, y, z); }

#else

#include "basics/vec.h"
#include <embree3/rtcore.h>
#include <cmath>
#include <cstddef>
#include <cstdint>

#define PATH_BEGIN \
  namespace programs { \
  namespace path {
#define PATH_END \
  } \
  }
#define PATH_FUNCTION inline
#define PATH_CONSTANT static constexpr

namespace programs::path {

using vec3 = Vec3f;
using TracedScene = RTCScene;
using std::abs;
using std::max;
using std::sqrt;

inline vec3 vector(float x, float y, float z) { return {x, y, z}; }

} // namespace programs::path

#endif

#endif
