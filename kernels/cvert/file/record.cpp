// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "record.h"
#include "../portable/world.h"
#include <cmath>

namespace cvert {
namespace {
Reason validatePrimitives(const VertHeader* block, uint32_t numPrimitives) {
  if (block->primID >= numPrimitives)
    return Reason::damaged("primitive % is out of range: the geometry has %", block->primID, numPrimitives);
  if (!hasPrimIDs(block->info)) return Reason();
  for (uint32_t y = 0; y < vertQuadsY(block->region); y++)
    for (uint32_t x = 0; x < vertQuadsX(block->region); x++)
      for (bool isSecond : {false, true}) {
        const uint32_t primID = primitiveOfQuad(block, x, y, isSecond).primID;
        if (primID >= numPrimitives)
          return Reason::damaged("primitive % is out of range: the geometry has %", primID, numPrimitives);
      }
  return Reason();
}

Reason validateMotion(const FileGeometry& record, const VertMotion& motion) {
  if (motion.numSteps != record.numTimeSteps)
    return Reason::damaged("it has % time steps: the geometry has %", motion.numSteps, record.numTimeSteps);
  if (motion.begin != record.begin || motion.end != record.end)
    return Reason::damaged("its time range differs from the geometry's");
  return Reason();
}

Reason validateWhetherMoving(const FileGeometry& record, bool moves) {
  if (moves == (record.form == FILE_MOVING)) return Reason();
  return Reason::damaged(moves ? "it has time steps, but its geometry has none"
                               : "it has no time steps, but its geometry has");
}
} // namespace

bool areBounds(const float lower[3], const float upper[3]) {
  return isFinite(lower) && isFinite(upper) && lower[0] <= upper[0] && lower[1] <= upper[1] && lower[2] <= upper[2];
}

Reason validateRecord(const FileGeometry& g) {
  if (g.form > FILE_MOVING) return Reason::damaged("form % is unknown: expected 0 to %", g.form, FILE_MOVING);
  if (g.source > FILE_TRIANGLES)
    return Reason::damaged("source % is unknown: expected 0 to %", g.source, FILE_TRIANGLES);
  if (g.compression < FILE_COMPRESSION_GRID || g.compression > FILE_COMPRESSION_VERT)
    return Reason::damaged("compression % is unknown: expected 2 to 5", g.compression);
  const size_t entryBytes = g.form == FILE_TREE ? sizeof(FileNode) : sizeof(FileEntry);
  if (g.treeBytes % entryBytes != 0)
    return Reason::damaged("its tree has % bytes: expected a multiple of %", g.treeBytes, entryBytes);
  if (g.form == FILE_TREE && g.treeBytes == 0) return Reason::damaged("its tree has no nodes: expected at least one");
  if (g.numBlocks > g.treeBytes / entryBytes * (g.form == FILE_TREE ? 4 : 1))
    return Reason::damaged("its tree of % bytes has too few leaves for % blocks", g.treeBytes, g.numBlocks);
  const bool moves = g.form == FILE_MOVING;
  if (moves != (g.numTimeSteps != 1) || g.numTimeSteps == 0 || g.numTimeSteps > maxTimeSteps)
    return Reason::damaged(moves ? "it has % time steps: expected 2 to %" : "it has % time steps: expected 1",
                           g.numTimeSteps, maxTimeSteps);
  if (moves && (!std::isfinite(g.begin) || !std::isfinite(g.end) || !(g.begin < g.end)))
    return Reason::damaged("its time range is empty or not finite");
  if ((g.surface & firstFileNumber) == 0 || ((g.surface & movingSurface) != 0) != moves || g.surface == ~0u)
    return Reason::damaged(moves ? "its surface number is %: expected 3221225472 to 4294967294"
                                 : "its surface number is %: expected 1073741824 to 2147483647",
                           g.surface);
  if (g.reserved[0] || g.reserved[1]) return Reason::unsupported("reserved values of its record are set: expected 0");
  const bool isEmpty = g.lower[0] > g.upper[0] || g.lower[1] > g.upper[1] || g.lower[2] > g.upper[2];
  if (g.numBlocks && !isEmpty && !areBounds(g.lower, g.upper)) return Reason::damaged("its bounds are not finite");
  if (g.numBlocks && isEmpty && !moves)
    return Reason::damaged("its bounds are empty, but it has % blocks", g.numBlocks);
  return Reason();
}

Reason validateVertBlock(const FileGeometry& record, const void* data, size_t bytes) {
  if (const Reason reason = validateVert(data, bytes)) return reason;
  const VertHeader* const block = (const VertHeader*)data;
  if (const Reason reason = validateWhetherMoving(record, isMoving(block->info))) return reason;
  if (isMoving(block->info))
    if (const Reason reason = validateMotion(record, motionOf(block))) return reason;
  return validatePrimitives(block, record.numPrimitives);
}

Reason validateMeshBlock(const FileGeometry& record, const void* data, size_t bytes) {
  if (const Reason reason = validateMesh(data, bytes)) return reason;
  const MeshHeader* const block = (const MeshHeader*)data;
  if (const Reason reason = validateWhetherMoving(record, isMovingMesh(block))) return reason;
  if (isMovingMesh(block))
    if (const Reason reason = validateMotion(record, motionOfMesh(block))) return reason;
  const MeshView view(block);
  for (uint32_t g = 0; g < view.groups; g++)
    for (uint32_t t = 0; t < groupTriangles(meshGroupByte(block, g)); t++) {
      const uint32_t primID = primitiveOfMesh(block->info, view.number(g, t));
      if (primID >= record.numPrimitives)
        return Reason::damaged("primitive % is out of range: the geometry has %", primID, record.numPrimitives);
    }
  return Reason();
}
} // namespace cvert
