// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Validates bytes that may be a mesh block: counts, sizes and indices, which decoders do not check. Vertices and
 * numbers may have any value. */

#include "../portable/reason.h"
#include "mesh_step_view.h"

namespace cvert { inline namespace CVERT_ISA {
class MeshValidation {
public:
  /*! See validateMesh. Reads at most `bytes` bytes. */
  static Reason validate(const void* data, size_t bytes) {
    if (bytes < meshHeaderBytes)
      return Reason::damaged("it has % bytes: the header of a mesh block needs %", bytes, meshHeaderBytes);
    const MeshHeader& header = *(const MeshHeader*)data;
    if (const Reason reason = validateHeader(header)) return reason;
    const MeshLayout layout = meshLayout(header.counts);
    if (bytes < layout.topology)
      return Reason::damaged("it has % bytes: header, records and boxes need %", bytes, layout.topology);
    if (const Reason reason = validateGroups(header)) return reason;
    const MeshView view(&header);
    if (!isMovingMesh(&header) && view.bytes() != header.bytes)
      return Reason::damaged("its header counts % bytes: its groups need %", header.bytes, view.bytes());
    if (bytes < header.bytes) return Reason::damaged("it has % bytes: its header counts %", bytes, header.bytes);
    if (header.bytes < view.bytes())
      return Reason::damaged("its header counts % bytes: its groups need %", header.bytes, view.bytes());
    if (view.firstTriangle[view.groups] != meshTriangles(header.counts))
      return Reason::damaged("its groups have % triangles: expected %", view.firstTriangle[view.groups],
                             meshTriangles(header.counts));
    if (view.firstVertex[view.groups] != meshVertices(header.counts))
      return Reason::damaged("its groups have % vertices: expected %", view.firstVertex[view.groups],
                             meshVertices(header.counts));
    for (uint32_t g = 0; g < view.groups; g++)
      if (const Reason reason = validateTopology(view, g)) return reason;
    return isMovingMesh(&header) ? validateMotion(view) : Reason();
  }

private:
  static Reason validateHeader(const MeshHeader& header) {
    const uint32_t kind = kindOfBlock(header.counts, header.info), version = versionOfBlock(header.counts, header.info);
    if (kind != kindOfMesh)
      return Reason::unsupported("it is a block of kind %: expected %, a mesh block", kind, kindOfMesh);
    if (version != meshFormatVersion && version != movingMeshFormatVersion)
      return Reason::unsupported("it is a mesh block of version %: this library reads versions 6 and 7", version);
    if ((version == movingMeshFormatVersion) != (header.motion != 0))
      return Reason::unsupported("it is a mesh block of version % whose motion begins at %: expected an offset in "
                                 "version 7, and 0 in version 6",
                                 version, header.motion);
    if (header.spacings >> 24) return Reason::unsupported("reserved bits of its spacings are set: expected 0");
    if (header.info & 0x38000000u) return Reason::unsupported("reserved bits of its info are set: expected 0");
    for (float x : header.origin)
      if (!std::isfinite(x)) return Reason::damaged("its origin is not finite");
    for (uint32_t k = 0; k < 3; k++)
      if (((header.spacings >> (8 * k)) & 255) == 255)
        return Reason::damaged("the exponent of a spacing is 255: expected at most 254");
    const int slopes[2] = {meshSlope(header.info, 1), meshSlope(header.info, 2)};
    if (meshShearedAxis(header.info) > 2) return Reason::damaged("its sheared axis is 3: expected 0 to 2");
    if (slopes[0] < -maxSlope || slopes[1] < -maxSlope)
      return Reason::damaged("a slope of its boxes is -16: expected -15 to 15");
    if ((slopes[0] | slopes[1]) != 0 && hasRanksOnAnyAxis(header.spacings))
      return Reason::damaged("it has a sheared axis and an axis of ranks: expected at most one of them");
    if (meshVertices(header.counts) > maxMeshVertices)
      return Reason::damaged("it has % vertices: expected at most %", meshVertices(header.counts), maxMeshVertices);
    if (baseNumberBits(header.counts) > 32)
      return Reason::damaged("base numbers of its groups have % bits: expected at most 32",
                             baseNumberBits(header.counts));
    return Reason();
  }

  static Reason validateGroups(const MeshHeader& header) {
    const uint32_t groups = meshGroups(header.counts);
    for (uint32_t g = 0; g < maxMeshGroups; g++) {
      const uint32_t group = meshGroupByte(&header, g);
      if (g >= groups) {
        if (group != 0) return Reason::unsupported("the byte of group % is set: the block has % groups", g, groups);
        continue;
      }
      const uint32_t record = meshRecord(&header, g), vertices = groupVertices(record), own = groupOwnVertices(record);
      if (vertices < 3 || vertices > streamLength(groupTriangles(group), groupRestarts(group, record)))
        return Reason::damaged("group % has % vertices: too few or too many for its triangles", g, vertices);
      if (own > vertices) return Reason::damaged("a group owns % vertices: it has only %", own, vertices);
      if (groupRestarts(group, record) >= groupTriangles(group))
        return Reason::damaged("group % has more strips than triangles", g);
      for (uint32_t k = 0; k < 3; k++)
        if (meshPlane(&header, k, g) + meshPlane(&header, 3 + k, g) > 255)
          return Reason::damaged("a box of group % ends at %: expected at most 255", g,
                                 meshPlane(&header, k, g) + meshPlane(&header, 3 + k, g));
    }
    return Reason();
  }

  /*! The first step must be valid. */
  static Reason validateMotion(const MeshView& view) {
    const MeshHeader& header = *view.block;
    const size_t bytes = header.bytes;
    size_t end = view.bytes();
    if (header.motion != end) return Reason::damaged("its motion begins at %: expected %", header.motion, end);
    if (bytes < end + sizeof(VertMotion))
      return Reason::damaged("it has % bytes: its motion needs %", bytes, end + sizeof(VertMotion));
    const VertMotion motion = motionOfMesh(&header);
    if (!std::isfinite(motion.begin) || !(motion.begin < motion.end) || !std::isfinite(motion.end))
      return Reason::damaged("its time range is empty or not finite");
    if (motion.numSteps < 2 || motion.numSteps > maxTimeSteps)
      return Reason::damaged("it has % time steps: expected 2 to %", motion.numSteps, maxTimeSteps);
    end += sizeof(VertMotion);
    if (motion.steps != end)
      return Reason::damaged("the offsets of its time steps begin at %: expected %", motion.steps, end);
    end += 4 * (motion.numSteps - 1);
    if (bytes < end) return Reason::damaged("it has % bytes: the offsets of its time steps need %", bytes, end);
    for (uint32_t s = 1; s < motion.numSteps; s++) {
      const MeshStep* const step = meshStepOf(&header, s);
      const size_t begin = size_t((const uint8_t*)step - (const uint8_t*)&header);
      if (begin != end) return Reason::damaged("a time step begins at %: expected %", begin, end);
      if (bytes < begin + meshStepBytes)
        return Reason::damaged("it has % bytes: the header of a time step needs %", bytes, begin + meshStepBytes);
      size_t size = 0;
      if (const Reason reason = validateStep(view, *step, bytes - begin, size)) return reason;
      end = begin + size;
    }
    return end == bytes ? Reason() : Reason::damaged("its header counts % bytes: its time steps end at %", bytes, end);
  }

  /*! size: receives the size of the step. */
  static Reason validateStep(const MeshView& view, const MeshStep& step, size_t bytes, size_t& size) {
    for (uint32_t k = 0; k < 3; k++) {
      if (!std::isfinite(step.origin[k])) return Reason::damaged("the origin of a time step is not finite");
      for (float x : step.map[k])
        if (!std::isfinite(x)) return Reason::damaged("a number of a time step's map is not finite");
      if (((step.spacings >> (8 * k)) & 255) == 255)
        return Reason::damaged("the exponent of a time step's spacing is 255: expected at most 254");
      if (stepBaseBits(step.info, k) > 32)
        return Reason::damaged("bases of a time step have % bits: expected at most 32", stepBaseBits(step.info, k));
    }
    if (step.spacings >> 24) return Reason::unsupported("reserved bits of a time step's spacings are set: expected 0");
    if (step.info >> 30) return Reason::unsupported("reserved bits of a time step's info are set: expected 0");
    const uint32_t fields = meshStepLayout(view.groups, step.info).fields;
    if (bytes < fields) return Reason::damaged("a time step has % bytes: its boxes and bases need %", bytes, fields);
    const MeshStepView at(view, &step);
    for (uint32_t g = 0; g < view.groups; g++) {
      if (meshStepRecord(&step, g) >> 15)
        return Reason::unsupported("a reserved bit of group % of a time step is set: expected 0", g);
      for (uint32_t k = 0; k < 3; k++)
        if (at.boxByte(k, g) + at.boxByte(3 + k, g) > 255)
          return Reason::damaged("a box of group % of a time step ends at %: expected at most 255", g,
                                 at.boxByte(k, g) + at.boxByte(3 + k, g));
    }
    size = at.bytes();
    return bytes < size ? Reason::damaged("a time step has % bytes: its fields need %", bytes, size) : Reason();
  }

  static Reason validateTopology(const MeshView& view, uint32_t g) {
    const uint32_t group = meshGroupByte(view.block, g), record = meshRecord(view.block, g),
                   triangles = groupTriangles(group), vertices = groupVertices(record);
    const uint32_t stream = streamLength(triangles, groupRestarts(group, record));
    const MeshTopology at = meshTopology(group, record, meshVertices(view.block->counts));
    auto bits = [&](uint32_t begin, uint32_t count) {
      return meshBitsAt(view.topology, view.topologyBegin[g] + begin, count);
    };
    const uint32_t restarts = bits(at.restarts, triangles - 1), fans = bits(at.fans, triangles - 1);
    if (countBits(restarts) != groupRestarts(group, record))
      return Reason::damaged("group % starts more or fewer strips than its record counts", g);
    if (restarts & fans) return Reason::damaged("a triangle of group % starts a strip and is part of a fan", g);
    for (uint32_t t = 0; t < triangles; t++)
      if (bits(at.firstCorners + 2 * t, 2) > 2)
        return Reason::damaged("a triangle of group % is turned by 3 corners: expected 0 to 2", g);
    if (countBits(bits(at.ownMask, vertices)) != groupOwnVertices(record))
      return Reason::damaged("group % owns more or fewer vertices than its record counts", g);
    uint32_t numNew = 3;
    for (uint32_t i = 3; i < stream; i++) numNew += bits(at.newMask + i - 3, 1);
    if (numNew != vertices)
      return Reason::damaged("the strips of group % have % vertices: its record counts more or fewer", g, numNew);
    numNew = 3;
    for (uint32_t i = 3; i < stream; i++)
      if (bits(at.newMask + i - 3, 1)) numNew++;
      else {
        const uint32_t local = bits(at.repeats + at.repeatBits * (i - numNew), at.repeatBits);
        if (local >= numNew)
          return Reason::damaged("a strip of group % repeats vertex % before its first use", g, local);
      }
    for (uint32_t i = 0; i < vertices - groupOwnVertices(record); i++) {
      const uint32_t v = bits(at.otherIndices + at.otherBits * i, at.otherBits);
      if (v >= view.firstVertex[g])
        return Reason::damaged("group % uses vertex %, which does not belong to a group before it", g, v);
    }
    return Reason();
  }
};

/*! Returns the first error in the mesh block at `data`, which must be aligned to 4 bytes. bytes: number of readable
 *  bytes; the block may be shorter. Decoders of valid blocks read up to vertReadPadding bytes after its end. */
inline Reason validateMesh(const void* data, size_t bytes) { return MeshValidation::validate(data, bytes); }
}} // namespace cvert::CVERT_ISA
