// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Blocks of a geometry in a mapped file. Moving blocks are checked when the geometry is loaded, static blocks before
 * their first use (base/block_validity.h), so that unused ones are never read from disk. Decoding and tracing a valid
 * block reads only the block and fileReadPadding bytes after it, and its hits report existing primitives. */

#include "../base/atomic_ref.h"
#include "../base/codec_names.h"
#include "../base/block_validity.h"
#include "../embree/scene.h"
#include "../../cvert/file/file.h"
#include <cstdint>
#include <memory>
#include <string>

namespace embree {
class Device;

namespace cbvh {
/*! Threads may call all const members at the same time. */
class MappedBlocks {
public:
  /*! file: mapped with at least fileReadPadding bytes after the blocks, which decoders may read. begin: first
   *  block. number: surface number. If it differs from the record's, it is written into checked blocks, which must
   *  be writable. name: for messages. */
  MappedBlocks(Device* device, const std::shared_ptr<const cvert::File>& file, char* begin,
               const cvert::FileGeometry& record, uint32_t number, const std::string& name);
  ~MappedBlocks();
  MappedBlocks(const MappedBlocks&) = delete;
  MappedBlocks& operator=(const MappedBlocks&) = delete;

  /*! True if a block of this object may be decoded. Reports the first damaged one to the device. */
  bool isValid(const void* block, BlockType type) const {
    const size_t offset = size_t((const char*)block - begin);
    return likely(isMarked(offset)) || check(offset, type);
  }

  /*! Validates a block, writes the surface number if it differs from the record's, and marks the block as valid.
   *  Returns the first error. Writing a number into a block that overlaps another one is an error, because it could
   *  change a block that was accepted before. offset: from the first block, in bytes. */
  cvert::Reason accept(size_t offset, BlockType type) const;

  const char* first() const { return begin; }

private:
  friend class MappedBlockRegistry;

  /*! Accepts a block, or reports the damage. */
  bool check(size_t offset, BlockType type) const;
  cvert::Reason validate(size_t offset, BlockType type) const;
  AtomicRef<uint32_t> surfaceOf(size_t offset, BlockType type) const;
  bool isOwnSurface(size_t offset, BlockType type) const;
  bool isMarked(size_t offset) const {
    return ((validBlocks[offset / (16 * 64)].load(std::memory_order_acquire) >> (offset / 16 % 64)) & 1) != 0;
  }
  void mark(size_t offset) const;

  Device* device;
  std::shared_ptr<const cvert::File> file;
  char* const begin;
  const cvert::FileGeometry record; //!< a copy: stays as it was checked even if the file is overwritten
  const size_t bytes;
  const uint32_t surfaceNumber;
  const std::string name;
  std::atomic<uint64_t>* validBlocks; //!< one bit per 16 bytes, the alignment of blocks
  uint64_t* usedUnits;                //!< one bit per 16 bytes of accepted blocks; null if no number is written
  mutable MutexSys mutex;             //!< protects usedUnits
  mutable std::atomic<bool> isReported;
  MappedBlocks *next, *previous; //!< list of all MappedBlocks
};
} // namespace cbvh
} // namespace embree
