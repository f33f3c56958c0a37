// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of one geometry in a mapped file: where they lie, and which were found to be good. A block is looked at when rays meet it first,
 * so that what no ray meets stays on disk; a bit for each 16 bytes remembers it. Whatever the bytes of a block are, one that is good is decoded and
 * traced without a step outside of it, and what hits say of it are numbers that the geometry has. */

#include "../base/atomic_ref.h"
#include "../base/mapped_blocks.h"
#include <cstdint>
#include <memory>
#include <string>

namespace embree
{
  class Device;

  namespace cbvh
  {
    class MappedFile;

    class MappedBlocks
    {
    public:
      struct Limits
      {
        uint32_t surface;        //!< number that blocks have in the file
        uint32_t number;         //!< that they are to have, which is written into them if it is another: then they can be written
        uint32_t numPrimitives;
        uint32_t numTimeSteps;
        float begin, end;        //!< times of the first step and of the last
      };

      /*! begin: of the blocks; the file holds at least fileReadBehind bytes behind them, and lasts as long as this. name: of the geometry in messages */
      MappedBlocks (Device* device, const std::shared_ptr<const MappedFile>& file, char* begin, size_t bytes, const Limits& limits, const std::string& name);
      ~MappedBlocks ();
      MappedBlocks (const MappedBlocks&) = delete;
      MappedBlocks& operator= (const MappedBlocks&) = delete;

      /*! Null if a block of that form, which begins so far behind the first, may be decoded; else what is wrong with it. */
      const char* errorOf (size_t offset, bool isVert, bool moves) const;

      /*! The same of a block at an address, with a memory, and with an error for the device the first time that one is not. */
      bool isGood (const void* block, bool isVert) const
      {
        const size_t offset = size_t((const char*)block-begin);
        return likely(((good[offset/(16*64)].load(std::memory_order_acquire) >> (offset/16 % 64)) & 1) != 0) || check(offset,isVert);
      }

      /*! Gives a block the number of its surface, if it has another. */
      void number (size_t offset, bool isVert) const;

      const char* first () const { return begin; }

    private:
      friend class MappedPlaces;

      bool check (size_t offset, bool isVert) const;
      AtomicRef<uint32_t> surfaceOf (size_t offset, bool isVert) const;
      bool isOwnSurface (size_t offset, bool isVert) const;

      Device* device;
      std::shared_ptr<const MappedFile> file;
      char* const begin;
      const size_t bytes;
      const Limits limits;
      const std::string name;
      std::atomic<uint64_t>* good; //!< a bit for each place where a block may begin
      mutable std::atomic<bool> isReported;
      MappedBlocks* next, * previous; //!< of all that live
    };
  }
}
