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
    namespace
    {
      /*! Where blocks lie, by value: other threads may delete blocks of geometries that this one does not trace, and those that it traces stay. */
      struct Place
      {
        const char* begin;
        size_t bytes;
        const MappedBlocks* blocks;

        bool holds (const void* block) const { return size_t((const char*)block-begin) < bytes; }
      };
      typedef std::vector<Place> All;

      MutexSys mutex;                          //!< of the next two
      std::shared_ptr<const All> all;          //!< by address
      size_t hullBegin = ~size_t(0), hullEnd = 0;
      std::atomic<uint64_t> generation(0);     //!< of them

      /*! What the calling thread knows of them: a list is used while a geometry of it is traced, and another may be added to a new one. */
      struct Known
      {
        uint64_t generation = 0;
        std::shared_ptr<const All> all;
        Place last = { nullptr, 0, nullptr }; //!< whose block was the last that was asked for
      };
      __thread Known* known __attribute__((tls_model("initial-exec"))) = nullptr;

      bool find (const void* block, bool isVert)
      {
        struct Owner { ~Owner () { delete known; known = nullptr; } };
        if (!known) {
          static thread_local Owner owner; // ends with the thread
          (void)owner;
          known = new Known;
        }
        if (known->generation != generation.load(std::memory_order_acquire)) {
          Lock<MutexSys> lock(mutex);
          known->all = all;
          known->generation = generation.load(std::memory_order_relaxed);
          known->last = Place{ nullptr, 0, nullptr };
        }
        const All& list = *known->all;
        const auto next = std::upper_bound(list.begin(),list.end(),block,[](const void* block, const Place& place) { return (const char*)block < place.begin; });
        if (next == list.begin() || !(next-1)->holds(block)) return true;
        known->last = *(next-1);
        return known->last.blocks->isGood(block,isVert);
      }

      bool isGood (const void* block, bool isVert)
      {
        const Known* const mine = known;
        if (likely(mine && mine->generation == generation.load(std::memory_order_acquire) && mine->last.holds(block))) return mine->last.blocks->isGood(block,isVert);
        return find(block,isVert);
      }

      /*! with the mutex; the addresses that others read hold all blocks at any moment */
      void setHull (const All& list)
      {
        if (list.empty()) {
          mappedBytes.store(0);
          hullBegin = ~size_t(0);
          hullEnd = 0;
          return;
        }
        mappedBytes.store(~size_t(0));
        mappedBegin.store(hullBegin,std::memory_order_release);
        mappedBytes.store(hullEnd-hullBegin);
      }
    }

    MappedBlocks::MappedBlocks (Device* device, const std::shared_ptr<const MappedFile>& file, char* begin, size_t bytes, const Limits& limits, const std::string& name)
      : device(device), file(file), begin(begin), bytes(bytes), limits(limits), name(name), good(nullptr), isReported(false)
    {
      static_assert(sizeof(std::atomic<uint64_t>) == sizeof(uint64_t),"zeros are bits");
      /* pages of zeros, which take memory where blocks are met */
      good = (std::atomic<uint64_t>*)calloc(bytes/(16*64)+1,sizeof(uint64_t));
      if (!good) throw std::bad_alloc();
      try {
        std::shared_ptr<All> next = std::make_shared<All>();
        Lock<MutexSys> lock(mutex);
        if (all) *next = *all;
        const Place place = { begin, bytes, this };
        next->insert(std::upper_bound(next->begin(),next->end(),place,[](const Place& a, const Place& b) { return a.begin < b.begin; }),place);
        all = next;
        isMappedBlockGood.store(cbvh::isGood);
        hullBegin = std::min(hullBegin,size_t(begin));
        hullEnd = std::max(hullEnd,size_t(begin)+bytes);
        setHull(*next);
        generation.fetch_add(1);
      }
      catch (...) { free(good); throw; }
    }

    MappedBlocks::~MappedBlocks ()
    {
      {
        std::shared_ptr<All> next = std::make_shared<All>();
        Lock<MutexSys> lock(mutex);
        for (const Place& place : *all)
          if (place.blocks != this) next->push_back(place);
        all = next;
        setHull(*next);
        generation.fetch_add(1);
      }
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
        if (block->surface != limits.surface && block->surface != limits.number) return "another surface";
        return block->primID >= limits.numPrimitives ? "a primitive that the geometry has not" : nullptr;
      }
      if (const char* error = validateBlock(kindVert,data,left)) return error;
      const VertHeader* const block = (const VertHeader*)data;
      if (block->surface != limits.surface && block->surface != limits.number) return "another surface";
      if (isMoving(block->boxForm) != moves) return moves ? "no time steps" : "time steps";
      if (moves) {
        const VertMotion motion = motionOf(block);
        if (motion.numSteps != limits.numTimeSteps || motion.begin != limits.begin || motion.end != limits.end) return "other time steps than the geometry has";
      }
      return errorOfPrimitives(block,limits.numPrimitives);
    }

    void MappedBlocks::number (size_t offset, bool isVert) const
    {
      uint32_t& surface = isVert ? ((VertHeader*)(begin+offset))->surface : ((BlockHeader*)(begin+offset))->surface;
      /* several threads may write it, the same */
      if (limits.surface != limits.number) ((std::atomic<uint32_t>*)&surface)->store(limits.number,std::memory_order_relaxed);
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
      good[offset/(16*64)].fetch_or(uint64_t(1) << (offset/16 % 64),std::memory_order_relaxed);
      return true;
    }
  }
}
