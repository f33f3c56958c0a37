// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "surface_conversion.h"
#include "../base/block_bytes.h"
#include "../base/block_store.h"
#include "../base/block_validity.h"
#include "../base/resize_to_fit.h"
#include "../base/thread_cache.h"
#include "../../cvert/decoder/decoded_block.h"
#include "../../cvert/conversion/moving_mesh_tile_conversion.h"
#include "../../cvert/conversion/tile_conversion.h"
#include "block_table.h"
#include "tree.h"

namespace embree::cbvh {
namespace {
const uint32_t exactTypes = 1u << VERT_BLOCK | 1u << TILE_BLOCK | 1u << MESH_BLOCK;

/*! References to the leaves of a tree, depth first. */
void collect(BVH4::NodeRef ref, std::vector<size_t>& leaves) {
  if (ref == BVH4::emptyNode) return;
  if (ref.isLeaf()) return leaves.push_back(ref);
  for (size_t i = 0; i < 4; i++) collect(ref.getAABBNode()->child(i), leaves);
}

/*! Converts a range of leaves. */
class LeafConverter {
public:
  /*! copiesOthers: whether blocks that are not converted are copied. */
  LeafConverter(Device* device, BlockMemory& memory, BlockType form, bool copiesOthers)
    : form(form),
      copiesOthers(copiesOthers),
      store(device, &memory) {}

  /*! The reference changes in finish(). */
  void convert(size_t& ref) {
    size_t type;
    const void* const block = BVH4::NodeRef(ref).leaf(type);
    if (!addConverted((const VertHeader*)block, BlockType(type))) {
      if (!copiesOthers) return;
      store.add(block, rowOf(BlockType(type)).bytes(block), BBox3fa(empty), uint32_t(type), meshTileReadPadding);
    }
    stored.push_back(&ref);
    store.flushIfFull();
  }

  /*! Stores the blocks, and replaces the leaves' references. */
  void finish() {
    store.flush();
    for (size_t i = 0; i < stored.size(); i++) *stored[i] = store.prims[i].ID();
  }

  /*! Bytes that the converted blocks add; negative if they are smaller. */
  std::ptrdiff_t addedBytes() const {
    return std::ptrdiff_t(changes.headerBytes + changes.nodeBytes + changes.leafBytes);
  }

  CompressionStatistics changes; //!< of the surface's statistics: differences, which wrap around

private:
  /*! Returns false if the block remains as it is. */
  bool addConverted(const VertHeader* block, BlockType type) {
    if (form == TILE_BLOCK ? type == TILE_BLOCK || !isBlockValid(block, type) : type != TILE_BLOCK) return false;
    const bool moves = rowOf(type).moves(block);
    if (form != TILE_BLOCK && isMeshTile(block)) return addMesh((const MeshTileHeader*)block, moves);
    if (moves) return type == MESH_BLOCK ? addMovingMeshTile((const MeshHeader*)block) : addMoving(block);
    if (form != TILE_BLOCK) {
      const size_t size = blockOfTile(block, blockEncoder, store.reserve(maxBlockBytesOfTile));
      return add(block, tileBytes(block), size);
    }
    if (type == MESH_BLOCK) return addMeshTile((const MeshHeader*)block);
    if (vertQuadsX(block->region) * vertQuadsY(block->region) < minTileQuads) return false;
    uint8_t* const bytes = store.reserve(maxTileBytesOfBlock);
    const size_t size = tileOfBlock(block, DecodedBlock(block).vertices, vertices, tileEncoder, bytes);
    return size != 0 && add(block, vertBytes(block), size);
  }

  bool addMoving(const VertHeader* block) {
    if (form == TILE_BLOCK && vertQuadsX(block->region) * vertQuadsY(block->region) < minTileQuads) return false;
    uint8_t* const bytes = store.reserve(maxBytesOfMovingForms(motionOf(block).numSteps));
    MotionStatistics unused;
    size_t size;
    if (form == TILE_BLOCK) {
      if (!movingTileEncoder) movingTileEncoder.reset(new MovingTileEncoder);
      size = movingTileOfBlock(block, *movingTileEncoder, bytes, unused);
    } else {
      if (!motionEncoder) motionEncoder.reset(new MotionEncoder);
      size = movingBlockOfTile(block, *motionEncoder, bytes, unused);
    }
    return size != 0 && add(block, rowOf(isTile(block->info) ? TILE_BLOCK : VERT_BLOCK).bytes(block), size);
  }

  bool addMeshTile(const MeshHeader* block) {
    uint8_t* const tile = store.reserve(maxBytesOfMeshTile);
    const size_t size = tileOfMesh(block, tile);
    if (size == 0) return false;
    BlockBytes(block, block->bytes).removeFrom(changes);
    BlockBytes((const MeshTileHeader*)tile, size).addTo(changes);
    store.commit(size, BBox3fa(empty), TILE_BLOCK, meshTileReadPadding);
    return true;
  }

  bool addMovingMeshTile(const MeshHeader* block) {
    if (!movingMeshTileWriter) movingMeshTileWriter.reset(new MovingMeshTileWriter);
    uint8_t* const bytes = store.reserve(maxBytesOfMovingMeshTile(motionOfMesh(block).numSteps));
    const size_t size = movingMeshTileWriter->write(block, bytes);
    if (size == 0) return false;
    const MeshTileHeader* const tile = (const MeshTileHeader*)bytes;
    BlockBytes(block, block->bytes).removeFrom(changes);
    BlockBytes(tile, size).addTo(changes);
    changes.motionBytes += size_t(laterStepBytes(tile)) - size_t(laterStepBytes(block));
    store.commit(size, BBox3fa(empty), TILE_BLOCK, meshTileReadPadding);
    return true;
  }

  bool addMesh(const MeshTileHeader* tile, bool moves) {
    uint8_t* const block = store.reserve(moves ? MeshMotionEncoder::maxBytes(motionOfMeshTile(tile).numSteps)
                                               : size_t(MeshEncoder::maxBytes));
    if (moves && !meshMotionEncoder) meshMotionEncoder.reset(new MeshMotionEncoder);
    const size_t size =
        moves ? movingMeshOfTile(tile, *meshMotionEncoder, block) : meshOfTile(tile, meshEncoder, block);
    BlockBytes(tile, tile->bytes).removeFrom(changes);
    BlockBytes((const MeshHeader*)block, size).addTo(changes);
    changes.motionBytes += size_t(laterStepBytes((const MeshHeader*)block)) - size_t(laterStepBytes(tile));
    store.commit(size, BBox3fa(empty), MESH_BLOCK, vertReadPadding);
    return true;
  }

  /*! Commits what was written to the store's space. */
  bool add(const VertHeader* from, size_t fromSize, size_t size) {
    const VertHeader* const to = (const VertHeader*)store.reserve(size);
    BlockBytes(from, fromSize).removeFrom(changes);
    BlockBytes(to, size).addTo(changes);
    changes.numRawBlocks += size_t(isAnyStepRaw(to)) - size_t(isAnyStepRaw(from));
    changes.motionBytes += size_t(laterStepBytes(to)) - size_t(laterStepBytes(from));
    store.commit(size, BBox3fa(empty), form, vertReadPadding);
    return true;
  }

  const BlockType form;
  const bool copiesOthers;
  isa::BlockStore store;
  BlockVertices vertices;
  TileEncoder tileEncoder;
  VertEncoder blockEncoder;
  MeshEncoder meshEncoder;
  std::unique_ptr<MotionEncoder> motionEncoder; //!< null before the first moving block, as the next ones
  std::unique_ptr<MovingTileEncoder> movingTileEncoder;
  std::unique_ptr<MeshMotionEncoder> meshMotionEncoder;
  std::unique_ptr<MovingMeshTileWriter> movingMeshTileWriter;
  std::vector<size_t*> stored;
};

/*! Copies a tree, with other references to leaves. */
class TreeCopy {
public:
  TreeCopy(FastAllocator& memory, const std::vector<size_t>& leaves) : memory(memory), next(leaves.data()) {}

  BVH4::NodeRef copy(BVH4::NodeRef ref) {
    if (ref == BVH4::emptyNode) return ref;
    if (ref.isLeaf()) return *next++;
    BVH4::AABBNode* const node =
        (BVH4::AABBNode*)memory.getCachedAllocator().malloc0(sizeof(BVH4::AABBNode), BVH4::byteNodeAlignment);
    *node = *ref.getAABBNode();
    numNodes++;
    for (size_t i = 0; i < 4; i++) node->setRef(i, copy(node->child(i)));
    return BVH4::encodeNode(node);
  }

  size_t numNodes = 0;

private:
  FastAllocator& memory;
  const size_t* next;
};

/*! Converts the leaves in parallel, and adds to the statistics of `to`. */
void convertLeaves(Device* device, SurfaceBlocks& to, BlockType form, std::vector<size_t>& leaves,
                   const std::function<void()>& progress) {
  MutexSys mutex;
  parallel_for(size_t(0), leaves.size(), size_t(64), [&](const range<size_t>& r) {
    const std::unique_ptr<LeafConverter> converter(
        new LeafConverter(device, to.memory, form, to.mapped == nullptr)); // large
    for (size_t i = r.begin(); i != r.end(); i++) converter->convert(leaves[i]);
    converter->finish();
    progress();
    Lock<MutexSys> lock(mutex);
    CompressionStatistics& sums = to.statistics.sums;
    sums.headerBytes += converter->changes.headerBytes;
    sums.nodeBytes += converter->changes.nodeBytes;
    sums.leafBytes += converter->changes.leafBytes;
    sums.numRawBlocks += converter->changes.numRawBlocks;
    sums.motionBytes += converter->changes.motionBytes;
  });
}
} // namespace

/*! References to a surface's blocks. */
static std::vector<size_t> leavesOf(const SurfaceBlocks& surface) {
  if (!surface.moving.empty()) return std::vector<size_t>(surface.moving.begin(), surface.moving.end());
  std::vector<size_t> leaves;
  if (surface.root != BVH4::emptyNode) collect(surface.root, leaves);
  else
    for (const PrimRef& part : surface.parts) leaves.push_back(part.ID());
  return leaves;
}

static size_t stepsOf(const SurfaceBlocks& surface) {
  if (surface.moving.empty()) return 1;
  size_t type;
  const void* const block = BVH4::NodeRef(surface.moving.front()).leaf(type);
  return rowOf(BlockType(type)).motion(block).numSteps;
}

bool isConvertible(const SurfaceBlocks& surface) { return surface.types != 0 && !(surface.types & ~exactTypes); }

std::shared_ptr<const SurfaceBlocks> convertSurface(Device* device, const std::shared_ptr<const SurfaceBlocks>& from,
                                                    BlockType form, const std::function<void()>& progress) {
  if (form == VERT_BLOCK && from->unconverted) return from->unconverted;
  const bool hasTree = from->root != BVH4::emptyNode;
  const std::shared_ptr<SurfaceBlocks> to = std::make_shared<SurfaceBlocks>(device, from->number);
  to->mapped = from->mapped;
  if (from->mapped) to->unconverted = from;
  to->bounds = from->bounds;
  to->numPrimRefs = from->numPrimRefs;
  to->statistics = from->statistics;
  std::vector<size_t> leaves = leavesOf(*from);
  if (hasTree || !from->moving.empty()) {
    const size_t expected = form == TILE_BLOCK ? expectedTileBytes : expectedTileBytes / 2;
    to->memory.reserve(leaves.size() * expected * stepsOf(*from), from->statistics.sums.topLevelBytes);
  }
  convertLeaves(device, *to, form, leaves, progress);
  for (size_t ref : leaves) {
    size_t type;
    BVH4::NodeRef(ref).leaf(type);
    to->types |= 1u << type;
  }
  if (form == TILE_BLOCK && formOf(*to) != form) return from; // no block has a tile
  if (hasTree) {
    TreeCopy tree(*to->memory.pool(), leaves);
    const BVH4::NodeRef root = tree.copy(from->root);
    to->root = isa::moveLargestNodes(root, tree.numNodes, *to->memory.pool());
    isa::TreeCutter(to->parts).cut(to->root, to->bounds);
  } else if (!from->moving.empty()) {
    resizeToFit(to->moving, leaves.size());
    std::copy(leaves.begin(), leaves.end(), to->moving.begin());
    to->boxes = std::atomic_load(&from->boxes);
  } else {
    resizeToFit(to->parts, leaves.size());
    for (size_t i = 0; i < leaves.size(); i++) to->parts[i] = PrimRef(from->parts[i].bounds(), leaves[i]);
  }
  to->otherFormBytes = from->statistics.sums.allBytes();
  to->finish();
  invalidateThreadCaches(); // other blocks may have had these addresses
  return to;
}

size_t bytesInOtherForm(Device* device, const SurfaceBlocks& surface) {
  const BlockType form = otherForm(formOf(surface));
  if (form == VERT_BLOCK && surface.unconverted) return surface.unconverted->bytes();
  if (const size_t known = surface.otherFormBytes) return known;
  const size_t maxSample = 64;
  const std::vector<size_t> leaves = leavesOf(surface);
  const size_t step = leaves.size() / maxSample + 1;
  std::vector<size_t> sample;
  for (size_t i = step / 2; i < leaves.size(); i += step) sample.push_back(leaves[i]);
  BlockMemory memory(device);
  const std::unique_ptr<LeafConverter> converter(new LeafConverter(device, memory, form, true)); // large
  for (size_t& ref : sample) converter->convert(ref);
  if (converter->addedBytes() == 0) return surface.bytes(); // no block of the sample has another form
  const double added = double(converter->addedBytes()) / double(sample.size()),
               bytes = double(surface.statistics.sums.allBytes()) + added * double(leaves.size());
  return surface.otherFormBytes = size_t(max(1.0, bytes));
}
} // namespace embree::cbvh
