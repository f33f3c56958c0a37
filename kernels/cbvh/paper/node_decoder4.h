// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* SIMD decoder of nodes (node.h) and of cLEAF groups (leaf/format.h). Decodes all four children of a word at once, to
 * index `first` of the output and the next three. */

#include "node_cache.h"
#include "node_tables.h"
#include "leaf/format.h"
#include "../base/intrinsics.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

template<int N>
__forceinline NodeBox boxAt(const NodePlanes<N>& boxes, uint32_t i) {
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    box.lower[axis] = boxes.planes[axis][0][i];
    box.extent[axis] = boxes.planes[axis][1][i] - boxes.planes[axis][0][i];
  }
  return box;
}

/*! Stores the planes of four children on an axis. lower, upper: in parent extents. */
template<int N>
__forceinline void storePlanes(NodePlanes<N>& out, uint32_t first, int axis, const vfloat4& lower, const vfloat4& upper,
                               const NodeBox& parent) {
  const vfloat4 from(parent.lower[axis]), extent(parent.extent[axis]);
  vfloat4::store(out.planes[axis][0] + first, madd(lower, extent, from));
  vfloat4::store(out.planes[axis][1] + first, madd(upper, extent, from));
}

template<int N>
__forceinline void decodeNode(uint32_t word, const NodeBox& parent, NodePlanes<N>& out, uint32_t first) {
  for (int axis = 0; axis < 2; axis++)
    storePlanes(out, first, axis,
                vfloat4::load(nodeTables.lowerPlanes[axis][(word >> lowerShift(axis)) & planePairMask]),
                vfloat4::load(nodeTables.upperPlanes[axis][(word >> upperShift(axis)) & planePairMask]), parent);
  const vfloat4 z0 = vfloat4::load(nodeTables.zPlanes[(word >> zShift) & 63]);
  const vfloat4 z1 = vfloat4::load(nodeTables.zPlanes[(word >> (zShift + 2 * zBits)) & 63]);
  storePlanes(out, first, 2, vfloat4(_mm_movelh_ps(z0, z1)), vfloat4(_mm_movehl_ps(z1, z0)), parent);
}

/*! Decodes the four leaves of a group: their boxes and surfaces. */
class GroupDecoder4 {
public:
  __forceinline GroupDecoder4(NodePlanes<16>& boxes, LeafSurfaces& surfaces, uint32_t first)
    : boxes(boxes),
      surfaces(surfaces),
      first(first) {}

  /*! bits: Heights of the group. parent: its box. */
  __forceinline void decode(uint32_t word, uint64_t bits, const NodeBox& parent) {
    if (likely(!(bits >> 63))) decodeLattice(word, bits, parent);
    else decodeSeparate(word, bits, parent);
    const vfloat4 x0 = plane(0, 0), y0 = plane(1, 0);
    storeByLeaf(x0, y0, vfloat4(one) / (plane(0, 1) - x0), vfloat4(one) / (plane(1, 1) - y0), surfaces.footprint);
  }

private:
  __forceinline vfloat4 plane(int axis, int upper) const { return vfloat4::load(boxes.planes[axis][upper] + first); }

  __forceinline void storeByLeaf(const vfloat4& a, const vfloat4& b, const vfloat4& c, const vfloat4& d,
                                 float rows[16][4]) const {
    vfloat4 leaf[4];
    transpose(a, b, c, d, leaf[0], leaf[1], leaf[2], leaf[3]);
    for (int i = 0; i < 4; i++) vfloat4::store(rows[first + i], leaf[i]);
  }

  /*! q: heights at the corners of each leaf's box, in bins. bin: extent of a bin in z. base: z of height 0.
   *  thickness: in bins. */
  __forceinline void storeSurfaces(const vfloat4 q[4], const vfloat4& bin, const vfloat4& base, float thickness) {
    const vfloat4 a = q[1] - q[0], b = q[2] - q[0], twist = (q[3] - q[2]) - a;
    storeByLeaf(madd(bin, q[0], base), bin * a, bin * b, bin * twist, surfaces.height);
    vfloat4::store(surfaces.halfThickness + first, vfloat4(0.5f * thickness) * bin);
  }

  /*! solid, empty: masks of the four leaves. */
  __forceinline void setLeaves(size_t solid, size_t empty) {
    surfaces.solid = (surfaces.solid & ~(15u << first)) | uint32_t(solid) << first;
    surfaces.empty = (surfaces.empty & ~(15u << first)) | uint32_t(empty) << first;
  }

  __forceinline void decodeLattice(uint32_t word, uint64_t bits, const NodeBox& parent) {
    for (int axis = 0; axis < 2; axis++) {
      const uint32_t planes = word >> latticeShift(axis);
      const float p0 = nodeTables.latticeOuterOffsets[planes & latticePlaneMask];
      const float p1 = latticeMiddlePosition((planes >> 10) & latticePlaneMask);
      const float p2 = 1.0f - nodeTables.latticeOuterOffsets[(planes >> 5) & latticePlaneMask];
      if (axis == 0) storePlanes(boxes, first, axis, vfloat4(p0, p1, p0, p1), vfloat4(p1, p2, p1, p2), parent);
      else storePlanes(boxes, first, axis, vfloat4(p0, p0, p1, p1), vfloat4(p1, p1, p2, p2), parent);
    }
    vfloat4 q[4];
    latticeCorners(bits, q);
    for (int k = 0; k < 4; k++) q[k] += vfloat4(0.5f);
    const float lower = parent.lower[2], extent = parent.extent[2];
    const vfloat4 bin(latticeRange / float(latticeBins) * extent), base(lower - 0.5f * (latticeRange - 1.0f) * extent);
    const float thickness = latticeThickness(word >> latticeThicknessShift);
    storeSurfaces(q, bin, base, thickness);
    const vfloat4 half = vfloat4(0.5f * thickness) * bin;
    const vfloat4 lowest = max(madd(bin, min(min(q[0], q[1]), min(q[2], q[3])), base) - half, vfloat4(lower));
    const vfloat4 highest = min(madd(bin, max(max(q[0], q[1]), max(q[2], q[3])), base) + half, vfloat4(lower + extent));
    vfloat4::store(boxes.planes[2][0] + first, lowest);
    vfloat4::store(boxes.planes[2][1] + first, max(lowest, highest));
    setLeaves(0, 0);
  }

  /*! Distributes a lattice's nine heights to the corners of leaves. */
  static __forceinline void latticeCorners(uint64_t bits, vfloat4 corner[4]) {
    const __m128i bytes = _mm_cvtsi64_si128((long long)bits);
    const int middle = _mm_movemask_epi8(bytes) & 127;
    const __m128i nine = _mm_insert_epi16(_mm_and_si128(bytes, _mm_set1_epi8(127)), middle, 4);
    for (int k = 0; k < 4; k++) corner[k] = vfloat4(vint4(pickBytes(nine, nodeTables.latticeCornerShuffles[k])));
  }

  /*! _mm_shuffle_epi8 for controls that set only the lowest byte of each 32-bit lane. */
  static __forceinline __m128i pickBytes(const __m128i& bytes, const uint8_t control[16]) {
#if defined(CBVH_SSE41_INTEGERS)
    return _mm_shuffle_epi8(bytes, _mm_load_si128((const __m128i*)control));
#else
    alignas(16) uint8_t b[16];
    _mm_store_si128((__m128i*)b, bytes);
    return _mm_set_epi32(b[control[12]], b[control[8]], b[control[4]], b[control[0]]);
#endif
  }

  __forceinline void decodeSeparate(uint32_t word, uint64_t bits, const NodeBox& parent) {
    decodeNode(word, parent, boxes, first);
    auto code = [&](int leaf) { return int(uint32_t(bits >> (separateLeafBits * leaf)) & separateLeafMask); };
    const vint4 leaf(code(0), code(1), code(2), code(3));
    setLeaves(movemask(vboolf4(leaf == vint4(int(solidLeaf)))), movemask(vboolf4(leaf == vint4(int(emptyLeaf)))));
    vfloat4 q[4];
    for (int k = 0; k < 3; k++) q[k] = vfloat4((leaf >> (5 * k)) & vint4(31)) + vfloat4(0.5f);
    q[3] = q[1] + q[2] - q[0];
    const vfloat4 lower = plane(2, 0), extent = plane(2, 1) - lower;
    storeSurfaces(q, vfloat4(separateRange / float(separateBins)) * extent,
                  madd(vfloat4(0.5f * (1.0f - separateRange)), extent, lower),
                  separateThickness(uint32_t(bits >> separateThicknessShift) & 7u));
  }

  NodePlanes<16>& boxes;
  LeafSurfaces& surfaces;
  const uint32_t first;
};
} // namespace embree::isa::cbvh
