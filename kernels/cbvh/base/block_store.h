// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Buffers a task's blocks, copies them to memory of the surface when a patch is complete, and lists the top-level
 * primitives that refer to them. */

#include "../embree/scene.h"
#include "block_memory.h"
#include "kinds.h"
#include "primitive_type.h"
#include "step_box.h"
#include "codec.h"
#include "../../cvert/basics/world.h"

namespace embree
{
  namespace isa
  {
    /*! Rounds outwards. */
    inline BBox3fa toBBox (const cbvh::WorldBounds& b)
    {
      auto below = [](double x) {
        const float f = float(x);
        return double(f) <= x ? f : std::nextafter(f,-std::numeric_limits<float>::infinity());
      };
      return BBox3fa(Vec3fa(below(b.lower[0]),below(b.lower[1]),below(b.lower[2])),
                     Vec3fa(-below(-b.upper[0]),-below(-b.upper[1]),-below(-b.upper[2])));
    }

    class BlockStore
    {
    public:
      cbvh::WorldBounds hitBounds;  //!< bounds of everything that rays can hit

      /*! memory: null if nothing is kept. */
      BlockStore (Device* device, cbvh::BlockMemory* memory)
        : device(device), memory(memory), prims(device,0), boxes(device,0), bytes(device,0) {}

      /*! The result is valid until the next call. */
      uint8_t* begin (size_t maxBytes)
      {
        bytes.resize(max(bytes.size(),used+maxBytes));
        return bytes.data()+used;
      }

      /*! type: see primitive_type.h. readPast: bytes after the block that decoders may read. */
      void end (size_t size, const BBox3fa& bounds, uint32_t type, size_t readPast = 0)
      {
        waiting.push_back(Waiting{ used,bounds,type,readPast });
        used += (size + cbvh::blockAlignment-1) & ~size_t(cbvh::blockAlignment-1);
      }

      void add (const void* block, size_t size, const BBox3fa& bounds, uint32_t type)
      {
        memcpy(begin(size),block,size);
        end(size,bounds,type);
      }

      void flushIfFull () { if (used > fullPieceBytes) flush(); }

      /*! Copies the buffered blocks to memory of the surface and creates primitives. Allocates large pieces, because
       *  the allocator rounds each one up, but supports at most 2 MiB. */
      void flush ()
      {
        for (size_t i=0, next; i<waiting.size(); i=next)
        {
          const size_t from = waiting[i].offset;
          for (next=i+1; next<waiting.size() && waiting[next].offset-from < maxPieceBytes; next++);
          const size_t size = (next < waiting.size() ? waiting[next].offset : used) - from;
          char* piece = (char*)(*memory)(size+waiting[next-1].readPast);
          memcpy(piece,bytes.data()+from,size);
          for (size_t k=i; k<next; k++)
            add(waiting[k].bounds,size_t(BVH4::encodeTypedLeaf(piece+(waiting[k].offset-from),waiting[k].type)));
        }
        waiting.clear();
        used = 0;
      }

      void add (const BBox3fa& bounds, size_t reference) { prims.push_back(PrimRef(bounds,reference)); }

      Device* const device;
      cbvh::BlockMemory* memory;
      mvector<PrimRef> prims;
      mvector<cbvh::StepBox> boxes; //!< boxes of moving blocks per step, in the order of prims

      static const size_t fullPieceBytes = 1 << 14;

    private:
      static const size_t maxPieceBytes = 1 << 20; // the allocator wastes memory after larger pieces

      struct Waiting
      {
        size_t offset;
        BBox3fa bounds;
        uint32_t type;
        size_t readPast;
      };
      mvector<uint8_t> bytes;
      size_t used = 0;
      std::vector<Waiting> waiting;
    };
  }
}
