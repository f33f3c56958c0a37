// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vectors of four floats or integers, for encoders, and for intersectors that convert from and to Double4
 * (double4.h). Results equal the results of scalar code, so that all instruction sets encode the same bytes.
 * Encoders require -ffp-contract=off where compilers could fuse multiplications and additions. CVERT_PORTABLE selects
 * plain C++ instead of SSE and NEON. lanes_sse.h documents the functions. */

#if defined(CVERT_PORTABLE)
#include "lanes_portable.h"
#elif defined(__aarch64__) // tested first, because Embree defines macros of SSE2 on ARM64, too
#include "lanes_neon.h"
#elif defined(__SSE2__)
#include "lanes_sse.h"
#else
#include "lanes_portable.h"
#endif

namespace cvert { inline namespace CVERT_ISA {
/*! Returns vertex i of `count` in lanes 0 to 2; lane 3 is undefined. Reads nothing after the last vertex. */
inline Float4 loadVertex(const float (*vertices)[3], size_t i, size_t count) {
  return i + 1 < count ? Float4::load(vertices[i]) : Float4(vertices[i][0], vertices[i][1], vertices[i][2], 0.0f);
}
}} // namespace cvert::CVERT_ISA
