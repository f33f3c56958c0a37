// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Independent of Embree, for kernels/capi. */

#include <locale>
#include <sstream>
#include <string>

namespace embree {
/*! Text of a float in every locale, with as many digits as reading it back requires. std::to_string prints 1e-7 as
 *  0.000000. */
inline std::string numberText(float number) {
  std::string text;
  for (int digits = 6; digits <= 9; digits++) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(digits);
    out << number;
    text = out.str();
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    float read;
    if ((in >> read) && read == number) break;
  }
  return text;
}
} // namespace embree
