// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The widest vectors that an instruction set has, for sixteen things in a row. */

#include "../embree/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
#if defined(__AVX512F__)
      static const int vectorWidth = 16;
#elif defined(__AVX__)
      static const int vectorWidth = 8;
#else
      static const int vectorWidth = 4;
#endif
      typedef vfloat<vectorWidth> vfloatV;
      typedef vint<vectorWidth> vintV;
      typedef vboolf<vectorWidth> vboolV;
    }
  }
}
