// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "loaded_tiles.h"
#include "../base/block_bytes.h"
#include "../base/block_store.h"
#include "../base/block_validity.h"
#include "../base/kinds.h"
#include "../blocks/surface_blocks.h"
#include "../../cvert/decoder/decoded_block.h"
#include "../../cvert/encoder/tile_conversion.h"

namespace embree::cbvh {
namespace {
/*! A reference to a block in a surface's tree or list. */
struct Leaf {
  size_t ref;
  BVH4::NodeRef* place; //!< null in a list
};

void collect(BVH4::NodeRef& ref, std::vector<Leaf>& leaves) {
  if (ref == BVH4::emptyNode) return;
  if (ref.isLeaf()) return leaves.push_back(Leaf{ref, &ref});
  for (size_t i = 0; i < 4; i++) collect(ref.getAABBNode()->child(i), leaves);
}

/*! Makes tiles of a range of leaves. */
class TileMaker {
public:
  TileMaker(Device* device, BlockMemory& memory) : store(device, &memory) {}

  void make(Leaf& leaf) {
    if (addTile(leaf.ref)) made.push_back(&leaf);
  }

  /*! Stores the tiles, and replaces the leaves' references. */
  void finish() {
    store.flush();
    for (size_t i = 0; i < made.size(); i++) made[i]->ref = store.prims[i].ID();
  }

  CompressionStatistics changes; //!< of the surface's statistics: differences, which wrap around

private:
  /*! Returns false if the block remains. */
  bool addTile(size_t ref) {
    size_t type;
    const VertHeader* const block = (const VertHeader*)BVH4::NodeRef(ref).leaf(type);
    if (type != VERT_BLOCK || !isBlockValid(block, VERT_BLOCK)) return false;
    if (vertQuadsX(block->region) * vertQuadsY(block->region) < minTileQuads) return false;
    uint8_t* const bytes = store.reserve(maxTileBytesOfBlock);
    const size_t size = tileOfBlock(block, DecodedBlock(block).vertices, vertices, encoder, bytes);
    if (size == 0) return false;
    BlockBytes(block, vertBytes(block)).removeFrom(changes);
    BlockBytes((const VertHeader*)bytes, size).addTo(changes);
    changes.numRawBlocks -= isRaw(block->info);
    store.commit(size, BBox3fa(empty), TILE_BLOCK, vertReadPadding);
    store.flushIfFull();
    return true;
  }

  isa::BlockStore store;
  BlockVertices vertices;
  TileEncoder encoder;
  std::vector<Leaf*> made;
};
} // namespace

bool makesTilesOfFiles(const Device* device) {
  Kind kind;
  return findKind(device->compression.compression, kind) && kind == Kind::CTILE;
}

void makeTiles(Device* device, SurfaceBlocks& surface, BVH4::NodeRef& root) {
  std::vector<Leaf> leaves;
  if (root == BVH4::emptyNode)
    for (const PrimRef& part : surface.parts) leaves.push_back(Leaf{size_t(part.ID()), nullptr});
  else collect(root, leaves);

  CompressionStatistics& sums = surface.statistics.sums;
  MutexSys mutex;
  parallel_for(size_t(0), leaves.size(), size_t(64), [&](const range<size_t>& r) {
    const std::unique_ptr<TileMaker> maker(new TileMaker(device, surface.memory)); // large
    for (size_t i = r.begin(); i != r.end(); i++) maker->make(leaves[i]);
    maker->finish();
    Lock<MutexSys> lock(mutex);
    sums.headerBytes += maker->changes.headerBytes;
    sums.nodeBytes += maker->changes.nodeBytes;
    sums.leafBytes += maker->changes.leafBytes;
    sums.numRawBlocks += maker->changes.numRawBlocks;
  });
  surface.types = 0;
  for (size_t i = 0; i < leaves.size(); i++) {
    const BVH4::NodeRef ref(leaves[i].ref);
    if (leaves[i].place) *leaves[i].place = ref;
    else surface.parts[i] = PrimRef(surface.parts[i].bounds(), size_t(ref));
    size_t type;
    ref.leaf(type);
    surface.types |= 1u << type;
  }
}
} // namespace embree::cbvh
