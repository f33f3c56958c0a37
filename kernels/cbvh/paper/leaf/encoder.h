// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes groups of cLEAF (format.h) for block_encoder.h: four at a time (lattice_lanes.h) if possible, otherwise one
 * by one (group_encoder.h). */

#include "../block_geometry.h"
#include "group_encoder.h"
#include "leaf_lanes.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class LeafEncoder {
public:
  /*! sharpSides: see BlockEncoder::encode(). The other arguments must outlive the object. */
  LeafEncoder(const BlockGeometry& geometry, Block* block, uint32_t sharpSides, BlockStatistics& statistics)
    : geometry(geometry),
      block(block),
      groupHeights((Heights*)block->leaves()),
      sharpSides(sharpSides),
      statistics(statistics) {}

  /* Members of all encoders of leaves: see block_encoder.h. */

  uint32_t encodeGroup(uint32_t m, const NodeBox& box) {
    const QuadGroup quads = quadsOf(m);
    return storeGroup(m, quads, cbvh::encodeGroup(box, quads), box);
  }

  void encodeSiblingGroups(uint32_t m, const NodeBoxes& boxes, uint32_t words[4]) {
    if (!geometry.areAllFinite()) {
      for (uint32_t c = 0; c < 4; c++) words[c] = encodeGroup(m + c, boxes[c]);
      return;
    }
    const GroupLanes lanes(geometry, m);
    LatticeLanes lattices(boxes, lanes);
    lattices.encode();
    if (lattices.encoded) {
      lattices.store(words, groupHeights + m);
      const LeafLanes leaves(geometry, m, boxes, lanes, lattices);
      borderWidth = std::max(borderWidth, leaves.requiredBorderWidth(lattices.encoded));
      for (int quad = 0; quad < 4; quad++) {
        /* good leaves are only counted; the others, which may exceed a limit or the maximum, are measured */
        const uint32_t goodLeaves = lattices.encoded & leaves.goodLeaves(quad, statistics.maxThickness);
        for (uint32_t c = 0; c < 4; c++) statistics.leafFit.quads += goodLeaves >> c & 1;
        for (uint32_t rest = lattices.encoded & ~goodLeaves; rest; rest &= rest - 1) {
          const uint32_t c = lowestBit(rest);
          measureLeaf(decodeLeaf(words[c], groupHeights[m + c], quad, boxes[c]), 4 * (m + c) + quad, false);
        }
      }
      if (sharpSides)
        for (uint32_t c = 0; c < 4; c++)
          if (lattices.encoded >> c & 1) measureGroupOverhang(m + c, words[c], boxes[c]);
    }
    /* one by one: groups without a lattice, and undecided ones */
    for (uint32_t c = 0; c < 4; c++) {
      if (lattices.encoded >> c & 1) continue;
      const QuadGroup quads = quadsOf(m + c);
      EncodedGroup encoded;
      if (!(lattices.undecided >> c & 1) || !encodeLattice(boxes[c], quads, encoded))
        encoded = encodeSeparate(boxes[c], quads);
      encoded.borderWidth = cbvh::requiredBorderWidth(quads, encoded, boxes[c]);
      words[c] = storeGroup(m + c, quads, encoded, boxes[c]);
    }
  }

  void encodeLeaf(uint32_t, const NodeBox&) {}

  void finish() { block->info |= encodeBorderWidth(borderWidth); }

  /*! Returns bits of BlockHeader::info: the smallest code whose width is at least `width`, or 15. */
  static uint32_t encodeBorderWidth(double width) {
    uint32_t code = 0;
    while (code < 15 && !(borderWidthOf(code << 28) >= width)) code++;
    return code << 28;
  }

private:
  /*! Stores the heights of a group, and adds its leaves to the statistics. Returns the group's word. */
  uint32_t storeGroup(uint32_t m, const QuadGroup& quads, const EncodedGroup& encoded, const NodeBox& box) {
    groupHeights[m] = encoded.heights;
    borderWidth = std::max(borderWidth, encoded.borderWidth);
    for (int c = 0; c < 4; c++) {
      const LeafPatch leaf = decodeLeaf(encoded.word, encoded.heights, c, box);
      if (leaf.empty) continue;
      measureLeaf(leaf, 4 * m + c, hasSeparateLeaves(encoded.heights));
      measureLeafOverhang(quads, c, leaf.box);
    }
    return encoded.word;
  }

  /*! measureLeafOverhang() for all leaves of group m, whose heights were stored. */
  void measureGroupOverhang(uint32_t m, uint32_t word, const NodeBox& box) {
    const QuadGroup quads = quadsOf(m);
    for (int c = 0; c < 4; c++) measureLeafOverhang(quads, c, decodeLeaf(word, groupHeights[m], c, box).box);
  }

  QuadGroup quadsOf(uint32_t m) const {
    QuadGroup group;
    const uint32_t side = (1u << geometry.cellLevels) + 1, x = 2 * mortonX(m), y = 2 * mortonY(m);
    for (uint32_t v = 0; v < 9; v++)
      memcpy(group.vertices[v], geometry.local[(y + v / 3) * side + x + v % 3], sizeof(double[3]));
    for (uint32_t c = 0; c < 4; c++) group.boxes[c] = geometry.boxOf(geometry.cellLevels, 4 * m + c);
    memcpy(group.rounding, geometry.rounding, sizeof(group.rounding));
    group.border[0][0] = x == 0;
    group.border[1][0] = y == 0;
    group.border[0][1] = x + 2 == side - 1;
    group.border[1][1] = y + 2 == side - 1;
    return group;
  }

  /*! Adds the thickness and the fit of a leaf to the statistics. cell: index of the leaf in Morton order.
   *  isSeparate: its group has separate leaves. */
  void measureLeaf(const LeafPatch& leaf, uint32_t cell, bool isSeparate) {
    double slope[2] = {0, 0};
    statistics.solidLeaves += leaf.solid;
    if (!leaf.solid) {
      slope[0] = 0.5 * (leaf.z[1] + leaf.z[3] - leaf.z[0] - leaf.z[2]) / leaf.box.extent[0];
      slope[1] = 0.5 * (leaf.z[2] + leaf.z[3] - leaf.z[0] - leaf.z[1]) / leaf.box.extent[1];
    }
    const float thickness =
        statistics.addThickness(geometry, leaf.box, slope, leaf.solid ? leaf.box.extent[2] : leaf.thickness);
    if (geometry.cellLevels == geometry.height)
      statistics.leafFit.addQuad(geometry, mortonX(cell), mortonY(cell), leaf.box, slope, isSeparate, thickness);
    else if (cell == 0) // the only quad counts once
      statistics.leafFit.addQuad(geometry, 0, 0, leaf.box, slope, isSeparate, thickness);
  }

  /*! Adds to the statistics how far a leaf extends past its quad's edges on sharp sides. box: of the leaf. */
  void measureLeafOverhang(const QuadGroup& group, int quad, const NodeBox& box) {
    static const uint32_t sides[2][2] = {{3, 1}, {0, 2}}; // [axis][upper]
    for (int axis = 0; axis < 2; axis++) {
      const int upper = childCoordinate(quad, axis);
      if (!group.border[axis][upper] || !(sharpSides >> sides[axis][upper] & 1)) continue;
      double overhang = 0;
      for (int c = 0; c < 4; c++) {
        if (childCoordinate(c, axis) != upper) continue;
        const double u = (group.vertexOf(quad, c)[axis] - box.lower[axis]) / box.extent[axis];
        overhang = std::max(overhang, upper ? 1 - u : u);
      }
      statistics.leafFit.addEdge(overhang);
    }
  }

  const BlockGeometry& geometry;
  Block* block;
  Heights* groupHeights; //!< of the block, indexed by group
  uint32_t sharpSides;
  BlockStatistics& statistics;
  double borderWidth = 0; //!< largest so far
};
}} // namespace embree::cbvh::CBVH_ISA
