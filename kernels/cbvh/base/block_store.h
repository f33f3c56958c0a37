// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Collects the blocks that a task of a build writes, in a buffer. flush() copies them to the memory of the surface, and
 * adds a primitive for each: an Embree PrimRef with the block's bounds and its leaf reference, from which the surface's
 * tree is built (building/surface_builder.h). A store is used by one thread. */

#include "../embree/scene.h"
#include "block_memory.h"
#include "kinds.h"
#include "leaf_type.h"
#include "step_box.h"
#include "codec_names.h"
#include "../../cvert/portable/world.h"

namespace embree::isa {
/*! Rounds outwards to floats, so that the box still contains the bounds. */
inline BBox3fa toBBox(const cbvh::WorldBounds& b) {
  auto roundDown = [](double x) {
    const float f = float(x);
    return double(f) <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
  };
  return BBox3fa(Vec3fa(roundDown(b.lower[0]), roundDown(b.lower[1]), roundDown(b.lower[2])),
                 Vec3fa(-roundDown(-b.upper[0]), -roundDown(-b.upper[1]), -roundDown(-b.upper[2])));
}

class BlockStore {
public:
  /*! Bounds of all that rays can hit in the blocks. Writers extend it; commit() and addPrimitive() do not. */
  cbvh::WorldBounds hitBounds;

  /*! memory: memory of the surface. Null if the blocks will be discarded; flush() must then not be called. */
  BlockStore(Device* device, cbvh::BlockMemory* memory)
    : device(device),
      memory(memory),
      prims(device, 0),
      boxes(device, 0),
      bytes(device, 0) {}

  /*! Returns space for the next block, valid until reserve(), add() or flush() is called. The block is discarded
   *  unless commit() follows. */
  uint8_t* reserve(size_t maxBytes) {
    bytes.resize(max(bytes.size(), used + maxBytes));
    return bytes.data() + used;
  }

  /*! Adds the block that was written to the space of the last reserve(). type: a BlockType. readPadding: bytes
   *  after the block that decoders may read. */
  void commit(size_t size, const BBox3fa& bounds, uint32_t type, size_t readPadding = 0) {
    pending.push_back(PendingBlock{used, bounds, type, readPadding});
    used += (size + cbvh::blockAlignment - 1) & ~size_t(cbvh::blockAlignment - 1);
  }

  /*! Adds a copy of a block. */
  void add(const void* block, size_t size, const BBox3fa& bounds, uint32_t type, size_t readPadding = 0) {
    memcpy(reserve(size), block, size);
    commit(size, bounds, type, readPadding);
  }

  /*! Bounds the size of the buffer. For writers whose blocks need not be contiguous; BuildResults::add() flushes
   *  the rest. */
  void flushIfFull() {
    if (used > flushThresholdBytes) flush();
  }

  /*! Copies the buffered blocks and adds their primitives. The blocks share an allocation, because the allocator
   *  rounds up each size. */
  void flush() {
    if (pending.empty()) return;
    char* const copy = (char*)memory->allocate(used + pending.back().readPadding);
    memcpy(copy, bytes.data(), used);
    for (const PendingBlock& block : pending)
      addPrimitive(block.bounds, size_t(BVH4::encodeTypedLeaf(copy + block.offset, block.type)));
    pending.clear();
    used = 0;
  }

  /*! Adds a primitive that is not in the buffer, before the primitives of buffered blocks: call flush() first to
   *  keep the order of patches. reference: a leaf of the surface's tree (BVH4::NodeRef). */
  void addPrimitive(const BBox3fa& bounds, size_t reference) { prims.push_back(PrimRef(bounds, reference)); }

  Device* const device;
  cbvh::BlockMemory* memory;
  mvector<PrimRef> prims;
  mvector<cbvh::StepBox> boxes; //!< boxes of moving blocks per step, in the order of prims

  /*! Buffered bytes above which flushIfFull() flushes. Small, because the end of a piece of memory stays unused if
   *  the next allocation does not fit. */
  static const size_t flushThresholdBytes = 1 << 14;

private:
  struct PendingBlock {
    size_t offset; //!< in `bytes`
    BBox3fa bounds;
    uint32_t type;
    size_t readPadding;
  };
  mvector<uint8_t> bytes;            //!< the buffer, which never shrinks
  size_t used = 0;                   //!< bytes of the buffer that contain blocks
  std::vector<PendingBlock> pending; //!< buffered blocks
};
} // namespace embree::isa
