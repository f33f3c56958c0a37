// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a geometry and the tree above them, which building/surface_builder.h or files/loaded_surface.h makes.
 * Independent of scenes and geometry IDs: shared by the geometry and all scenes that trace it. Immutable once built,
 * except for `boxes` and the index. */

#include "../base/block_memory.h"
#include "../base/step_box.h"
#include "../base/surface_ids.h"
#include "../base/surface_statistics.h"
#include "../settings/memory_budget.h"
#include <atomic>

namespace embree {
namespace cbvh {
class BlockIndex;
class MappedBlocks;
} // namespace cbvh

struct SurfaceBlocks {
  SurfaceBlocks(Device* device, const std::shared_ptr<const cbvh::SurfaceNumber>& number);
  ~SurfaceBlocks();

  std::shared_ptr<const cbvh::SurfaceNumber> number; //!< number stored in the blocks
  const uint64_t buildID;                            //!< unique in the process, from 1
  cbvh::BlockMemory memory;

  /*! Bounds and BVH4::NodeRefs of the parts over which scenes build their trees: blocks and grids, or subtrees
   *  of a few. */
  mvector<PrimRef> parts;
  /*! BVH4::NodeRefs of the blocks of a moving surface, which has no parts, for the trees of scenes. */
  mvector<size_t> moving;
  /*! Boxes of moving blocks at their steps, block by block. Null once a scene has built its tree, and for surfaces of
   *  files: scenes then decode the blocks. Use atomic_load and atomic_store, because scenes may be built
   *  concurrently. */
  mutable std::shared_ptr<const mvector<cbvh::StepBox>> boxes;
  BVH4::NodeRef root; //!< tree over all parts, for scenes without other surfaces; emptyNode if there is none
  BBox3fa bounds;     //!< bounds of everything that rays can hit
  size_t numPrimRefs; //!< number of blocks and grids
  uint32_t types = 0; //!< their types, as a mask: bit t for type t of leaves (base/leaf_type.h)
  cbvh::SurfaceStatistics statistics;
  std::shared_ptr<const cbvh::MappedBlocks> mapped; //!< null unless loaded from a file
  mutable std::atomic<size_t> otherFormBytes{0};    //!< of surface_conversion.h: its estimate, or 0
  /*! The surface as it was loaded, of one whose blocks were converted after that (surface_conversion.h), else null. */
  std::shared_ptr<const SurfaceBlocks> unconverted;

  /*! Bytes of blocks and tree in memory: without blocks that are mapped. */
  size_t bytes() const;

  /*! Must be called once built: releases unused memory, and counts the rest against the device's budget. */
  void finish();

  /*! Returns the index for core::findTriangle(). The first call builds it. Thread-safe. Throws as BlockIndex(). */
  const cbvh::BlockIndex& index() const;

private:
  cbvh::BudgetedBytes counted;
  mutable std::atomic<const cbvh::BlockIndex*> blockIndex;
};

namespace cbvh {
/*! True if one of a scene's enabled moving, or static, surfaces is compressed. */
bool hasCompressedGeometry(const Scene* scene, bool moves);

/*! Sets scene->surfaceIDs, which maps surface numbers to geometry IDs. Thread-safe. */
void updateSurfaceIDs(Scene* scene);

/*! Returns the surface number of a geometry, which the first call assigns. Thread-safe. */
std::shared_ptr<const SurfaceNumber> numberOf(CompressibleGeometry* geometry);

/*! Returns the blocks of a geometry, or null if they must be built. Thread-safe. */
std::shared_ptr<const SurfaceBlocks> blocksOf(const CompressibleGeometry* geometry);

/*! Sets the blocks of a geometry, unless a concurrent build of another scene did. Returns the geometry's blocks.
 *  Thread-safe. */
std::shared_ptr<const SurfaceBlocks> setBlocks(CompressibleGeometry* geometry,
                                               const std::shared_ptr<const SurfaceBlocks>& blocks);

/*! Replaces the blocks of a geometry by the same surface in another form. Scenes that trace the former keep them.
 *  Thread-safe. */
void replaceBlocks(CompressibleGeometry* geometry, const std::shared_ptr<const SurfaceBlocks>& blocks);
} // namespace cbvh
} // namespace embree
