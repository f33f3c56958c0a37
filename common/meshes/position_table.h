// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds equal positions, for formats that repeat them at each triangle. */

#include "basics/vec.h"

#include <cstdint>
#include <cstring>
#include <vector>

namespace programs {

class PositionTable {
public:
  /* Appends to `positions`, which must outlive the table. */
  explicit PositionTable(std::vector<Vec3d>& positions) : positions(positions), slots(1024, none) {}

  /* Returns the index of the position, which is appended if none is equal: distances do not matter, and -0 equals 0.
   * Must not be called with NaN. */
  unsigned add(Vec3d p) {
    p = p + Vec3d{0, 0, 0}; // turns -0 into 0
    if (2 * positions.size() >= slots.size()) grow();
    size_t slot = hash(p) & (slots.size() - 1);
    for (; slots[slot] != none; slot = (slot + 1) & (slots.size() - 1)) {
      const Vec3d& other = positions[slots[slot]];
      if (other.x == p.x && other.y == p.y && other.z == p.z) return slots[slot];
    }
    slots[slot] = unsigned(positions.size());
    positions.push_back(p);
    return slots[slot];
  }

private:
  static constexpr unsigned none = ~0u;

  static size_t hash(const Vec3d& p) {
    uint64_t words[3], h = 0;
    std::memcpy(words, &p, sizeof(words));
    for (const uint64_t word : words) h = (h ^ word) * 0x9E3779B97F4A7C15ull, h ^= h >> 32;
    return size_t(h);
  }

  void grow() {
    std::vector<unsigned>(2 * slots.size(), none).swap(slots);
    for (size_t i = 0; i < positions.size(); i++) {
      size_t slot = hash(positions[i]) & (slots.size() - 1);
      while (slots[slot] != none) slot = (slot + 1) & (slots.size() - 1);
      slots[slot] = unsigned(i);
    }
  }

  std::vector<Vec3d>& positions;
  std::vector<unsigned> slots; // a power of two
};

} // namespace programs
