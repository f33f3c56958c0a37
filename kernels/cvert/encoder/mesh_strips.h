// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Orders the triangles of a group as generalized strips, see format/mesh_block.h. Greedy: the next triangle has
 * the fewest neighbors that no strip contains yet. */

#include "../format/mesh_block.h"
#include <cstring>

namespace cvert { inline namespace CVERT_ISA {
class MeshStrips {
public:
  uint32_t numTriangles, streamSize, numRestarts; //!< the first strip is not a restart
  uint8_t order[maxGroupTriangles];               //!< triangles, as input indices
  uint8_t stream[3 * maxGroupTriangles];          //!< vertices, as input indices
  uint8_t firstCorners[maxGroupTriangles];
  uint32_t restarts, fans; //!< a bit per triangle in `order`; bit 0 is 0

  /*! corners: indices below maxGroupVertices, three different ones per triangle. count: up to maxGroupTriangles.
   *  keepsOrder: the triangles are in the order that an earlier call chose; makes the same strips again. */
  void make(const uint8_t (*corners)[3], uint32_t count, bool keepsOrder = false) {
    this->corners = corners;
    this->keepsOrder = keepsOrder;
    numTriangles = streamSize = numRestarts = 0;
    restarts = fans = 0;
    std::memset(incident, 0, sizeof(incident));
    for (uint32_t t = 0; t < count; t++)
      for (int c = 0; c < 3; c++) incident[corners[t][c]] |= 1u << t;
    for (left = count == 32 ? ~0u : (1u << count) - 1; left != 0;) makeStrip(leastConnected(left));
  }

private:
  const uint8_t (*corners)[3];
  uint32_t incident[maxGroupVertices + 1]; //!< a bit per triangle, by vertex
  uint32_t left;                           //!< mask of triangles in no strip
  bool keepsOrder;

  /*! Mask of triangles in no strip with the edge from x to y in this direction. */
  uint32_t withEdge(uint8_t x, uint8_t y) const {
    uint32_t result = 0;
    for (uint32_t candidates = incident[x] & incident[y] & left; candidates; candidates &= candidates - 1) {
      const uint32_t t = uint32_t(__builtin_ctz(candidates));
      const uint8_t* c = corners[t];
      if ((c[0] == x && c[1] == y) || (c[1] == x && c[2] == y) || (c[2] == x && c[0] == y)) result |= 1u << t;
    }
    return result;
  }

  /*! Number of triangles in no strip that share an edge with triangle t. */
  uint32_t degree(uint32_t t) const {
    const uint32_t a = incident[corners[t][0]], b = incident[corners[t][1]], c = incident[corners[t][2]];
    return countBits(((a & b) | (b & c) | (c & a)) & left & ~(1u << t));
  }

  /*! candidates: not 0. */
  uint32_t leastConnected(uint32_t candidates) const {
    if ((candidates & (candidates - 1)) == 0 || keepsOrder) return uint32_t(__builtin_ctz(candidates));
    uint32_t best = 0, least = ~0u;
    for (; candidates && least; candidates &= candidates - 1) {
      const uint32_t t = uint32_t(__builtin_ctz(candidates)), d = degree(t);
      if (d < least) {
        least = d;
        best = t;
      }
    }
    return best;
  }

  /*! Appends triangle t. a, b: its first two corners in the stream. isFlipped: the application's order is b, a. */
  void append(uint32_t t, uint8_t a, uint8_t b, bool isFlipped) {
    const uint8_t first = isFlipped ? b : a, second = isFlipped ? a : b, *own = corners[t];
    firstCorners[numTriangles] = uint8_t(own[0] == first ? 0 : own[0] == second ? 1 : 2);
    order[numTriangles++] = uint8_t(t);
    left &= ~(1u << t);
  }

  /*! Makes a strip that starts with triangle t and ends when its last triangle has no neighbor to continue with. */
  void makeStrip(uint32_t t) {
    // The strip cannot continue across edge a b. Prefers an edge without neighbor as a b, if another edge has one.
    left &= ~(1u << t);
    const uint8_t* own = corners[t];
    uint32_t neighbors[3], start = 0;
    for (int e = 0; e < 3; e++) neighbors[e] = withEdge(own[(e + 1) % 3], own[e]);
    while (start < 2 && (neighbors[start] != 0 || (neighbors[(start + 1) % 3] | neighbors[(start + 2) % 3]) == 0))
      start++;
    uint8_t a = own[start], b = own[(start + 1) % 3], c = own[(start + 2) % 3];
    if (numTriangles != 0) {
      restarts |= 1u << numTriangles;
      numRestarts++;
    }
    stream[streamSize++] = a;
    stream[streamSize++] = b;
    stream[streamSize++] = c;
    bool isFlipped = false;
    append(t, a, b, isFlipped);
    for (;;) {
      // neighbors have the shared edge in the opposite direction
      const uint32_t strips = isFlipped ? withEdge(b, c) : withEdge(c, b);
      const uint32_t fansOn = isFlipped ? withEdge(c, a) : withEdge(a, c);
      if ((strips | fansOn) == 0) return;
      t = leastConnected(strips | fansOn);
      const uint8_t* next = corners[t];
      const bool isFan = ((strips >> t) & 1) == 0;
      const uint8_t x = isFan ? a : b;
      const uint8_t d = next[0] != x && next[0] != c ? next[0] : next[1] != x && next[1] != c ? next[1] : next[2];
      if (isFan) fans |= 1u << numTriangles;
      else {
        a = b;
        isFlipped = !isFlipped;
      }
      b = c;
      c = d;
      stream[streamSize++] = d;
      append(t, a, b, isFlipped);
    }
  }
};
}} // namespace cvert::CVERT_ISA
