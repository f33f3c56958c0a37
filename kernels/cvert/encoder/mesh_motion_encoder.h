// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lossless encoder of moving mesh blocks, see format/mesh_motion.h. IDs identify vertices, because vertices may
 * coincide at some steps only. */

#include "../format/mesh_motion.h"
#include "affine_fit.h"
#include "mesh_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
/*! A cluster of MeshClusters, with the vertices of its triangles. */
struct MovingCluster {
  const MeshTriangle* triangles; //!< corners: at the first step
  const uint32_t (*ids)[3];      //!< of each triangle's corners, three different ones
  MeshGroups groups;
  bool areHalvesOfQuads; //!< see MeshEncoder::encodeCluster
  uint32_t surface;
  float begin, end;  //!< times of the first and last step
  uint32_t numSteps; //!< 2 to maxTimeSteps
};

class MeshMotionEncoder : private MeshEncoder {
public:
  /*! Upper bound of a block's size. */
  static size_t maxBytes(size_t numSteps) {
    return MeshEncoder::maxBytes + sizeof(VertMotion) + (numSteps - 1) * (sizeof(uint32_t) + maxStepBytes);
  }

  /*! locate(step,id,out): sets `out` to a vertex's position at a later step, which must be finite. Called once per
   *  step and vertex of a block, before onBlock. onBlock: see MeshEncoder::encodeCluster. block: maxBytes, aligned to
   *  4. */
  template<typename Locate, typename OnBlock>
  void encodeCluster(const MovingCluster& cluster, uint8_t* block, MeshStatistics& statistics, const Locate& locate,
                     const OnBlock& onBlock) {
    ids = cluster.ids;
    idsBegin = cluster.triangles;
    MeshEncoder::encodeCluster(cluster.triangles, cluster.groups, cluster.areHalvesOfQuads, cluster.surface, block,
                               statistics, [&](size_t bytes, uint32_t first, uint32_t stored) {
                                 const size_t all = appendSteps(cluster, block, bytes, locate);
                                 statistics.stepBytes += all - bytes;
                                 onBlock(all, first, stored);
                               });
  }

  /*! Encodes triangles that were decoded from a block, group by group, as that block, see MeshEncoder::encodeInOrder.
   *  Returns the size. */
  template<typename Locate>
  size_t encodeInOrder(const MovingCluster& cluster, uint8_t* block, MeshStatistics& statistics, const Locate& locate) {
    ids = cluster.ids;
    idsBegin = cluster.triangles;
    const size_t bytes =
        MeshEncoder::encodeInOrder(cluster.triangles, cluster.groups, cluster.surface, block, statistics);
    const size_t all = appendSteps(cluster, block, bytes, locate);
    statistics.stepBytes += all - bytes;
    return all;
  }

private:
  /*! Upper bound of a step's size: header, records, boxes, bases, fields, padding. */
  static constexpr size_t maxStepBytes =
      meshStepBytes + (meshStepRecordBytes + meshBoxBytes + 12) * maxMeshGroups + 12 * maxMeshVertices + 16;

  template<typename Locate>
  size_t appendSteps(const MovingCluster& cluster, uint8_t* block, size_t bytes, const Locate& locate) {
    MeshHeader header;
    std::memcpy(&header, block, sizeof(header));
    header.counts = (header.counts & ~meshTagOfCounts()) | movingMeshTagOfCounts();
    header.motion = uint32_t(bytes);
    const VertMotion motion = {cluster.begin, cluster.end, cluster.numSteps, uint32_t(bytes + sizeof(VertMotion))};
    std::memcpy(block + bytes, &motion, sizeof(motion));
    uint8_t* end = block + motion.steps + sizeof(uint32_t) * (cluster.numSteps - 1);
    std::memcpy(first, vertices, numVertices * sizeof(first[0]));
    fit.setFirst(first, numVertices);
    for (uint32_t step = 1; step < cluster.numSteps; step++) {
      const uint32_t offset = uint32_t(end - block);
      std::memcpy(block + motion.steps + sizeof(offset) * (step - 1), &offset, sizeof(offset));
      for (uint32_t v = 0; v < numVertices; v++) {
        locate(step, idOfCorner[cornerOfVertex[v]], vertices[v]);
        for (int k = 0; k < 3; k++) vertices[v][k] += 0.0f; // converts -0 to 0
      }
      end = writeStep(end);
    }
    header.bytes = uint32_t(end - block);
    std::memcpy(block, &header, sizeof(header));
    return header.bytes;
  }

  /*! Encodes `vertices` as a step. Returns its end. */
  uint8_t* writeStep(uint8_t* const out) {
    MeshStep step;
    std::memset(&step, 0, sizeof(step));
    fit.fit(vertices, step.map);
    for (int k = 0; k < 3; k++) chooseStepCoordinates(k, step);
    computeBounds();
    std::memcpy(step.origin, origin, sizeof(origin));
    uint32_t baseBits[3];
    for (int k = 0; k < 3; k++) {
      step.spacings |= spacingOf(k) << (8 * k);
      baseBits[k] = residuals[k].baseBits(groups);
      step.info |= (shifts[k] - (isRanked[k] ? minRankShift : 0)) << (4 * k) | baseBits[k] << (12 + 6 * k);
    }
    std::memcpy(out, &step, sizeof(step));

    const MeshStepLayout layout = meshStepLayout(groups, step.info);
    for (uint32_t g = 0; g < groups; g++) {
      uint32_t record = 0;
      for (int k = 0; k < 3; k++) {
        record |= std::min(residuals[k].bits[g], 31u) << (5 * k);
        out[layout.boxes + uint32_t(k) * groups + g] = uint8_t(all[g].lower[k]);
        out[layout.boxes + uint32_t(3 + k) * groups + g] = uint8_t(all[g].extent[k]);
      }
      out[layout.records + 2 * g] = uint8_t(record);
      out[layout.records + 2 * g + 1] = uint8_t(record >> 8);
    }
    BitWriter bases(out + layout.bases);
    for (uint32_t g = 0; g < groups; g++)
      for (int k = 0; k < 3; k++) bases.write(uint32_t(residuals[k].base[g]) & lowBits(baseBits[k]), baseBits[k]);
    BitWriter fields(bases.finish());
    for (uint32_t g = 0; g < groups; g++)
      for (uint32_t v = all[g].firstVertex; v < all[g].firstVertex + all[g].owned; v++)
        for (int k = 0; k < 3; k++)
          fields.write(residuals[k].of[v] - uint32_t(residuals[k].base[g]), residuals[k].bits[g]);
    uint8_t* end = fields.finish();
    while ((end - out) % 4 != 0) *end++ = 0;
    return end;
  }

  static uint32_t lowBits(uint32_t bits) { return bits == 0 ? 0 : 0xFFFFFFFFu >> (32 - bits); }

  uint32_t spacingOf(int k) const { return isRanked[k] ? 0u : uint32_t(exponent[k] + 127); }

  /*! Coordinates minus predictions on an axis, modulo 2^32. */
  struct Residuals {
    uint32_t of[maxMeshVertices];
    int32_t base[maxMeshGroups];  //!< the least residual of a group
    uint32_t bits[maxMeshGroups]; //!< of a field, 0 to 30 or 32

    /*! Bits per base; bases are signed. */
    uint32_t baseBits(uint32_t groups) const {
      uint32_t most = 0;
      for (uint32_t g = 0; g < groups; g++)
        if (base[g] != 0) most = std::max(most, bitWidth(uint32_t(base[g] < 0 ? ~base[g] : base[g])) + 1);
      return most;
    }
  };

  /*! Chooses a lattice or ranks on an axis, and computes the residuals. */
  void chooseStepCoordinates(int k, const MeshStep& step) {
    for (uint32_t v = 0; v < numVertices; v++) predicted[v] = predictedPosition(step.map[k], first[v]);
    chooseCoordinates(k);
    const uint64_t bits = subtract(k, residuals[k]);
    if (!isRanked[k] || !fitsLattice[k]) return;
    std::memcpy(ranks, coordinates[k], numVertices * sizeof(ranks[0]));
    useLattice(k);
    if (subtract(k, other) < bits) {
      residuals[k] = other;
      return;
    }
    isRanked[k] = true;
    std::memcpy(coordinates[k], ranks, numVertices * sizeof(ranks[0]));
  }

  /*! Returns the bits of all fields and bases. */
  uint64_t subtract(int k, Residuals& out) const {
    const uint32_t spacings = spacingOf(k) << (8 * k);
    for (uint32_t v = 0; v < numVertices; v++)
      out.of[v] = coordinates[k][v] - predictedCoordinate(predicted[v], origin[k], spacings, uint32_t(k));
    uint64_t sum = 0;
    for (uint32_t g = 0; g < groups; g++) {
      out.base[g] = 0;
      out.bits[g] = 0;
      if (all[g].owned == 0) continue;
      int32_t least = 0x7FFFFFFF, most = -0x7FFFFFFF - 1;
      for (uint32_t v = all[g].firstVertex; v < all[g].firstVertex + all[g].owned; v++) {
        least = std::min(least, int32_t(out.of[v]));
        most = std::max(most, int32_t(out.of[v]));
      }
      out.base[g] = least;
      out.bits[g] = bitWidth(uint32_t(most) - uint32_t(least));
      if (out.bits[g] == 31) out.bits[g] = 32;
      sum += all[g].owned * out.bits[g];
    }
    return sum + groups * out.baseBits(groups);
  }

  AffineFit fit;
  float first[maxMeshVertices][3];   //!< positions at the first step
  double predicted[maxMeshVertices]; //!< predicted positions on the current axis
  uint32_t ranks[maxMeshVertices];   //!< temporary, for chooseStepCoordinates
  Residuals residuals[3], other;
};
}} // namespace cvert::CVERT_ISA
