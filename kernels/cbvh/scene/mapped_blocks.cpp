// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "mapped_blocks.h"
#include "../embree/scene.h"
#include "mapped_file.h"
#include "validate_block.h"
#include <algorithm>
#include <cstdlib>
#include <vector>

namespace embree
{
  namespace cbvh
  {
    /*! The places of all mapped blocks of the process. */
    class MappedPlaces
    {
      /*! Where blocks lie, by value: other threads may delete blocks of geometries that this one does not trace, and those
       *  that it traces stay. */
      struct Place
      {
        const char* begin;
        size_t bytes;
        const MappedBlocks* blocks;

        bool holds (const void* block) const { return size_t((const char*)block-begin) < bytes; }
      };
      typedef std::vector<Place> List; //!< by address

    public:
      /*! Throws std::bad_alloc, and then changes nothing. */
      static void add (MappedBlocks* blocks)
      {
        Lock<MutexSys> lock(mutex);
        std::shared_ptr<const List> next = listOf(blocks);
        blocks->previous = nullptr;
        blocks->next = first;
        if (first) first->previous = blocks;
        first = blocks;
        list = std::move(next);
        isMappedBlockGood.store(isGood);
        hullBegin = std::min(hullBegin,size_t(blocks->begin));
        hullEnd = std::max(hullEnd,size_t(blocks->begin)+blocks->bytes);
        changed();
      }

      /*! Without memory for a new list there is none until the next one is made, and threads look at all blocks. */
      static void remove (MappedBlocks* blocks)
      {
        Lock<MutexSys> lock(mutex);
        (blocks->previous ? blocks->previous->next : first) = blocks->next;
        if (blocks->next) blocks->next->previous = blocks->previous;
        try { list = listOf(nullptr); }
        catch (const std::bad_alloc&) { list.reset(); }
        changed();
      }

    private:
      /*! What the calling thread knows of them: a list is used while a geometry of it is traced, and another may be added to a new one. */
      struct Known
      {
        uint64_t generation = 0;
        std::shared_ptr<const List> list;
        Place last = { nullptr, 0, nullptr }; //!< whose block was the last that was asked for
      };

      static bool isGood (const void* block, bool isVert)
      {
        const Known* const mine = known;
        if (likely(mine && mine->generation == generation.load(std::memory_order_acquire) && mine->last.holds(block))) return mine->last.blocks->isGood(block,isVert);
        return find(block,isVert);
      }

      static bool find (const void* block, bool isVert)
      {
        struct Owner { ~Owner () { delete known; known = nullptr; } };
        if (!known) {
          static thread_local Owner owner; // ends with the thread
          (void)owner;
          known = new Known;
        }
        if (known->generation != generation.load(std::memory_order_acquire)) {
          Lock<MutexSys> lock(mutex);
          known->list = list;
          known->generation = generation.load(std::memory_order_relaxed);
          known->last = Place{ nullptr, 0, nullptr };
        }
        const Place place = known->list ? placeIn(*known->list,block) : placeOfLiving(block);
        if (!place.blocks) return true;
        known->last = place;
        return place.blocks->isGood(block,isVert);
      }

      static Place placeOf (const MappedBlocks* blocks) { return Place{ blocks->begin, blocks->bytes, blocks }; }

      static Place placeIn (const List& list, const void* block)
      {
        const auto next = std::upper_bound(list.begin(),list.end(),block,[](const void* block, const Place& place) { return (const char*)block < place.begin; });
        return next == list.begin() || !(next-1)->holds(block) ? Place{ nullptr, 0, nullptr } : *(next-1);
      }

      static Place placeOfLiving (const void* block)
      {
        Lock<MutexSys> lock(mutex);
        for (const MappedBlocks* blocks=first; blocks; blocks=blocks->next)
          if (placeOf(blocks).holds(block)) return placeOf(blocks);
        return Place{ nullptr, 0, nullptr };
      }

      /*! With the mutex: a list of those that live, and of one more. */
      static std::shared_ptr<const List> listOf (const MappedBlocks* another)
      {
        const std::shared_ptr<List> made = std::make_shared<List>();
        if (another) made->push_back(placeOf(another));
        for (const MappedBlocks* blocks=first; blocks; blocks=blocks->next) made->push_back(placeOf(blocks));
        std::sort(made->begin(),made->end(),[](const Place& a, const Place& b) { return a.begin < b.begin; });
        return made;
      }

      /*! With the mutex. The addresses that others read hold all blocks at any moment. */
      static void changed ()
      {
        if (!first) {
          mappedBytes.store(0);
          hullBegin = ~size_t(0);
          hullEnd = 0;
        }
        else {
          mappedBytes.store(~size_t(0));
          mappedBegin.store(hullBegin,std::memory_order_release);
          mappedBytes.store(hullEnd-hullBegin);
        }
        generation.fetch_add(1);
      }

      static MutexSys mutex;                    //!< of the next three
      static MappedBlocks* first;
      static std::shared_ptr<const List> list;  //!< null if there was no memory for it
      static size_t hullBegin, hullEnd;
      static std::atomic<uint64_t> generation;  //!< of them
      static __thread Known* known __attribute__((tls_model("initial-exec")));
    };

    MutexSys MappedPlaces::mutex;
    MappedBlocks* MappedPlaces::first = nullptr;
    std::shared_ptr<const MappedPlaces::List> MappedPlaces::list;
    size_t MappedPlaces::hullBegin = ~size_t(0), MappedPlaces::hullEnd = 0;
    std::atomic<uint64_t> MappedPlaces::generation(0);
    __thread MappedPlaces::Known* MappedPlaces::known = nullptr;

    MappedBlocks::MappedBlocks (Device* device, const std::shared_ptr<const MappedFile>& file, char* begin, size_t bytes, const Limits& limits, const std::string& name)
      : device(device), file(file), begin(begin), bytes(bytes), limits(limits), name(name), good(nullptr), isReported(false)
    {
      static_assert(sizeof(std::atomic<uint64_t>) == sizeof(uint64_t),"zeros are bits");
      /* pages of zeros, which take memory where blocks are met */
      good = (std::atomic<uint64_t>*)calloc(bytes/(16*64)+1,sizeof(uint64_t));
      if (!good) throw std::bad_alloc();
      try { MappedPlaces::add(this); }
      catch (...) { free(good); throw; }
    }

    MappedBlocks::~MappedBlocks ()
    {
      MappedPlaces::remove(this);
      free(good);
    }

    static const char* errorOfPrimitives (const VertHeader* block, uint32_t numPrimitives)
    {
      if (block->primID >= numPrimitives) return "a primitive that the geometry has not";
      if (!hasNumbers(block->boxForm)) return nullptr;
      for (uint32_t y=0; y<vertQuadsY(block->region); y++)
        for (uint32_t x=0; x<vertQuadsX(block->region); x++)
          if (primitiveOfNumber(block->patchQuads,numberOfQuad(block,x,y),isOfTriangles(block->patchQuads)) >= numPrimitives) return "a primitive that the geometry has not";
      return nullptr;
    }

    const char* MappedBlocks::errorOf (size_t offset, bool isVert, bool moves) const
    {
      if (offset >= bytes || offset % blockAlignment) return "no place of a block";
      const char* const data = begin+offset;
      const size_t left = bytes-offset;
      if (!isVert)
      {
        if (left < blockHeaderBytes) return "fewer bytes than a header has";
        const BlockHeader* const block = (const BlockHeader*)data;
        const uint32_t kind = kindOf(block->info);
        if (kind >= numKindFormats || !((framedKinds >> kind) & 1)) return "a kind that is none";
        if (const char* error = validateBlock(kind,data,left)) return error;
        if (!isOwnSurface(offset,isVert)) return "another surface";
        return block->primID >= limits.numPrimitives ? "a primitive that the geometry has not" : nullptr;
      }
      if (const char* error = validateBlock(kindVert,data,left)) return error;
      const VertHeader* const block = (const VertHeader*)data;
      if (!isOwnSurface(offset,isVert)) return "another surface";
      if (isMoving(block->boxForm) != moves) return moves ? "no time steps" : "time steps";
      if (moves) {
        const VertMotion motion = motionOf(block);
        if (motion.numSteps != limits.numTimeSteps || motion.begin != limits.begin || motion.end != limits.end) return "other time steps than the geometry has";
      }
      return errorOfPrimitives(block,limits.numPrimitives);
    }

    AtomicRef<uint32_t> MappedBlocks::surfaceOf (size_t offset, bool isVert) const {
      return AtomicRef<uint32_t>(isVert ? ((VertHeader*)(begin+offset))->surface : ((BlockHeader*)(begin+offset))->surface);
    }

    bool MappedBlocks::isOwnSurface (size_t offset, bool isVert) const
    {
      const uint32_t surface = surfaceOf(offset,isVert).load(std::memory_order_acquire);
      return surface == limits.surface || surface == limits.number;
    }

    void MappedBlocks::number (size_t offset, bool isVert) const
    {
      /* Several threads may check a block at the same time; one of them writes, before any of them calls it good. */
      uint32_t expected = limits.surface;
      if (limits.surface != limits.number) surfaceOf(offset,isVert).exchange(expected,limits.number,std::memory_order_acq_rel);
    }

    bool MappedBlocks::check (size_t offset, bool isVert) const
    {
      if (const char* error = errorOf(offset,isVert,false)) {
        if (!isReported.exchange(true)) {
          const std::string message = name + ": the block at " + std::to_string(offset) + " is damaged, and maybe others: " + error + "; rays do not meet it";
          Device::process_error(device,RTC_ERROR_INVALID_ARGUMENT,message.c_str());
        }
        return false;
      }
      number(offset,isVert);
      good[offset/(16*64)].fetch_or(uint64_t(1) << (offset/16 % 64),std::memory_order_release);
      return true;
    }
  }
}
