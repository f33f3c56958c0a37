// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surface numbers. Scenes share the blocks of a geometry, which may have a different ID in each scene. Blocks therefore
 * store a number that is unique in the process, and each scene maps numbers to its IDs when a hit is reported
 * (report_hit.h).
 *
 * If a scene has no compressed static geometry, Embree traces its static cages, and their GridSOAs store IDs instead of
 * numbers. Numbers of moving surfaces have an additional bit, movingSurface, which no ID has. */

#include "codec_names.h"
#include "../../cvert/format/limits.h"
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace embree::cbvh {
/*! A number that no other surface has while this object exists. */
class SurfaceNumber {
public:
  /*! Allocates the lowest free number, or fileNumber if it is free, so that the blocks of a file need not be
   *  changed. fileNumber: at least firstFileNumber, without the bit movingSurface. Thread-safe. */
  explicit SurfaceNumber(uint32_t fileNumber = none);
  ~SurfaceNumber();
  SurfaceNumber(const SurfaceNumber&) = delete;
  SurfaceNumber& operator=(const SurfaceNumber&) = delete;
  operator uint32_t() const { return value; }

private:
  static const uint32_t none = ~0u;
  uint32_t value;
};

/*! Maps surface numbers to the geometry IDs of a scene. */
class SurfaceIDs {
public:
  /*! Replaces the content. surfaces: pairs of surface number and geometry ID. */
  void set(const std::vector<std::pair<uint32_t, uint32_t>>& surfaces) {
    size_t size = 1;
    while (size < 2 * surfaces.size()) size *= 2;
    mask = uint32_t(size - 1);
    slots.assign(size, Slot{none, none});
    for (const auto& surface : surfaces) {
      uint32_t at = surface.first & mask;
      while (slots[at].number != none) at = (at + 1) & mask;
      slots[at] = Slot{surface.first, surface.second};
    }
  }

  /*! Returns the ID of a surface. IDs, which the table does not contain, are returned unchanged. */
  uint32_t operator[](uint32_t number) const {
    if (slots.empty()) return number;
    uint32_t at = number & mask;
    while (slots[at].number != number) {
      if (slots[at].number == none) return number;
      at = (at + 1) & mask;
    }
    return slots[at].id;
  }

  void clear() { slots.clear(); }

private:
  static const uint32_t none = 0xFFFFFFFFu;
  struct Slot {
    uint32_t number, id;
  };

  std::vector<Slot> slots; //!< hash table, indexed by the number's low bits, with linear probing
  uint32_t mask = 0;
};
} // namespace embree::cbvh
