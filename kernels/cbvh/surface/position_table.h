// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hash table of vertices by position, with open addressing. Vertices that are equal floats at all time steps have one
 * entry. Two NaNs count as equal, because a vertex can be NaN at some steps only. */

#include "../base/codec_names.h"
#include "../base/atomic_ref.h"
#include "../embree/scene.h"
#include <cmath>
#include <functional>

namespace embree::isa {
/*! Positions: has position(vertex), at the first time step, and areEqual(a,b), for all steps. */
template<typename Positions>
class PositionTable {
public:
  typedef uint32_t Entry; //!< index of a slot; depends on the order in which threads add vertices
  static const Entry none = 0xFFFFFFFFu;

  explicit PositionTable(Device* device) : slots(device, 0) {}

  /*! Empties the table and allocates slots. vertices: upper bound of the number of different vertices. */
  void reserve(size_t vertices) {
    size_t size = 16;
    while (size < vertices + vertices / 8) size *= 2;
    if (size > none)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "grids have " + std::to_string(vertices) + " vertices on their borders: expected at most 1.9e9");
    slots.resize(size);
    parallel_for(size_t(0), size, size_t(1) << 16, [&](const range<size_t>& r) {
      std::fill(slots.data() + r.begin(), slots.data() + r.end(), uint64_t(0));
    });
  }

  void clear() { slots.clear(); }
  bool isEmpty() const { return slots.empty(); }
  size_t size() const { return slots.size(); } //!< upper bound of entries

  /*! Returns the entry of a vertex, and adds it if there is none. Thread-safe. */
  Entry add(const Positions& positions, size_t vertex) {
    const uint64_t h = hashOf(positions.position(vertex));
    const uint64_t added = uint64_t(vertex) | usedBit | (h >> tagShift) << tagShift;
    for (size_t at = h & mask();; at = (at + 1) & mask()) {
      const cbvh::AtomicRef<uint64_t> slot(slots[at]);
      uint64_t found = slot.load(std::memory_order_relaxed);
      if (found == 0 && slot.compareExchange(found, added, std::memory_order_relaxed)) return Entry(at);
      if (!isSame(positions, found, vertex, h)) continue;
      if (!(found & sharedBit)) slot.fetchOr(sharedBit, std::memory_order_relaxed);
      return Entry(at);
    }
  }

  /*! Returns `none` if there is no entry. Requires reserve(). Must not be called while threads add vertices. */
  Entry find(const Positions& positions, size_t vertex) const {
    const uint64_t h = hashOf(positions.position(vertex));
    for (size_t at = h & mask(); slots[at]; at = (at + 1) & mask())
      if (isSame(positions, slots[at], vertex, h)) return Entry(at);
    return none;
  }

  /*! Returns any vertex with the entry's position, depending on the order of threads. */
  size_t vertexOf(Entry entry) const { return size_t(slots[entry] & indexBits); }

  /*! True if the entry was added more than once: by several grids, or several times by one. */
  bool isShared(Entry entry) const { return (slots[entry] & sharedBit) != 0; }

  /*! True if an entry was added only once. */
  bool hasUnshared() const {
    return parallel_reduce(
        size_t(0), slots.size(), size_t(1) << 16, false,
        [&](const range<size_t>& r) {
          for (size_t i = r.begin(); i != r.end(); i++)
            if (slots[i] && !isShared(Entry(i))) return true;
          return false;
        },
        std::logical_or<bool>());
  }

  /*! Users define the meaning of marks. Not thread-safe. */
  void mark(Entry entry) { slots[entry] |= markBit; }
  bool isMarked(Entry entry) const { return (slots[entry] & markBit) != 0; }

private:
  /* A slot: 33 bits of vertex, three flags, and the upper 28 bits of the hash, which avoid most comparisons. 0 if
   * free. */
  static const int tagShift = 36;
  static const uint64_t indexBits = (uint64_t(1) << 33) - 1;
  static const uint64_t sharedBit = uint64_t(1) << 33, markBit = uint64_t(1) << 34, usedBit = uint64_t(1) << 35;

  size_t mask() const { return slots.size() - 1; }

  static uint64_t hashOf(const float p[3]) {
    uint64_t h = 0;
    for (int k = 0; k < 3; k++) {
      const float x = std::isnan(p[k]) ? NAN : p[k] + 0.0f; // makes both zeros equal, and all NaNs
      uint32_t bits;
      memcpy(&bits, &x, sizeof(bits));
      h = (h ^ bits) * 0x9E3779B97F4A7C15ull;
      h ^= h >> 29;
    }
    return h;
  }

  static bool isSame(const Positions& positions, uint64_t slot, size_t vertex, uint64_t hash) {
    if (((slot ^ hash) >> tagShift) != 0) return false;
    const size_t other = size_t(slot & indexBits);
    return other == vertex || positions.areEqual(vertex, other);
  }

  mvector<uint64_t> slots;
};
} // namespace embree::isa
