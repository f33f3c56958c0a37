// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Locates parts of a later time step of a mesh block, and decodes single vertices. */

#include "../format/mesh_motion.h"
#include "mesh_view.h"

namespace cvert { inline namespace CVERT_ISA {
/*! The block must be valid (validateMesh). The block and its view must outlive this object. */
class MeshStepView {
public:
  const MeshView& first;
  const MeshStep* const step;
  const MeshStepLayout layout;
  uint32_t fieldBits[maxMeshGroups][3];   //!< bits of a field, by group and axis
  uint32_t fieldBegin[maxMeshGroups + 1]; //!< first bit of a group's fields, relative to layout.fields; then the total

  /*! step: from 1 on. */
  MeshStepView(const MeshView& first, uint32_t step) : MeshStepView(first, meshStepOf(first.block, step)) {}

  MeshStepView(const MeshView& first, const MeshStep* step)
    : first(first),
      step(step),
      layout(meshStepLayout(first.groups, step->info)) {
    fieldBegin[0] = 0;
    for (uint32_t g = 0; g < first.groups; g++) {
      uint32_t bits = 0;
      for (uint32_t k = 0; k < 3; k++) bits += fieldBits[g][k] = stepFieldBits(meshStepRecord(step, g), k);
      fieldBegin[g + 1] = fieldBegin[g] + (first.firstVertex[g + 1] - first.firstVertex[g]) * bits;
    }
  }

  /*! Size of the step in bytes, a multiple of 4. */
  uint32_t bytes() const { return (layout.fields + (fieldBegin[first.groups] + 7) / 8 + 3) & ~3u; }

  /*! v: index in the block. */
  void vertex(uint32_t v, float out[3]) const {
    float p[3];
    first.vertex(v, p);
    const uint32_t g = first.groupOfVertex(v), *const bits = fieldBits[g];
    uint32_t at = fieldBegin[g] + (v - first.firstVertex[g]) * (bits[0] + bits[1] + bits[2]);
    for (uint32_t k = 0; k < 3; at += bits[k++]) {
      const double predicted = predictedPosition(step->map[k], p);
      out[k] = position(k, predictedCoordinate(predicted, step->origin[k], step->spacings, k) + base(g, k) +
                               meshBitsAt(data() + layout.fields, at, bits[k]));
    }
  }

  /*! Box of a group in world space. Boxes of later steps are not sheared. */
  void groupBox(uint32_t g, float lower[3], float upper[3]) const {
    for (uint32_t k = 0; k < 3; k++) {
      const uint32_t shift = stepBoxShift(*step, k), plane = boxByte(k, g);
      const uint32_t begin = plane << shift, end = (plane + boxByte(3 + k, g) + 1) << shift;
      if (hasRanks(step->spacings, k)) {
        lower[k] = position(k, begin);
        upper[k] = position(k, end - 1);
        continue;
      }
      lower[k] = step->origin[k] + float(begin) * meshSpacing(step->spacings, k);
      upper[k] = step->origin[k] + float(end) * meshSpacing(step->spacings, k);
    }
  }

  /*! Base of group g on axis k, modulo 2^32: added to predictions and fields. */
  uint32_t base(uint32_t g, uint32_t k) const {
    const uint32_t bits[3] = {stepBaseBits(step->info, 0), stepBaseBits(step->info, 1), stepBaseBits(step->info, 2)};
    if (bits[k] == 0) return 0;
    uint32_t at = g * (bits[0] + bits[1] + bits[2]);
    for (uint32_t i = 0; i < k; i++) at += bits[i];
    const uint32_t stored = meshBitsAt(data() + layout.bases, at, bits[k]);
    return uint32_t(int32_t(stored << (32 - bits[k])) >> (32 - bits[k])); // bases are signed
  }

  /*! plane: 0 to 2 for lower planes, 3 to 5 for extents. */
  uint32_t boxByte(uint32_t plane, uint32_t g) const { return data()[layout.boxes + plane * first.groups + g]; }

private:
  const uint8_t* data() const { return (const uint8_t*)step; }

  float position(uint32_t k, uint32_t coordinate) const {
    if (hasRanks(step->spacings, k)) return floatOfRank(rankOfFloat(step->origin[k]) + coordinate);
    return step->origin[k] + float(int(coordinate)) * meshSpacing(step->spacings, k);
  }
};
}} // namespace cvert::CVERT_ISA
