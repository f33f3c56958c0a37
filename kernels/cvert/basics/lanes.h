// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vectors of four floats or integers, for encoders. Every operation rounds as the scalar one does, so the bytes of
 * blocks do not depend on the instruction set. Compile with -ffp-contract=off: fused multiply-adds would break this.
 * CVERT_PORTABLE disables SSE and NEON. */

#if defined(CVERT_PORTABLE)
#include "lanes_portable.h"
#elif defined(__aarch64__) // tested first: Embree defines SSE2 there, too
#include "lanes_neon.h"
#elif defined(__SSE2__)
#include "lanes_sse.h"
#else
#include "lanes_portable.h"
#endif

namespace cvert { inline namespace CVERT_ISA
{
  /*! Vertex i of `count` in lanes 0 to 2. Lane 3 is undefined. */
  inline Float4 loadVertex(const float (*vertices)[3], size_t i, size_t count) {
    return i+1 < count ? Float4::load(vertices[i]) : Float4(vertices[i][0],vertices[i][1],vertices[i][2],0.0f);
  }
}}
