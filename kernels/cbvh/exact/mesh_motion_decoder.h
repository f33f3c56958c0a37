// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoder of a segment of a moving mesh block (cvert/format/mesh_motion.h), at both ends: first the boxes of all
 * groups, then half a group at a time, for moving_mesh_block.h. Decoded boxes have no sheared axis, because steps have
 * different spacings. The scalar references are cvert/decoder/mesh_view.h for the first step and mesh_step_view.h for
 * later steps. */

#include "../../cvert/decoder/mesh_step_view.h"
#include "mesh_decoder.h"

namespace embree::isa::cbvh {
class MeshMotionDecoder : private MeshDecoder {
public:
  __forceinline explicit MeshMotionDecoder(const MeshHeader* block)
    : MeshDecoder(block),
      block(block),
      numGroups(meshGroups(block->counts)) {}

  /*! Decodes the entry of a block in a segment, except for out.key and out.first.block. */
  void decode(uint32_t segment, MeshSegmentEntry& out) const {
    MeshDecoder::decode(out.first);
    for (int k = 0; k < 3; k++) out.extent[k] = 0.0f;
    for (uint32_t e = 0; e < 2; e++) {
      const MeshStep* const step = segment + e ? meshStepOf(block, segment + e) : nullptr;
      for (uint32_t k = 0; k < 3; k++) {
        out.origins[e][k] = step ? step->origin[k] : block->origin[k];
        setPlanes(k, step, out.origins[e][k], out.planes[e][k], out.extent[k]);
      }
      if (step) decodeFields(*step, out.steps[e]);
    }
    for (int k = 0; k < 3; k++) // interpolation rounds origins and planes
      out.extent[k] += motionSlack(out.origins[0][k], out.origins[1][k], out.extent[k]);
  }

  /*! Decodes half of group g at both ends. entry: output of decode(), with `key` set. Does not set out.key. */
  void triangles(const MeshSegmentEntry& entry, uint32_t g, uint32_t half, SegmentTriangles& out) const {
    MeshDecoder::triangles(entry.first, g, half, out.begin);
    VertexOwners owners;
    findOwners(entry.first, g, owners);
    const uint32_t segment = entry.key.segment;
    const MeshVertices first = out.begin.vertices;
    if (segment > 0) decodeStep(*meshStepOf(block, segment), entry.steps[0], first, owners, out.begin.vertices);
    decodeStep(*meshStepOf(block, segment + 1), entry.steps[1], first, owners, out.end);
  }

  /*! See MeshDecoder::number. */
  uint32_t number(const MeshSegmentEntry& entry, uint32_t g, uint32_t index) const {
    return MeshDecoder::number(entry.first, g, index);
  }

private:
  /*! Sets the planes on axis k. step: null for the first time step. origin: of the step. extent: raised to the
   *  planes' largest distance from the origin. */
  void setPlanes(uint32_t k, const MeshStep* step, float origin, GroupPlanes& out, float& extent) const {
    const uint32_t spacings = step ? step->spacings : block->spacings;
    if (unlikely(hasRanks(spacings, k))) {
      setRankedPlanes(k, step, origin, out, extent);
      return;
    }
    const bool isSheared = !step && isShearedAxis(k);
    const vfloatV from(origin), spacing(meshSpacing(spacings, k));
    vfloatV farthest(0.0f);
    for (uint32_t n = 0; n < 16; n += vectorWidth) {
      vintV begin, end;
      loadBounds(step, k, n, begin, end);
      if (isSheared) unshear(k, n, begin, end);
      const vfloatV lower = from + vfloatV(begin) * spacing, upper = from + vfloatV(end) * spacing;
      vfloatV::store(out.at[0] + n, lower);
      vfloatV::store(out.at[1] + n, upper);
      const vboolV isGroup = vintV(embree::step) + vintV(int(n)) < vintV(int(numGroups));
      farthest = max(farthest, select(isGroup, max(abs(lower - from), abs(upper - from)), vfloatV(0.0f)));
    }
    extent = max(extent, reduce_max(farthest));
  }

  /*! setPlanes on an axis of ranks (hasRanks). */
  void setRankedPlanes(uint32_t k, const MeshStep* step, float origin, GroupPlanes& out, float& extent) const {
    const uint32_t shift = boxShift(step, k), first = rankOfFloat(origin);
    const uint8_t *const lowerBytes = boxBytes(step) + k * numGroups, *const extents = lowerBytes + 3 * numGroups;
    for (uint32_t l = 0; l < 16; l++) {
      const uint32_t g = min(l, numGroups - 1), begin = first + (lowerBytes[g] << shift),
                     end = begin + ((extents[g] + 1u) << shift);
      out.at[0][l] = floatOfRank(begin);
      out.at[1][l] = floatOfRank(end - 1);
      extent = max(extent, max(std::fabs(out.at[0][l] - origin), std::fabs(out.at[1][l] - origin)));
    }
  }

  /*! True if coordinates at the first step are sheared on axis k. */
  bool isShearedAxis(uint32_t k) const {
    return (meshSlope(block->info, 1) | meshSlope(block->info, 2)) != 0 && k == meshShearedAxis(block->info);
  }

  /*! Converts bounds of sheared coordinates on axis m to bounds of coordinates. n: group of the first lane. */
  void unshear(uint32_t m, uint32_t n, vintV& begin, vintV& end) const {
    vintV minShear(8), maxShear(8); // sums of the shear, in 1/16; 8 rounds to nearest
    for (uint32_t i = 1; i < 3; i++) {
      vintV lower, upper;
      loadBounds(nullptr, (m + i) % 3, n, lower, upper);
      upper = upper - vintV(1);
      const int slope = meshSlope(block->info, i);
      minShear = minShear + vintV(slope) * (slope < 0 ? upper : lower);
      maxShear = maxShear + vintV(slope) * (slope < 0 ? lower : upper);
    }
    begin = begin - (maxShear >> 4);
    end = end - (minShear >> 4);
  }

  /*! Loads bounds of coordinates on axis k, the upper one plus 1. step: null for the first time step. n: group of
   *  the first lane. Lanes without a group receive other bytes. */
  __forceinline void loadBounds(const MeshStep* step, uint32_t k, uint32_t n, vintV& begin, vintV& end) const {
    const int shift = int(boxShift(step, k));
    const uint8_t* const bytes = boxBytes(step) + k * numGroups + n;
    begin = loadBytes(bytes) << shift;
    end = begin + ((loadBytes(bytes + 3 * numGroups) + vintV(1)) << shift);
  }

  uint32_t boxShift(const MeshStep* step, uint32_t k) const {
    return step ? stepBoxShift(*step, k) : meshBoxShift(block->spacings, block->info, k);
  }

  /*! Bytes of the groups' boxes: lower planes on x, y and z, then extents. step: null for the first time step. */
  const uint8_t* boxBytes(const MeshStep* step) const {
    return step ? (const uint8_t*)step + meshStepLayout(numGroups, step->info).boxes
                : (const uint8_t*)block + meshLayout(block->counts).boxes;
  }

  /*! Decodes where the groups' fields begin, and their bases, at a step after the first. */
  void decodeFields(const MeshStep& step, MeshStepFields& out) const {
    const MeshStepLayout layout = meshStepLayout(numGroups, step.info);
    const uint8_t* const bases = (const uint8_t*)&step + layout.bases;
    out.data = (const uint8_t*)&step + layout.fields;
    uint32_t begin = 0, at = 0;
    for (uint32_t g = 0; g < numGroups; g++) {
      const uint32_t record = meshStepRecord(&step, g);
      out.begin[g] = uint16_t(begin);
      uint32_t bitsOfVertex = 0;
      for (uint32_t k = 0; k < 3; k++) {
        const uint32_t bits = stepFieldBits(record, k), baseBits = stepBaseBits(step.info, k);
        out.bits[k][g] = uint8_t(bits);
        bitsOfVertex += bits;
        const uint32_t base = meshBitsAt(bases, at, baseBits);
        out.base[k][g] = baseBits == 0 ? 0 : uint32_t(int(base << (32 - baseBits)) >> (32 - baseBits));
        at += baseBits;
      }
      begin += groupOwnVertices(meshRecord(block, g)) * bitsOfVertex;
    }
  }

  /*! For each vertex of a group, the group to which it belongs, and its index among that group's vertices. */
  struct VertexOwners {
    uint32_t numVertices;
    uint8_t group[32], index[32];
  };

  void findOwners(const MeshBlockEntry& entry, uint32_t g, VertexOwners& out) const {
    const uint32_t group = meshGroupByte(block, g), record = meshRecord(block, g), vertexCount = groupVertices(record);
    const MeshTopology at = meshTopology(group, record, meshVertices(block->counts));
    const uint8_t* const data = (const uint8_t*)block + entry.topologyBegin / 8;
    const uint32_t begin = entry.topology[g], ownMask = meshBitsAt(data, begin + at.ownMask, vertexCount);
    out.numVertices = vertexCount;
    for (uint32_t i = 0, own = 0, other = 0; i < vertexCount; i++) {
      if ((ownMask >> i) & 1) {
        out.group[i] = uint8_t(g);
        out.index[i] = uint8_t(own++);
        continue;
      }
      const uint32_t v = meshBitsAt(data, begin + at.otherIndices + at.otherBits * other++, at.otherBits);
      const uint32_t owner = groupOfVertex(entry, v);
      out.group[i] = uint8_t(owner);
      out.index[i] = uint8_t(v - entry.firstVertex[owner]);
    }
  }

  /*! Decodes a group's vertices at a step after the first, as MeshStepView. first: vertices at the first step. */
  static void decodeStep(const MeshStep& step, const MeshStepFields& fields, const MeshVertices& first,
                         const VertexOwners& owners, MeshVertices& out) {
    alignas(64) uint32_t residuals[3][32]; // coordinates minus predicted coordinates
    for (uint32_t i = 0; i < owners.numVertices; i++) {
      const uint32_t g = owners.group[i], bits[3] = {fields.bits[0][g], fields.bits[1][g], fields.bits[2][g]};
      uint32_t at = fields.begin[g] + owners.index[i] * (bits[0] + bits[1] + bits[2]);
      for (int k = 0; k < 3; at += bits[k++])
        residuals[k][i] = fields.base[k][g] + meshBitsAt(fields.data, at, bits[k]);
    }
    for (uint32_t k = 0; k < 3; k++) {
      if (likely(!hasRanks(step.spacings, k))) {
        addPredictions(step, k, first, owners.numVertices, residuals[k], out.at[k]);
        continue;
      }
      const float origin = step.origin[k];
      for (uint32_t i = 0; i < owners.numVertices; i++) {
        const float p[3] = {first.at[0][i], first.at[1][i], first.at[2][i]};
        out.at[k][i] = floatOfRank(rankOfFloat(origin) + residuals[k][i] +
                                   predictedCoordinate(predictedPosition(step.map[k], p), origin, step.spacings, k));
      }
    }
  }

  /* Vectors of the compiler: Embree has vectors of four doubles for AVX only. */
  typedef double Doubles __attribute__((vector_size(32)));
  typedef float Floats __attribute__((vector_size(16)));
  typedef int Ints __attribute__((vector_size(16)));
  typedef uint32_t UnsignedInts __attribute__((vector_size(16)));

  /*! Computes positions on axis k, which has a spacing, from predictions and residuals. The same operations as in
   *  predictedPosition and predictedCoordinate. */
  static void addPredictions(const MeshStep& step, uint32_t k, const MeshVertices& first, uint32_t numVertices,
                             const uint32_t* residuals, float* out) {
    const float spacing = meshSpacing(step.spacings, k);
    const double origin = flushedDouble(step.origin[k]), rcpSpacing = 1.0 / double(spacing);
    const Doubles zero = {}, limit = zero + 1073741824.0, minNormalFloat = zero + 1.1754943508222875e-38;
    for (uint32_t i = 0; i < numVertices; i += 4) {
      Doubles terms[3];
      for (int axis = 0; axis < 3; axis++) {
        Floats p;
        memcpy(&p, first.at[axis] + i, sizeof(p));
        const Doubles x = __builtin_convertvector(p, Doubles), size = x < 0.0 ? -x : x;
        terms[axis] = flushedDouble(step.map[k][axis]) * (size < minNormalFloat ? zero : x);
      }
      const Doubles predicted = ((terms[0] + terms[1]) + terms[2]) + flushedDouble(step.map[k][3]);
      const Doubles real = (predicted - origin) * rcpSpacing + 0.5;
      const Doubles notLess = real > -limit ? real : -limit, clamped = notLess < limit ? notLess : limit;
      const Ints truncated = __builtin_convertvector(clamped, Ints);
      const Doubles correction = clamped < __builtin_convertvector(truncated, Doubles) ? zero - 1.0 : zero;
      UnsignedInts coordinate;
      memcpy(&coordinate, residuals + i, sizeof(coordinate));
      coordinate += (UnsignedInts)truncated + (UnsignedInts) __builtin_convertvector(correction, Ints);
      const Floats position = step.origin[k] + __builtin_convertvector((Ints)coordinate, Floats) * spacing;
      memcpy(out + i, &position, sizeof(position));
    }
  }

  const MeshHeader* const block;
  const uint32_t numGroups;
};
} // namespace embree::isa::cbvh
