// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of one geometry in a mapped file: where they lie, and which were found to be good. A block is looked at when rays meet it first,
 * so that what no ray meets stays on disk; a bit for each 16 bytes remembers it. Whatever the bytes of a block are, one that is good is decoded and
 * traced without a step outside of it, and what hits say of it are numbers that the geometry has. */

#include "../base/atomic_ref.h"
#include "../base/codec.h"
#include "../base/mapped_blocks.h"
#include "../../cvert/file/file.h"
#include <cstdint>
#include <memory>
#include <string>

namespace embree
{
  class Device;

  namespace cbvh
  {
    class MappedBlocks
    {
    public:
      /*! begin: of the blocks; the file, which must exist as long as this, has at least fileReadBehind bytes after them. number: of the surface,
       *  written into blocks that have another; these must be writable then. name: of the geometry in messages */
      MappedBlocks (Device* device, const std::shared_ptr<const cvert::File>& file, char* begin, const cvert::FileGeometry& record, uint32_t number, const std::string& name);
      ~MappedBlocks ();
      MappedBlocks (const MappedBlocks&) = delete;
      MappedBlocks& operator= (const MappedBlocks&) = delete;

      /*! Checks the block at an offset from the first. */
      cvert::Reason validate (size_t offset, BlockForm form) const;

      /*! Returns true if a block may be decoded. Remembers the result. Reports an error to the device for the first block that is damaged. */
      bool isGood (const void* block, BlockForm form) const
      {
        const size_t offset = size_t((const char*)block-begin);
        return likely(((good[offset/(16*64)].load(std::memory_order_acquire) >> (offset/16 % 64)) & 1) != 0) || check(offset,form);
      }

      /*! Writes the number of the surface into a block that has another. */
      void number (size_t offset, BlockForm form) const;

      const char* first () const { return begin; }

    private:
      friend class MappedPlaces;

      bool check (size_t offset, BlockForm form) const;
      AtomicRef<uint32_t> surfaceOf (size_t offset, BlockForm form) const;
      bool isOwnSurface (size_t offset, BlockForm form) const;

      Device* device;
      std::shared_ptr<const cvert::File> file;
      char* const begin;
      const cvert::FileGeometry record; //!< as it was when the geometry was loaded, whatever becomes of the file
      const size_t bytes;
      const uint32_t surfaceNumber;
      const std::string name;
      std::atomic<uint64_t>* good; //!< a bit for each place where a block may begin
      mutable std::atomic<bool> isReported;
      MappedBlocks* next, * previous; //!< of all that live
    };
  }
}
