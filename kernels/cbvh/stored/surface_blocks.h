// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a geometry and the tree above them. The geometry and each scene that traces it own them. Independent of
 * scenes and IDs. */

#include "../base/block_memory.h"
#include "../base/step_box.h"
#include "../base/surface_ids.h"
#include "../base/surface_statistics.h"
#include <atomic>

namespace embree
{
  namespace cbvh
  {
    class BlockIndex;
    class MappedBlocks;
  }

  struct SurfaceBlocks
  {
    SurfaceBlocks (Device* device, const std::shared_ptr<const cbvh::SurfaceNumber>& number);
    ~SurfaceBlocks ();

    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< number stored in the blocks
    const uint64_t build;                              //!< unique in the process, from 1
    cbvh::BlockMemory memory;

    /*! Parts of a scene's tree, which are blocks or trees of a few blocks: PrimRefs whose ID is a reference. */
    mvector<PrimRef> parts;
    /*! References to the blocks of a moving surface, which has no parts. Scenes build their trees over them. */
    mvector<size_t> moving;
    /*! Boxes of moving blocks at their steps, block by block. Released after the first build; later users decode the
     *  blocks. Accessed with atomic_load and atomic_store, because scenes may be built concurrently. */
    mutable std::shared_ptr<const mvector<cbvh::StepBox>> boxes;
    BVH4::NodeRef root;       //!< tree over all parts, for scenes without other surfaces; empty if there are few parts
    BBox3fa bounds;           //!< bounds of everything that rays can hit
    size_t numPrimitives;     //!< number of blocks and grids
    cbvh::SurfaceStatistics statistics;
    std::shared_ptr<const cbvh::MappedBlocks> mapped;  //!< null unless loaded from a file

    /*! The first call builds the index. Thread-safe. */
    const cbvh::BlockIndex& index () const;

  private:
    mutable std::atomic<const cbvh::BlockIndex*> blockIndex;
  };

  namespace cbvh
  {
    /*! True if one of a scene's moving, or static, surfaces is compressed. */
    bool hasCompressedGeometry (const Scene* scene, bool moves);

    /*! Thread-safe. */
    void updateSurfaceIDs (Scene* scene);

    /*! The first call assigns the number. Thread-safe. */
    std::shared_ptr<const SurfaceNumber> numberOf (CompressibleGeometry* geometry);

    /*! Null if they must be built. */
    std::shared_ptr<const SurfaceBlocks> blocksOf (const CompressibleGeometry* geometry);

    /*! Sets the blocks unless another scene already did. Returns the geometry's blocks. */
    std::shared_ptr<const SurfaceBlocks> keepBlocks (CompressibleGeometry* geometry,
                                                     const std::shared_ptr<const SurfaceBlocks>& blocks);
  }
}
