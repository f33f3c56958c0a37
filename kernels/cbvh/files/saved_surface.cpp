// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "saved_surface.h"
#include "../base/block_bytes.h"
#include "../base/kinds.h"
#include "../base/block_validity.h"
#include "../embree/scene.h"
#include "../blocks/block_table.h"
#include "../blocks/surface_blocks.h"
#include "../../cvert/conversion/moving_mesh_tile_conversion.h"
#include "../../cvert/conversion/tile_conversion.h"
#include "../../cvert/file/record.h"
#include "file_statistics.h"

namespace embree::cbvh {
static_assert(fileFramedVersion == formatVersion, "files have the version of blocks with frames");
static_assert(FILE_COMPRESSION_GRID == uint32_t(RTC_COMPRESSION_CGRID) &&
                  FILE_COMPRESSION_VERT == uint32_t(RTC_COMPRESSION_CVERT),
              "files have values of RTCCompression");

namespace {
/*! Converts a surface's tree and lists its blocks. The result is a tree, a list of blocks with bounds, or a list
 *  of moving blocks without bounds. */
class TreeConverter {
public:
  TreeConverter(const SurfaceBlocks& surface, bool moves, FileSurface& to) : statistics(surface.statistics), to(to) {
    to.record.form = moves ? FILE_MOVING : surface.root != BVH4::emptyNode ? FILE_TREE : FILE_LIST;
    if (to.record.form == FILE_TREE) node(surface.root);
    if (to.record.form == FILE_LIST)
      for (const PrimRef& part : surface.parts) entry(part.bounds(), BVH4::NodeRef(part.ID()));
    if (to.record.form == FILE_MOVING)
      for (size_t ref : surface.moving) entry(BBox3fa(Vec3fa(zero), Vec3fa(zero)), BVH4::NodeRef(ref));
  }

  SurfaceStatistics statistics; //!< of the blocks in the file

private:
  uint64_t leaf(BVH4::NodeRef ref) {
    size_t type;
    const void* const block = ref.leaf(type);
    if (!isBlock(type))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "the geometry cannot be saved: a part of it is left to GRID "
                     "because of its edge rates or because it has no valid frame; expected compressed blocks "
                     "only, as with cVERT");
    const BlockType blockType = BlockType(type);
    if (!isBlockValid(block, blockType))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
                     "the geometry cannot be saved: the file that it was loaded from has a damaged block");
    if (blockType == TILE_BLOCK)
      return isMeshTile(block) ? tile((const MeshTileHeader*)block) : tile((const VertHeader*)block);
    const BlockRow row = rowOf(blockType);
    return to.append(fileChildOf(blockType, row.moves(block)), block, row.bytes(block), row.surface);
  }

  /*! Files store the tile's vertices as a block. */
  uint64_t tile(const VertHeader* tile) {
    if (isMoving(tile->info)) return movingTile(tile);
    alignas(blockAlignment) uint8_t block[maxBlockBytesOfTile];
    const size_t bytes = blockOfTile(tile, encoder, block);
    BlockBytes(tile, tileBytes(tile)).removeFrom(statistics.sums);
    BlockBytes((const VertHeader*)block, bytes).addTo(statistics.sums);
    statistics.sums.numRawBlocks += isRaw(((const VertHeader*)block)->info);
    return to.append(FILE_VERT, to.keep(block, bytes), uint32_t(bytes), offsetof(VertHeader, surface));
  }

  uint64_t movingTile(const VertHeader* tile) {
    if (!motionEncoder) motionEncoder.reset(new MotionEncoder);
    std::vector<uint32_t> memory(maxBytesOfMovingForms(motionOf(tile).numSteps) / sizeof(uint32_t) + 1);
    uint8_t* const block = (uint8_t*)memory.data();
    MotionStatistics ofBlock;
    const size_t bytes = movingBlockOfTile(tile, *motionEncoder, block, ofBlock);
    BlockBytes(tile, tileBytes(tile)).removeFrom(statistics.sums);
    BlockBytes((const VertHeader*)block, bytes).addTo(statistics.sums);
    statistics.sums.motionBytes += size_t(ofBlock.stepBytes) - size_t(laterStepBytes(tile));
    statistics.sums.numRawBlocks += ofBlock.raw;
    return to.append(fileChildOf(VERT_BLOCK, true), to.keep(block, bytes), uint32_t(bytes),
                     offsetof(VertHeader, surface));
  }

  /*! As above, as a mesh block. */
  uint64_t tile(const MeshTileHeader* tile) {
    if (isMovingMeshTile(tile)) return movingTile(tile);
    alignas(blockAlignment) uint8_t block[MeshEncoder::maxBytes];
    const size_t bytes = meshOfTile(tile, meshEncoder, block);
    BlockBytes(tile, tile->bytes).removeFrom(statistics.sums);
    BlockBytes((const MeshHeader*)block, bytes).addTo(statistics.sums);
    return to.append(FILE_MESH, to.keep(block, bytes), uint32_t(bytes), offsetof(MeshHeader, surface));
  }

  uint64_t movingTile(const MeshTileHeader* tile) {
    if (!meshMotionEncoder) meshMotionEncoder.reset(new MeshMotionEncoder);
    std::vector<uint32_t> memory(MeshMotionEncoder::maxBytes(motionOfMeshTile(tile).numSteps) / sizeof(uint32_t) + 1);
    MeshHeader* const block = (MeshHeader*)memory.data();
    const size_t bytes = movingMeshOfTile(tile, *meshMotionEncoder, (uint8_t*)block);
    BlockBytes(tile, tile->bytes).removeFrom(statistics.sums);
    BlockBytes(block, bytes).addTo(statistics.sums);
    statistics.sums.motionBytes += size_t(laterStepBytes(block)) - size_t(laterStepBytes(tile));
    return to.append(fileChildOf(MESH_BLOCK, true), to.keep(block, bytes), uint32_t(bytes),
                     offsetof(MeshHeader, surface));
  }

  uint64_t child(BVH4::NodeRef ref) {
    if (ref == BVH4::emptyNode) return FILE_NONE;
    return ref.isLeaf() ? leaf(ref) : node(ref);
  }

  uint64_t node(BVH4::NodeRef ref) {
    const BVH4::AABBNode* const from = ref.getAABBNode();
    const size_t begin = to.tree.size();
    to.tree.resize(begin + sizeof(FileNode));
    FileNode node;
    const vfloat4* const planes[3][2] = {
        {&from->lower_x, &from->upper_x}, {&from->lower_y, &from->upper_y}, {&from->lower_z, &from->upper_z}};
    for (size_t i = 0; i < 4; i++) {
      node.children[i] = child(from->child(i));
      for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++)
          node.planes[k][side][i] = node.children[i] == FILE_NONE ? 0.0f : (*planes[k][side])[i];
      if (node.children[i] == FILE_NONE) continue;
      float lower[3], upper[3];
      for (int k = 0; k < 3; k++) {
        lower[k] = node.planes[k][0][i];
        upper[k] = node.planes[k][1][i];
      }
      requireBounds(lower, upper);
    }
    memcpy(to.tree.data() + begin, &node, sizeof(node));
    return begin | FILE_NODE;
  }

  /*! Throws for bounds that loadSurface() rejects. */
  static void requireBounds(const float lower[3], const float upper[3]) {
    if (areBounds(lower, upper)) return;
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry cannot be saved: the bounds of a block are not finite");
  }

  void entry(const BBox3fa& bounds, BVH4::NodeRef ref) {
    if (!ref.isLeaf()) throw_RTCError(RTC_ERROR_UNKNOWN, "a list of blocks has a node");
    FileEntry entry;
    for (int k = 0; k < 3; k++) {
      entry.lower[k] = bounds.lower[k];
      entry.upper[k] = bounds.upper[k];
    }
    requireBounds(entry.lower, entry.upper);
    entry.child = leaf(ref);
    to.tree.insert(to.tree.end(), (const char*)&entry, (const char*)(&entry + 1));
  }

  FileSurface& to;
  VertEncoder encoder;
  MeshEncoder meshEncoder;
  std::unique_ptr<MotionEncoder> motionEncoder; //!< null before the first moving tile, as the next
  std::unique_ptr<MeshMotionEncoder> meshMotionEncoder;
};

/*! Tiles are stored as blocks. */
RTCCompression compressionInFiles(RTCCompression compression) {
  return isExact(compression) ? RTC_COMPRESSION_CVERT : compression;
}

uint32_t sourceOf(const CompressibleGeometry* geometry) {
  switch (geometry->ownType) {
  case Geometry::GTY_GRID_MESH: return FILE_GRIDS;
  case Geometry::GTY_QUAD_MESH: return FILE_QUADS;
  case Geometry::GTY_TRIANGLE_MESH: return FILE_TRIANGLES;
  default: return FILE_CAGE;
  }
}
} // namespace

FileSurface toFileSurface(const CompressibleGeometry* geometry, const SurfaceBlocks& blocks) {
  FileSurface surface;
  const bool moves = geometry->numTimeSteps != 1;
  const TreeConverter converter(blocks, moves, surface);
  FileGeometry& record = surface.record;
  record.source = sourceOf(geometry);
  record.numPrimitives = geometry->numPrimitives;
  record.numTimeSteps = geometry->numTimeSteps;
  record.begin = geometry->time_range.lower;
  record.end = geometry->time_range.upper;
  record.compression =
      moves || record.source != FILE_CAGE
          ? RTC_COMPRESSION_CVERT
          : compressionInFiles(geometry->compression.resolve(geometry->device->compression).compression);
  for (int k = 0; k < 3; k++) {
    record.lower[k] = blocks.bounds.lower[k];
    record.upper[k] = blocks.bounds.upper[k];
  }
  setStatistics(record, converter.statistics);
  return surface;
}
} // namespace embree::cbvh
