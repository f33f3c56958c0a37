// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A mesh's lattice, and its exceptions. If snapping flips or flattens a triangle, its vertices become exceptions, which
 * snap to a finer lattice or do not move. Exceptions are stored by position, so that all triangles and blocks agree:
 * the surface remains watertight even if vertices are not welded. */

#include "../portable/world.h"
#include "lattice.h"
#include "mesh_position.h"
#include <cstring>
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
/*! Positions with a level other than 0, see MeshLattice. A hash table with open addressing, because in a mesh of
 *  needles most vertices are exceptions. */
class MeshExceptions {
public:
  /*! Returns 0 for positions that are no exceptions. */
  uint32_t levelOf(const MeshPosition& position, uint32_t hash) const {
    return entries.empty() ? 0 : entries[find(position, hash)].level;
  }

  /*! Raises the level of a position to at least `level`. Throws std::bad_alloc. */
  void raise(const MeshPosition& position, uint32_t hash, uint32_t level) {
    if (4 * (count + 1) > 3 * entries.size()) grow();
    Entry& entry = entries[find(position, hash)];
    count += entry.level == 0;
    std::memcpy(entry.words, position.words, sizeof(entry.words));
    entry.level = std::max(entry.level, level);
  }

  size_t size() const { return count; }

private:
  struct Entry {
    uint32_t words[3]; //!< of the position
    uint32_t level;    //!< 0: empty
  };

  /*! Returns the entry of a position, or an empty one for it. */
  size_t find(const MeshPosition& position, uint32_t hash) const {
    size_t i = size_t(uint64_t(hash) * entries.size() >> 32);
    while (entries[i].level != 0 && std::memcmp(entries[i].words, position.words, sizeof(position.words)) != 0)
      if (++i == entries.size()) i = 0;
    return i;
  }

  void grow() {
    std::vector<Entry> old(std::max(size_t(64), 2 * entries.size()), Entry());
    old.swap(entries);
    for (const Entry& entry : old) {
      if (entry.level == 0) continue;
      MeshPosition position;
      std::memcpy(position.words, entry.words, sizeof(position.words));
      entries[find(position, position.hash())] = entry;
    }
  }

  std::vector<Entry> entries;
  size_t count = 0;
};

class MeshLattice {
public:
  /*! At level 1 the spacing is 2^finerBits times smaller; at level 2 vertices do not move. */
  static const int finerBits = 6;

  /*! exponent: of the spacing, minLatticeExponent to maxLatticeExponent, or losslessExponent. */
  explicit MeshLattice(int exponent)
    : lattices{WorldLattice(exponent),
               WorldLattice(exponent == losslessExponent ? losslessExponent
                                                         : std::max(exponent - finerBits, losslessExponent)),
               WorldLattice(losslessExponent)},
      isLossless(exponent == losslessExponent) {
    std::memset(filter, 0, sizeof(filter));
  }

  void snap(const float p[3], float out[3]) const { snap(levelOf(p), p, out); }

  /*! True only if a triangle has area and its normal turns by less than 90 degrees, whatever the levels of its
   *  corners. May be false for such triangles. */
  bool isRobust(const float a[3], const float b[3], const float c[3]) const {
    float e[3], f[3];
    for (int k = 0; k < 3; k++) {
      e[k] = b[k] - a[k];
      f[k] = c[k] - a[k];
    }
    const float x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
    const float nn = x * x + y * y + z * z, ss = lattices[0].spacing * lattices[0].spacing;
    const float ee = e[0] * e[0] + e[1] * e[1] + e[2] * e[2], ff = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
    /* An edge changes by at most sqrt(3) s, so n changes by at most sqrt(3) s (|e| + |f|) + 3 s^2, and by less than
     * 1e-6 |e| |f| due to rounding. The sum's square is at most 60 s^2 (e^2 + f^2 + s^2) + 2e-12 e^2 f^2; the larger
     * factors cover rounding of this test. Overflow of both sides and underflow of nn or ss make the result false. */
    return (isLossless || ss > 1e-37f) && nn > 96 * ss * (ee + ff + ss) + 1e-9f * ee * ff;
  }

  /*! Makes the vertices of a triangle exceptions if the lattice flips or flattens it. Requires finite corners.
   *  Returns true if a level rises: other triangles must then be checked again. */
  bool refine(const float a[3], const float b[3], const float c[3]) {
    if (isLossless || isRobust(a, b, c)) return false;
    const Double3 own = normal(a, b, c);
    if (isZero(own)) return false;
    bool changed = false;
    for (;;) {
      float p[3], q[3], r[3];
      snap(a, p);
      snap(b, q);
      snap(c, r);
      if (isOrientationKept(own, p, q, r)) return changed;
      const uint32_t level = std::min(std::min(levelOf(a), levelOf(b)), levelOf(c));
      if (level == 2) return changed;
      raise(a, level + 1);
      raise(b, level + 1);
      raise(c, level + 1);
      changed = true;
    }
  }

  /*! True if refine() raises levels of the triangle's corners. */
  bool flips(const float a[3], const float b[3], const float c[3]) const {
    if (isLossless || isRobust(a, b, c)) return false;
    const Double3 own = normal(a, b, c);
    float p[3], q[3], r[3];
    snap(a, p);
    snap(b, q);
    snap(c, r);
    return !isZero(own) && !isOrientationKept(own, p, q, r);
  }

  /*! True if two corners are equal: no ray can hit the triangle. False for three different corners on a line: once
   *  rounding moves the middle one, the triangle closes the gap to a neighbor without that corner. */
  static bool isDegenerate(const float a[3], const float b[3], const float c[3]) {
    return areEqual(a, b) || areEqual(b, c) || areEqual(c, a);
  }

  /*! True if the area is 0 in double precision. */
  static bool isFlat(const float a[3], const float b[3], const float c[3]) { return isZero(normal(a, b, c)); }

  size_t numExceptions() const { return exceptions.size(); }

private:
  static Double3 normal(const float a[3], const float b[3], const float c[3]) {
    const Double3 e = {double(b[0]) - a[0], double(b[1]) - a[1], double(b[2]) - a[2]},
                  f = {double(c[0]) - a[0], double(c[1]) - a[1], double(c[2]) - a[2]};
    return cross(e, f);
  }

  void snap(uint32_t level, const float p[3], float out[3]) const {
    for (int k = 0; k < 3; k++) out[k] = lattices[level].snap(p[k]);
  }

  /*! own: normal of a triangle whose corners snap to p, q and r */
  static bool isOrientationKept(const Double3& own, const float p[3], const float q[3], const float r[3]) {
    const Double3 n = normal(p, q, r);
    return dot(n, own) >= 0 && !isZero(n);
  }

  static bool areEqual(const float p[3], const float q[3]) { return p[0] == q[0] && p[1] == q[1] && p[2] == q[2]; }

  static bool isZero(const Double3& n) { return n.x == 0 && n.y == 0 && n.z == 0; }

  uint32_t levelOf(const float p[3]) const {
    if (exceptions.size() == 0) return 0;
    const MeshPosition position(p);
    const uint32_t hash = position.hash(), bit = hash >> 16;
    if (((filter[bit >> 5] >> (bit & 31)) & 1) == 0) return 0;
    return exceptions.levelOf(position, hash);
  }

  void raise(const float p[3], uint32_t level) {
    const MeshPosition position(p);
    const uint32_t hash = position.hash(), bit = hash >> 16;
    filter[bit >> 5] |= 1u << (bit & 31);
    exceptions.raise(position, hash, level);
  }

  const WorldLattice lattices[3];
  const bool isLossless;
  MeshExceptions exceptions;
  uint32_t filter[2048]; //!< bit i: an exception has i in the upper 16 bits of its hash; avoids look-ups
};
}} // namespace cvert::CVERT_ISA
