// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "mapped_blocks.h"
#include "../embree/scene.h"
#include "../stored/block_bytes.h"
#include "validate_framed.h"
#include "../../cvert/file/record.h"
#include <algorithm>
#include <cstdlib>
#include <new>
#include <vector>

namespace embree
{
  namespace cbvh
  {
    /*! All MappedBlocks of the process, to find the owner of a block by its address. Each thread has a copy of the
     *  sorted list and remembers the last owner, so that rays need no lock. */
    class MappedBlockRegistry
    {
      /*! Range of addresses. A copy of the members of MappedBlocks, because other threads may delete the MappedBlocks
       *  of geometries that the calling thread does not trace. */
      struct Place
      {
        const char* begin;
        size_t bytes;
        const MappedBlocks* blocks;

        bool holds (const void* block) const { return size_t((const char*)block-begin) < bytes; }
      };
      typedef std::vector<Place> List; //!< sorted by address

    public:
      /*! If std::bad_alloc is thrown, nothing was changed. */
      static void add (MappedBlocks* blocks)
      {
        Lock<MutexSys> lock(mutex);
        std::shared_ptr<const List> next = listOf(blocks);
        blocks->previous = nullptr;
        blocks->next = first;
        if (first) first->previous = blocks;
        first = blocks;
        list = std::move(next);
        isMappedBlockValid.store(isValid);
        hullBegin = std::min(hullBegin,size_t(blocks->begin));
        hullEnd = std::max(hullEnd,size_t(blocks->begin)+blocks->bytes);
        changed();
      }

      /*! If there is no memory for a new list, threads search all blocks until a list is made. */
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
      /*! A thread's copy. Between two uses the list may be outdated, but it contains all geometries that the thread is
       *  tracing. */
      struct Known
      {
        uint64_t generation = 0;
        std::shared_ptr<const List> list;
        Place last = { nullptr, 0, nullptr }; //!< place of the last block
      };

      static bool isValid (const void* block, BlockFormat format)
      {
        const Known* const mine = known;
        if (likely(mine && mine->generation == generation.load(std::memory_order_acquire) && mine->last.holds(block)))
          return mine->last.blocks->isValid(block,format);
        return find(block,format);
      }

      static bool find (const void* block, BlockFormat format)
      {
        struct Owner { ~Owner () { delete known; known = nullptr; } };
        if (!known) {
          static thread_local Owner owner; // frees the cache at the thread's end
          (void)owner;
          known = new Known;
        }
        if (known->generation != generation.load(std::memory_order_acquire)) {
          Lock<MutexSys> lock(mutex);
          known->list = list;
          known->generation = generation.load(std::memory_order_relaxed);
          known->last = Place{ nullptr, 0, nullptr };
        }
        const Place place = known->list ? placeIn(*known->list,block) : placeOfRegistered(block);
        if (!place.blocks) return true;
        known->last = place;
        return place.blocks->isValid(block,format);
      }

      static Place placeOf (const MappedBlocks* blocks) { return Place{ blocks->begin, blocks->bytes, blocks }; }

      static Place placeIn (const List& list, const void* block)
      {
        const auto next = std::upper_bound(list.begin(),list.end(),block,
          [](const void* block, const Place& place) { return (const char*)block < place.begin; });
        return next == list.begin() || !(next-1)->holds(block) ? Place{ nullptr, 0, nullptr } : *(next-1);
      }

      static Place placeOfRegistered (const void* block)
      {
        Lock<MutexSys> lock(mutex);
        for (const MappedBlocks* blocks=first; blocks; blocks=blocks->next)
          if (placeOf(blocks).holds(block)) return placeOf(blocks);
        return Place{ nullptr, 0, nullptr };
      }

      /*! Returns a new list of all registered MappedBlocks, and of `another` unless null. The mutex must be locked. */
      static std::shared_ptr<const List> listOf (const MappedBlocks* another)
      {
        const std::shared_ptr<List> made = std::make_shared<List>();
        if (another) made->push_back(placeOf(another));
        for (const MappedBlocks* blocks=first; blocks; blocks=blocks->next) made->push_back(placeOf(blocks));
        std::sort(made->begin(),made->end(),[](const Place& a, const Place& b) { return a.begin < b.begin; });
        return made;
      }

      /*! Publishes a change. The mutex must be locked. First extends the range to all addresses, so that it contains
       *  all blocks for readers that see a part of the change (base/mapped_blocks.h). */
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

      static MutexSys mutex;                    //!< protects the next four members
      static MappedBlocks* first;
      static std::shared_ptr<const List> list;  //!< null if there was no memory for it
      static size_t hullBegin, hullEnd;         //!< range of addresses; grows until no file is mapped
      static std::atomic<uint64_t> generation;  //!< incremented by each change
      static __thread Known* known __attribute__((tls_model("initial-exec")));
    };

    MutexSys MappedBlockRegistry::mutex;
    MappedBlocks* MappedBlockRegistry::first = nullptr;
    std::shared_ptr<const MappedBlockRegistry::List> MappedBlockRegistry::list;
    size_t MappedBlockRegistry::hullBegin = ~size_t(0), MappedBlockRegistry::hullEnd = 0;
    std::atomic<uint64_t> MappedBlockRegistry::generation(0);
    __thread MappedBlockRegistry::Known* MappedBlockRegistry::known = nullptr;

    MappedBlocks::MappedBlocks (Device* device, const std::shared_ptr<const File>& file, char* begin,
                                const FileGeometry& record, uint32_t number, const std::string& name)
      : device(device), file(file), begin(begin), record(record), bytes(size_t(record.blockBytes)),
        surfaceNumber(number), name(name), validBlocks(nullptr), isReported(false)
    {
      static_assert(sizeof(std::atomic<uint64_t>) == sizeof(uint64_t),"calloc initializes the bits");
      /* calloc maps pages of zeros, which need memory only where rays reach blocks */
      validBlocks = (std::atomic<uint64_t>*)calloc(bytes/(16*64)+1,sizeof(uint64_t));
      if (!validBlocks) throw std::bad_alloc();
      try { MappedBlockRegistry::add(this); }
      catch (...) { free(validBlocks); throw; }
    }

    MappedBlocks::~MappedBlocks ()
    {
      MappedBlockRegistry::remove(this);
      free(validBlocks);
    }

    Reason MappedBlocks::validate (size_t offset, BlockFormat format) const
    {
      if (offset >= bytes || offset % blockAlignment)
        return Reason::damaged("its offset is %: expected a multiple of 16 within the blocks of the geometry",offset);
      const char* const block = begin+offset;
      const Reason reason = format == MESH_FORMAT ? validateMeshBlock(record,block,bytes-offset)
        : format == VERT_FORMAT ? validateVertBlock(record,block,bytes-offset)
        : validateFramedBlock(block,bytes-offset,record.numPrimitives);
      if (reason) return reason;
      return isOwnSurface(offset,format) ? Reason() : Reason::damaged("its surface number differs from its geometry's");
    }

    AtomicRef<uint32_t> MappedBlocks::surfaceOf (size_t offset, BlockFormat format) const {
      return AtomicRef<uint32_t>(*(uint32_t*)(begin+offset+offsetOfSurface(format)));
    }

    bool MappedBlocks::isOwnSurface (size_t offset, BlockFormat format) const
    {
      const uint32_t surface = surfaceOf(offset,format).load(std::memory_order_acquire);
      return surface == record.surface || surface == surfaceNumber;
    }

    void MappedBlocks::setSurfaceNumber (size_t offset, BlockFormat format) const
    {
      /* Several threads may check a block. One of them writes before any of them marks the block. */
      uint32_t expected = record.surface;
      if (record.surface != surfaceNumber)
        surfaceOf(offset,format).exchange(expected,surfaceNumber,std::memory_order_acq_rel);
    }

    bool MappedBlocks::check (size_t offset, BlockFormat format) const
    {
      if (const Reason reason = validate(offset,format)) {
        if (!isReported.exchange(true)) {
          const std::string message = name + ": the block at " + std::to_string(offset)
            + " is damaged, possibly others too: " + reason.message() + "; rays miss it";
          Device::process_error(device,RTC_ERROR_INVALID_ARGUMENT,message.c_str());
        }
        return false;
      }
      setSurfaceNumber(offset,format);
      validBlocks[offset/(16*64)].fetch_or(uint64_t(1) << (offset/16 % 64),std::memory_order_release);
      return true;
    }
  }
}
