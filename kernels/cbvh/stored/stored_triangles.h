// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles of a surface as its blocks hold them, for who asks for them outside of traversal. */

#include "../framed/block.h"
#include "../base/codec.h"
#include "../base/primitive_type.h"
#include "../../cvert/format/mesh_block.h"
#include "part.h"
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace embree
{
  struct SurfaceBlocks;

  namespace cbvh
  {
    /*! When rays are traced that triangles are looked up for, and how: whether their device multiplies and adds at once. */
    struct TraversalTime
    {
      float time;   //!< as of rays
      bool isFused;
    };

    /*! a block of cVERT or cGRID, or a mesh block */
    struct StoredBlock
    {
      const void* data;
      BlockForm form;

      bool isVert () const { return form == VERT_FORM; }
      bool isMesh () const { return form == MESH_FORM; }

      const VertHeader* vert () const { return (const VertHeader*)data; }
      const Block* framed () const { return (const Block*)data; }
      const MeshHeader* mesh () const { return (const MeshHeader*)data; }

      uint32_t primID () const { return isVert() ? vert()->primID : isMesh() ? mesh()->primID : framed()->primID; }

      /*! whether each of its quads is a primitive */
      bool numbersQuads () const { return isVert() && hasNumbers(vert()->boxForm); }
    };

    /*! Blocks of a surface by their primitives. */
    class BlockIndex
    {
    public:
      /*! Throws where a block is neither cVERT nor cGRID. */
      explicit BlockIndex (const SurfaceBlocks& blocks);

      /*! see core/stored_surface.h */
      bool find (const TraversalTime& time, uint32_t primID, float u, float v, const float* Ng,
          StoredTriangle& triangle) const;

    private:
      enum : uint32_t { none = 0xFFFFFFFFu };

      std::vector<StoredBlock> blocks; //!< in the order of primitives
      std::vector<uint32_t> blockOf;   //!< of each primitive, if they are those of a mesh; else empty
      /*! Primitive and block, in order: quads with triangles in a second mesh block. */
      std::vector<std::pair<uint32_t,uint32_t>> secondBlockOf;

      void add (uint32_t primID, uint32_t block);
    };

    /*! Calls closure(block, part) for the blocks of a surface until it returns false. Each triangle of a mesh block is a part of its own, and
     *  each quad, if both of its triangles are in the block. Throws where a block is none of cVERT or cGRID. */
    void forEachPart (const SurfaceBlocks& blocks, const TraversalTime& time,
        const std::function<bool(const StoredBlock&, const StoredPart&)>& closure);
  }
}
