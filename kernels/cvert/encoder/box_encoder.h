// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes the boxes of a cVERT block: margins of groups, in a shear that makes groups flat. The boxes of a segment of a
 * moving block bound its vertices at both ends. */

#include "block_vertices.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Call begin(), addGroup() for all groups and ends, then write() and encodeBounds(). */
class BoxEncoder {
public:
  /*! Chooses the shear. first, second: the block at the segment's beginning, and at its end if it moves. They must
   *  not change until encodeBounds() returns. */
  void begin(const BlockVertices& first, const BlockVertices* second = nullptr) {
    ends[0] = &first;
    ends[1] = second ? second : &first;
    numEnds = second ? 2 : 1;
    groupsX = groupsOf(first.quads[0]);
    groups = groupsX * groupsOf(first.quads[1]);
    shear = chooseShear();
    memset(margins, 0, sizeof(margins));
  }

  /*! Enlarges the margins of group g so that its box contains its vertices at an end, 0 or 1, of the segment. */
  void addGroup(uint32_t end, uint32_t g) {
    const BlockVertices& block = *ends[end];
    const Group group(block, g % groupsX, g / groupsX);
    for (uint32_t k = 0; k < 3; k++) {
      const bool isSheared = k == shear.axis && !shear.isZero();
      const Heights& h = heights[end];
      const int* const values = isSheared ? h.at : block.coordinates[k];
      const Span span = group.span(values), corners = group.corners(values);
      const int lower = corners.lower - span.lower, upper = span.upper - corners.upper;
      margins[0][k][g] = std::max(margins[0][k][g], isSheared ? ceilShift(lower + h.below, h.shift) : lower);
      margins[1][k][g] =
          std::max(margins[1][k][g], isSheared ? ceilShift(upper + h.above, h.shift) : upper + remainder(block, k));
    }
  }

  void addGroups() {
    for (uint32_t e = 0; e < numEnds; e++)
      for (uint32_t g = 0; g < groups; g++) addGroup(e, g);
  }

  /*! Writes the margins. Returns bits 0 to 23 of VertHeader::info. */
  uint32_t write(uint8_t* out) const {
    uint32_t info =
        shear.axis << 12 | (uint32_t(shear.slopes[0]) & 31u) << 14 | (uint32_t(shear.slopes[1]) & 31u) << 19;
    for (int k = 0; k < 3; k++) info |= writeMargins(out + k * groups, margins[0][k], margins[1][k]) << (4 * k);
    return info;
  }

  /*! Returns VertHeader::bounds for an end, in units of 2^shift coordinates. shift: receives the smallest
   *  possible. */
  uint32_t encodeBounds(uint32_t end, uint32_t& shift) const {
    const BlockVertices& block = *ends[end];
    const Heights& sheared = heights[end];
    int bounds[4];
    for (uint32_t i = 0; i < 2; i++) {
      const uint32_t k = (shear.axis + 1 + i) % 3;
      bounds[i] = spanOf(block.coordinates[k], block.numVertices()).upper + remainder(block, k);
    }
    if (shear.isZero()) {
      const Span h = spanOf(block.coordinates[shear.axis], block.numVertices());
      bounds[2] = h.lower;
      bounds[3] = h.upper + remainder(block, shear.axis);
    } else {
      const Span h = spanOf(sheared.at, block.numVertices());
      bounds[2] = (h.lower - sheared.below) >> sheared.shift; // rounds down
      bounds[3] = ceilShift(h.upper + sheared.above, sheared.shift);
    }
    shift = 0;
    while (ceilShift(bounds[0], shift) > 255 || ceilShift(bounds[1], shift) > 255 || (bounds[2] >> shift) < -128 ||
           ceilShift(bounds[3], shift) > 127)
      shift++;
    return uint32_t(ceilShift(bounds[0], shift)) | uint32_t(ceilShift(bounds[1], shift)) << 8 |
           (uint32_t(bounds[2] >> shift) & 255u) << 16 | (uint32_t(ceilShift(bounds[3], shift)) & 255u) << 24;
  }

private:
  struct Shear {
    uint32_t axis = 0;
    int slopes[2] = {0, 0}; //!< along the next two axes, in 1/16

    bool isZero() const { return slopes[0] == 0 && slopes[1] == 0; }
  };

  /*! Sheared coordinates without remainders, in multiples of 2^-shift spacings of the sheared axis. */
  struct Heights {
    uint32_t shift;
    int below, above; //!< upper bounds of what remainders subtract and add
    int at[BlockVertices::maxVertices];

    /*! Returns false if decoders, which compute in float, might round. */
    bool set(const BlockVertices& block, const Shear& shear) {
      const uint32_t m = shear.axis, next[2] = {(m + 1) % 3, (m + 2) % 3};
      int ratio[2]; // log2 of a spacing relative to the sheared axis' spacing
      shift = 4;
      for (int i = 0; i < 2; i++) {
        ratio[i] = shear.slopes[i] == 0 ? 0 : block.exponent[next[i]] - block.exponent[m];
        shift = uint32_t(std::max(int(shift), 4 - ratio[i]));
      }
      double largest = std::ldexp(coordinateBound(block, m), int(shift));
      for (int i = 0; i < 2; i++)
        largest += std::abs(shear.slopes[i]) * std::ldexp(coordinateBound(block, next[i]), int(shift) + ratio[i] - 4);
      if (!(largest < double(1 << 22))) return false;

      const int factors[2] = {shear.slopes[0] * (1 << (int(shift) - 4 + ratio[0])),
                              shear.slopes[1] * (1 << (int(shift) - 4 + ratio[1]))};
      below = 0;
      above = remainder(block, m) << shift;
      for (int i = 0; i < 2; i++) {
        below += remainder(block, next[i]) * std::max(-factors[i], 0);
        above += remainder(block, next[i]) * std::max(factors[i], 0);
      }
      for (uint32_t i = 0; i < block.numVertices(); i += 4)
        ((Int4::load(block.coordinates[m] + i) << int(shift)) +
         Int4(factors[0]) * Int4::load(block.coordinates[next[0]] + i) +
         Int4(factors[1]) * Int4::load(block.coordinates[next[1]] + i))
            .store(at + i);
      return true;
    }

  private:
    static double coordinateBound(const BlockVertices& block, uint32_t k) {
      return std::ldexp(double(block.upper[k]) - double(block.origin[k]), -block.exponent[k]) + 1;
    }
  };

  /*! Upper bound of remainders on axis k, in coordinates. */
  static int remainder(const BlockVertices& block, uint32_t k) { return block.remainderBits[k] != 0 ? 1 : 0; }

  struct Span {
    int lower, upper;
  };

  /*! values: padded to whole vectors. */
  static Span spanOf(const int* values, uint32_t count) {
    Int4 lower = Int4::load(values), upper = lower;
    for (uint32_t i = 4; i < count; i += 4) {
      const Int4 x = Int4::load(values + i);
      lower = min(lower, x);
      upper = max(upper, x);
    }
    return {reduceMin(lower), reduceMax(upper)};
  }

  /*! Vertices of a group in an array of the block's vertices. */
  class Group {
  public:
    Group(const BlockVertices& block, uint32_t gx, uint32_t gy)
      : width(block.width),
        first(groupQuads * (gy * block.width + gx)),
        x(std::min(groupQuads, block.quads[0] - groupQuads * gx)),
        y(std::min(groupQuads, block.quads[1] - groupQuads * gy)) {}

    Span span(const int* values) const {
      const int* const begin = values + first;
      if (x == groupQuads) {
        Int4 lower = Int4::load(begin), upper = lower;
        for (uint32_t j = 0; j <= y; j++) {
          const Int4 left = Int4::load(begin + j * width), right = Int4::load(begin + j * width + 1);
          lower = min(lower, min(left, right));
          upper = max(upper, max(left, right));
        }
        return {reduceMin(lower), reduceMax(upper)};
      }
      Span span = {*begin, *begin};
      for (uint32_t j = 0; j <= y; j++)
        for (uint32_t i = 0; i <= x; i++) {
          span.lower = std::min(span.lower, begin[j * width + i]);
          span.upper = std::max(span.upper, begin[j * width + i]);
        }
      return span;
    }

    Span corners(const int* values) const {
      const int* const begin = values + first;
      const int c[] = {begin[0], begin[x], begin[y * width], begin[y * width + x]};
      return {std::min(std::min(c[0], c[1]), std::min(c[2], c[3])),
              std::max(std::max(c[0], c[1]), std::max(c[2], c[3]))};
    }

  private:
    const uint32_t width, first, x, y; //!< vertices per row of the block, first vertex, quads per side
  };

  /*! Chooses the shear in which the quads' mean plane is flat, or none if groups do not become flatter or decoders
   *  might round. */
  Shear chooseShear() {
    double n[3] = {0, 0, 0};
    for (uint32_t e = 0; e < numEnds; e++) addNormals(*ends[e], n);
    Shear unsheared;
    const double x = std::fabs(n[0]), y = std::fabs(n[1]), z = std::fabs(n[2]);
    unsheared.axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    const uint32_t m = unsheared.axis;
    if (n[m] == 0) return unsheared;
    Shear shear = unsheared;
    for (uint32_t i = 0; i < 2; i++) {
      const double slope = std::floor(16 * n[(m + 1 + i) % 3] / n[m] + 0.5);
      shear.slopes[i] = int(std::min(std::max(slope, -15.0), 15.0));
    }
    if (shear.isZero()) return unsheared;
    double sheared = 0, unshearedSum = 0; // sums of world-space thicknesses
    for (uint32_t e = 0; e < numEnds; e++) {
      const BlockVertices& block = *ends[e];
      if (!heights[e].set(block, shear)) return unsheared;
      sheared += std::ldexp(double(thickness(block, heights[e].at)), block.exponent[m] - int(heights[e].shift));
      unshearedSum += std::ldexp(double(thickness(block, block.coordinates[m])), block.exponent[m]);
    }
    return sheared < unshearedSum ? shear : unsheared;
  }

  /*! Adds a multiple of the quads' mean normal: twice the vector area that the block's outline encloses. */
  static void addNormals(const BlockVertices& block, double sum[3]) {
    const uint32_t width = block.width;
    int64_t n[3] = {0, 0, 0};
    auto add = [&](uint32_t from, uint32_t to) {
      const int* const(&c)[3] = {block.coordinates[0], block.coordinates[1], block.coordinates[2]};
      for (int k = 0; k < 3; k++)
        n[k] += int64_t(c[(k + 1) % 3][from]) * c[(k + 2) % 3][to] - int64_t(c[(k + 2) % 3][from]) * c[(k + 1) % 3][to];
    };
    const uint32_t last = block.quads[1] * width;
    for (uint32_t x = 0; x < block.quads[0]; x++) {
      add(x, x + 1);
      add(last + x + 1, last + x);
    }
    for (uint32_t y = 0; y < block.quads[1]; y++) {
      add(y * width + block.quads[0], (y + 1) * width + block.quads[0]);
      add((y + 1) * width, y * width);
    }
    for (int k = 0; k < 3; k++)
      sum[k] += std::ldexp(double(n[k]), block.exponent[(k + 1) % 3] + block.exponent[(k + 2) % 3]);
  }

  /*! Sum of the groups' extents on an axis. */
  int64_t thickness(const BlockVertices& block, const int* values) const {
    int64_t sum = 0;
    for (uint32_t g = 0; g < groups; g++) {
      const Span span = Group(block, g % groupsX, g / groupsX).span(values);
      sum += span.upper - span.lower;
    }
    return sum;
  }

  /*! Writes margins in the smallest possible steps of 2^n, and returns n. */
  uint32_t writeMargins(uint8_t* out, const int* lowerMargins, const int* upperMargins) const {
    int largest = 0;
    for (uint32_t g = 0; g < groups; g++) largest = std::max(largest, std::max(lowerMargins[g], upperMargins[g]));
    uint32_t shift = 0;
    while (ceilShift(largest, shift) > int(maxMargin)) shift++;
    for (uint32_t g = 0; g < groups; g++)
      out[g] = uint8_t(ceilShift(lowerMargins[g], shift) | ceilShift(upperMargins[g], shift) << 4);
    return shift;
  }

  /*! Number of steps of 2^shift, rounded up. */
  static int ceilShift(int x, uint32_t shift) { return (x + (1 << shift) - 1) >> shift; }

  const BlockVertices* ends[2];
  uint32_t numEnds, groupsX, groups;
  Shear shear;
  int margins[2][3][maxVertGroups];
  Heights heights[2]; //!< at both ends; only valid if there is a shear
};
}} // namespace cvert::CVERT_ISA
