// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Four floats or integers at a time, for encoders. Every operation rounds as the scalar one does, so that blocks are the same bytes whatever
 * they are compiled for. The exception is a compiler that fuses multiply and add, in scalar code as here: where that is possible,
 * -ffp-contract=off keeps the bytes. Define CVERT_PORTABLE to do without SSE and NEON. */

#if defined(CVERT_PORTABLE)
#include "lanes_portable.h"
#elif defined(__aarch64__) // before SSE2, which Embree defines there, too
#include "lanes_neon.h"
#elif defined(__SSE2__)
#include "lanes_sse.h"
#else
#include "lanes_portable.h"
#endif

namespace cvert { inline namespace CVERT_ISA
{
  /*! vertex i of count in lanes 0 to 2; lane 3 has any number */
  inline Float4 loadVertex(const float (*vertices)[3], size_t i, size_t count) {
    return i+1 < count ? Float4::load(vertices[i]) : Float4(vertices[i][0],vertices[i][1],vertices[i][2],0.0f);
  }
}}
