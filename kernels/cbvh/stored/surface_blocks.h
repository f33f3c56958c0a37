// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a geometry and the tree above them. The geometry and each scene that traces it own them. They do not
 * depend on scenes or on IDs in scenes. */

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

    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< stored in the blocks
    const uint64_t build;                              //!< unique in the process, from 1
    cbvh::BlockMemory memory;

    /*! Parts of a scene's tree: trees of a few blocks, or blocks, as PrimRefs whose ID is a reference. */
    mvector<PrimRef> parts;
    /*! References to the blocks of a moving surface, which has no parts. Scenes build their trees over them. */
    mvector<size_t> moving;
    /*! Boxes of those blocks at their steps, block by block. Released after the first build; later users decode the
     *  blocks. Accessed with atomic_load and atomic_store, because scenes may be built concurrently. */
    mutable std::shared_ptr<const mvector<cbvh::StepBox>> boxes;
    BVH4::NodeRef root;       //!< tree over all parts, for scenes without other surfaces; empty if there are few parts
    BBox3fa bounds;           //!< bounds of everything that rays can hit
    size_t numPrimitives;     //!< blocks and grids
    cbvh::SurfaceStatistics statistics;
    std::shared_ptr<const cbvh::MappedBlocks> mapped;  //!< null unless loaded from a file

    /*! Returns the index for looking up triangles, which the first call creates. Thread-safe. */
    const cbvh::BlockIndex& index () const;

  private:
    mutable std::atomic<const cbvh::BlockIndex*> blockIndex;
  };

  namespace cbvh
  {
    /*! True if one of the moving, or static, surfaces of a scene is compressed. */
    bool hasCompressedGeometry (const Scene* scene, bool moves);

    /*! Sets the table of a scene that maps surface numbers to geometry IDs. Thread-safe. */
    void updateSurfaceIDs (Scene* scene);

    /*! Returns the surface number of a geometry, which the first call assigns. Thread-safe. */
    std::shared_ptr<const SurfaceNumber> numberOf (CompressibleGeometry* geometry);

    /*! Returns the blocks of the last commit, or null if they must be built. */
    std::shared_ptr<const SurfaceBlocks> blocksOf (const CompressibleGeometry* geometry);

    /*! Sets the blocks unless another scene already did. Returns the blocks of the geometry. */
    std::shared_ptr<const SurfaceBlocks> keepBlocks (CompressibleGeometry* geometry,
                                                     const std::shared_ptr<const SurfaceBlocks>& blocks);
  }
}
