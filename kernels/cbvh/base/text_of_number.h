// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Numbers in messages. */

#include <cstdio>
#include <cstdlib>
#include <string>

namespace embree
{
  inline std::string textOf (int x) { return std::to_string(x); }

  /*! Returns a short text that converts to the same float. std::to_string would write 0.000000 for small numbers. */
  inline std::string textOf (float x)
  {
    char text[32];
    for (int digits=6; digits<=9; digits++) {
      std::snprintf(text,sizeof(text),"%.*g",digits,double(x));
      if (std::strtof(text,nullptr) == x) break;
    }
    return text;
  }
}
