// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a geometry becomes: its blocks, and the tree above them. The geometry owns it, and so does each scene that traces it; no
 * scene, and no ID that a geometry has in one, is in it. */

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

    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< that blocks have
    const uint64_t build;                              //!< that no others have, before or later; from 1
    cbvh::BlockMemory memory;

    /*! What a scene's tree is made of: trees of few blocks, or the blocks, as PrimRefs that have a reference for an ID. */
    mvector<PrimRef> parts;
    mvector<size_t> moving;   //!< references to the blocks of a surface that moves, which has no parts: scenes build their trees of these
    /*! Where those blocks are at their steps, one after the other, until a scene has built a tree of them; later null, for who needs it decodes
     *  them. To be taken and let go by atomic_load and atomic_store, as scenes are built at a time. */
    mutable std::shared_ptr<const mvector<cbvh::StepBox>> boxes;
    BVH4::NodeRef root;       //!< of all parts, for a scene that has no other surface; empty if there are few
    BBox3fa bounds;           //!< of all that a ray may hit
    size_t numPrimitives;     //!< blocks and grids
    cbvh::SurfaceStatistics statistics;
    std::shared_ptr<const cbvh::MappedBlocks> mapped;  //!< where the blocks lie if they came from a file, else null

    /*! of the blocks, for who looks triangles up; made with the first call */
    const cbvh::BlockIndex& index () const;

  private:
    mutable std::atomic<const cbvh::BlockIndex*> blockIndex;
  };

  namespace cbvh
  {
    /*! whether one of the surfaces of a scene that move, or of those that do not, is compressed */
    bool hasCompressedGeometry (const Scene* scene, bool moves);

    /*! Makes the table of a scene that takes numbers to IDs. Any thread may call it, also while others do. */
    void nameSurfaces (Scene* scene);

    /*! of a geometry; made with the first call */
    std::shared_ptr<const SurfaceNumber> numberOf (CompressibleGeometry* geometry);

    /*! of a geometry as it was committed last, or null if they are to be built */
    std::shared_ptr<const SurfaceBlocks> blocksOf (const CompressibleGeometry* geometry);

    /*! Gives a geometry its blocks, unless another scene was faster; those that it has then. */
    std::shared_ptr<const SurfaceBlocks> keepBlocks (CompressibleGeometry* geometry, const std::shared_ptr<const SurfaceBlocks>& blocks);
  }
}
