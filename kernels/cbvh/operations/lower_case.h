// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Names that are not case-sensitive. Independent of Embree, for libembree3_vulkan and the interposer. */

#include <string>

namespace embree {
/*! Converts A to Z only, unlike std::tolower, which depends on the locale: a Turkish one does not convert I to i. */
inline std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = char(c + ('a' - 'A'));
  return text;
}
} // namespace embree
