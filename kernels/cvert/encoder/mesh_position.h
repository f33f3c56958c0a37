// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Positions as keys of hash tables, by which mesh encoders find equal vertices. */

#include "../portable/language.h"
#include <cstring>

namespace cvert { inline namespace CVERT_ISA {
/*! The bits of three coordinates. Positions with equal coordinates have equal bits, because -0 becomes 0, as
 *  denormal numbers do if the CPU flushes them. */
struct MeshPosition {
  uint32_t words[3];

  MeshPosition() {} // undefined
  explicit MeshPosition(const float p[3]) {
    for (int k = 0; k < 3; k++) words[k] = bitsOfFloat(p[k] + 0.0f); // -0 + 0 is 0
  }

  bool operator==(const MeshPosition& other) const { return std::memcmp(words, other.words, sizeof(words)) == 0; }

  /*! Tables use the upper bits of the result. */
  uint32_t hash() const {
    const uint32_t h = (words[0] * 0x9E3779B1u) ^ (words[1] * 0x85EBCA77u) ^ (words[2] * 0xC2B2AE3Du);
    return (h ^ (h >> 15)) * 0x2C1B3C6Du;
  }
};
}} // namespace cvert::CVERT_ISA
