// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A moving mesh block: a mesh block (mesh_block.h) of the first time step, then the other steps.
 * docs/formats/mesh.md specifies it.
 *
 *   mesh block | VertMotion | offsets of steps | step 1 | step 2 | ...
 *
 *   step: MeshStep | records of groups | boxes of groups | bases of groups | fields of vertices
 *
 * Triangles and their numbers are the same at all steps. A step's affine map predicts its vertices from the first step:
 * a small piece of a surface moves nearly as a rigid body. The step stores the differences of coordinates from their
 * predictions: a signed base per group, and a field per vertex, on each axis. No box of these steps is sheared.
 *
 * Predictions are computed in double, with the same results on all processors: products of two floats are exact, fused
 * or not, and the order of sums is fixed. Denormal floats count as 0 in products and sums, because processors may flush
 * them. */

#include "mesh_block.h"
#include "motion.h"
#include <cmath>

namespace cvert { inline namespace CVERT_ISA {
/*! Version of mesh blocks that move, and FileHeader::vertVersion of files with such blocks. Older readers reject
 *  it. */
static const uint32_t movingMeshFormatVersion = 7;

static const uint32_t meshStepBytes = 68;
static const uint32_t meshStepRecordBytes = 2; //!< per group

struct MeshStep {
  float origin[3];   //!< as in MeshHeader
  uint32_t spacings; //!< as in MeshHeader
  float map[3][4];   //!< per axis: factors of x, y and z at the first step, and a summand
  uint32_t info;     //!< bits 0..11: shifts of boxes; 12..17, 18..23, 24..29: bits of bases on x, y, z; 30..31: 0
};
static_assert(sizeof(MeshStep) == meshStepBytes, "step of a mesh block");

inline uint32_t stepBoxShift(const MeshStep& step, uint32_t axis) {
  return meshBoxShift(step.spacings, step.info, axis);
}
/*! Bits of a group's base on an axis. info: MeshStep::info. */
inline uint32_t stepBaseBits(uint32_t info, uint32_t axis) { return (info >> (12 + 6 * axis)) & 63; }

/*! Bits of a vertex's field on an axis. The group's record has 5 bits for each axis, from bit 0 on; 31 means 32. */
inline uint32_t stepFieldBits(uint32_t record, uint32_t axis) {
  const uint32_t bits = (record >> (5 * axis)) & 31;
  return bits == 31 ? 32 : bits;
}

/*! Offsets of sections, in bytes from the start of the step. */
struct MeshStepLayout {
  uint32_t records, boxes, bases, fields;
};

/*! groups: of the block. info: MeshStep::info. */
inline MeshStepLayout meshStepLayout(uint32_t groups, uint32_t info) {
  MeshStepLayout offsets;
  offsets.records = meshStepBytes;
  offsets.boxes = offsets.records + meshStepRecordBytes * groups;
  offsets.bases = offsets.boxes + meshBoxBytes * groups;
  const uint32_t bits = groups * (stepBaseBits(info, 0) + stepBaseBits(info, 1) + stepBaseBits(info, 2));
  offsets.fields = offsets.bases + (bits + 7) / 8;
  return offsets;
}

inline uint32_t meshStepRecord(const MeshStep* step, uint32_t g) {
  uint16_t record;
  std::memcpy(&record, (const uint8_t*)step + meshStepBytes + meshStepRecordBytes * g, sizeof(record));
  return record;
}

/*! Version and kind in MeshHeader::counts. MeshHeader::info contains meshTagOfInfo(). */
inline uint32_t movingMeshTagOfCounts() { return meshTagOfCounts() | 1u << 15; }

/*! Requires a valid block. */
inline bool isMovingMesh(const MeshHeader* block) { return block->motion != 0; }

/*! Requires a block that moves. */
inline VertMotion motionOfMesh(const MeshHeader* block) {
  VertMotion motion;
  std::memcpy(&motion, (const uint8_t*)block + block->motion, sizeof(motion));
  return motion;
}

/*! step: 1 to numSteps-1. */
inline const MeshStep* meshStepOf(const MeshHeader* block, uint32_t step) {
  uint32_t offset;
  std::memcpy(&offset, (const uint8_t*)block + motionOfMesh(block).steps + 4 * (step - 1), sizeof(offset));
  return (const MeshStep*)((const uint8_t*)block + offset);
}

/* --- prediction --- */

/*! Converts a float exactly, except that denormal floats become 0. */
inline double flushedDouble(float x) { return (bitsOfFloat(x) & 0x7F800000u) != 0 ? double(x) : 0.0; }

/*! Predicts a world coordinate. row: row of MeshStep::map for the axis. p: vertex at the first step. */
inline double predictedPosition(const float row[4], const float p[3]) {
  return ((flushedDouble(row[0]) * flushedDouble(p[0]) + flushedDouble(row[1]) * flushedDouble(p[1])) +
          flushedDouble(row[2]) * flushedDouble(p[2])) +
         flushedDouble(row[3]);
}

/*! Converts a predicted position to a coordinate of the step, modulo 2^32. origin, spacings: of the step. Clamps to
 *  +-2^30 on an axis with a spacing, so that the conversion to an integer is defined. */
inline uint32_t predictedCoordinate(double position, float origin, uint32_t spacings, uint32_t axis) {
  const double minNormalFloat = 1.1754943508222875e-38;
  if (hasRanks(spacings, axis))
    return rankOfFloat(std::fabs(position) >= minNormalFloat ? float(position) : 0.0f) - rankOfFloat(origin);
  const uint64_t bits = uint64_t(1023 + 127 - ((spacings >> (8 * axis)) & 255)) << 52; // 1 / spacing
  double rcpSpacing;
  std::memcpy(&rcpSpacing, &bits, sizeof(rcpSpacing));
  const double coordinate = std::floor((position - flushedDouble(origin)) * rcpSpacing + 0.5), limit = 1073741824.0;
  return uint32_t(int32_t(coordinate > -limit ? coordinate < limit ? coordinate : limit : -limit));
}
}} // namespace cvert::CVERT_ISA
