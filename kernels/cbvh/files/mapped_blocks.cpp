// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled once, for the lowest ISA of the library (files.cmake). */

#include "mapped_blocks.h"
#include "../blocks/block_table.h"
#include "validate_framed.h"
#include "../../cvert/file/record.h"
#include <algorithm>
#include <cstdlib>
#include <new>
#include <vector>

namespace embree::cbvh {
/*! All MappedBlocks of the process, to find the owner of a block by its address. Threads hold references
 *  to a sorted list, which does not change, so that rays lock only after files were mapped or unmapped. */
class MappedBlockRegistry {
  /*! Copies members of MappedBlocks, because other threads may delete MappedBlocks that the calling thread does
   *  not trace. */
  struct AddressRange {
    const char* begin;
    size_t bytes;
    const MappedBlocks* blocks;

    bool contains(const void* block) const { return size_t((const char*)block - begin) < bytes; }
  };
  /*! Sorted by address, without empty ranges. Ranges do not overlap, because the blocks of a file's geometries do
   *  not: an address is either in the last range that begins at or before it, or in none. */
  typedef std::vector<AddressRange> List;

public:
  static void add(MappedBlocks* blocks) {
    Lock<MutexSys> lock(mutex);
    blocks->previous = nullptr;
    blocks->next = first;
    if (first) first->previous = blocks;
    first = blocks;
    mappedBlockValidator.store(isValid);
    hullBegin = std::min(hullBegin, size_t(blocks->begin));
    hullEnd = std::max(hullEnd, size_t(blocks->begin) + blocks->bytes);
    publish();
  }

  static void remove(MappedBlocks* blocks) {
    Lock<MutexSys> lock(mutex);
    (blocks->previous ? blocks->previous->next : first) = blocks->next;
    if (blocks->next) blocks->next->previous = blocks->previous;
    publish();
  }

private:
  /*! The list that a thread uses. It may be outdated, but contains all geometries that the thread is tracing. */
  struct ThreadCopy {
    uint64_t generation = 0;
    std::shared_ptr<const List> list;
    AddressRange last = {nullptr, 0, nullptr}; //!< range of the last block
  };

  static bool isValid(const void* block, BlockType type) {
    const ThreadCopy* const own = threadCopy;
    if (likely(own && own->generation == generation.load(std::memory_order_acquire) && own->last.contains(block)))
      return own->last.blocks->isValid(block, type);
    return findAndCheck(block, type);
  }

  static bool findAndCheck(const void* block, BlockType type) {
    struct Owner {
      ~Owner() {
        delete threadCopy;
        threadCopy = nullptr;
      }
    };
    if (!threadCopy) {
      static thread_local Owner owner; // frees it at the thread's end
      (void)owner;
      threadCopy = new (std::nothrow) ThreadCopy;
    }
    if (unlikely(!threadCopy)) {
      const AddressRange range = findRegistered(block);
      return !range.blocks || range.blocks->isValid(block, type);
    }
    if (threadCopy->generation != generation.load(std::memory_order_acquire)) {
      Lock<MutexSys> lock(mutex);
      threadCopy->list = currentList();
      threadCopy->generation = generation.load(std::memory_order_relaxed);
      threadCopy->last = AddressRange{nullptr, 0, nullptr};
    }
    const AddressRange range = threadCopy->list ? findRange(*threadCopy->list, block) : findRegistered(block);
    if (!range.blocks) return true;
    threadCopy->last = range;
    return range.blocks->isValid(block, type);
  }

  static AddressRange rangeOf(const MappedBlocks* blocks) { return AddressRange{blocks->begin, blocks->bytes, blocks}; }

  static AddressRange findRange(const List& list, const void* block) {
    const auto next =
        std::upper_bound(list.begin(), list.end(), block,
                         [](const void* block, const AddressRange& range) { return (const char*)block < range.begin; });
    return next == list.begin() || !(next - 1)->contains(block) ? AddressRange{nullptr, 0, nullptr} : *(next - 1);
  }

  static AddressRange findRegistered(const void* block) {
    Lock<MutexSys> lock(mutex);
    for (const MappedBlocks* blocks = first; blocks; blocks = blocks->next)
      if (rangeOf(blocks).contains(block)) return rangeOf(blocks);
    return AddressRange{nullptr, 0, nullptr};
  }

  /*! Returns the list of all registered MappedBlocks. The first ray after changes makes it: a list per change would
   *  take quadratic time. Returns null if there is no memory for it; the thread then searches all MappedBlocks
   *  until the next change. The mutex must be locked. */
  static std::shared_ptr<const List> currentList() {
    if (list) return list;
    try {
      const std::shared_ptr<List> next = std::make_shared<List>();
      for (const MappedBlocks* blocks = first; blocks; blocks = blocks->next)
        if (blocks->bytes) next->push_back(rangeOf(blocks));
      std::sort(next->begin(), next->end(),
                [](const AddressRange& a, const AddressRange& b) { return a.begin < b.begin; });
      for (size_t i = 1; i < next->size(); i++) assert(!(*next)[i - 1].contains((*next)[i].begin));
      list = next;
    } catch (const std::bad_alloc&) {}
    return list;
  }

  /*! Publishes a change. The mutex must be locked. First extends the range to all addresses, for readers that see a
   *  part of the change (base/block_validity.h). */
  static void publish() {
    list.reset();
    if (!first) {
      mappedBytes.store(0);
      hullBegin = ~size_t(0);
      hullEnd = 0;
    } else {
      mappedBytes.store(~size_t(0));
      mappedBegin.store(hullBegin, std::memory_order_release);
      mappedBytes.store(hullEnd - hullBegin);
    }
    generation.fetch_add(1);
  }

  static MutexSys mutex; //!< protects the next four members
  static MappedBlocks* first;
  static std::shared_ptr<const List> list; //!< null until currentList() makes it
  static size_t hullBegin, hullEnd;        //!< range of addresses; grows until no file is mapped
  static std::atomic<uint64_t> generation; //!< incremented by each change
  static __thread ThreadCopy* threadCopy __attribute__((tls_model("initial-exec")));
};

MutexSys MappedBlockRegistry::mutex;
MappedBlocks* MappedBlockRegistry::first = nullptr;
std::shared_ptr<const MappedBlockRegistry::List> MappedBlockRegistry::list;
size_t MappedBlockRegistry::hullBegin = ~size_t(0), MappedBlockRegistry::hullEnd = 0;
std::atomic<uint64_t> MappedBlockRegistry::generation(0);
__thread MappedBlockRegistry::ThreadCopy* MappedBlockRegistry::threadCopy = nullptr;

MappedBlocks::MappedBlocks(Device* device, const std::shared_ptr<const File>& file, char* begin,
                           const FileGeometry& record, uint32_t number, const std::string& name)
  : device(device),
    file(file),
    begin(begin),
    record(record),
    bytes(size_t(record.blockBytes)),
    surfaceNumber(number),
    name(name),
    validBlocks(nullptr),
    usedUnits(nullptr),
    isReported(false) {
  static_assert(sizeof(std::atomic<uint64_t>) == sizeof(uint64_t), "calloc initializes the bits");
  /* calloc maps pages of zeros, which need memory only where rays reach blocks */
  const size_t words = bytes / (16 * 64) + 1;
  validBlocks = (std::atomic<uint64_t>*)calloc(words, sizeof(uint64_t));
  if (record.surface != surfaceNumber) usedUnits = (uint64_t*)calloc(words, sizeof(uint64_t));
  if (!validBlocks || (record.surface != surfaceNumber && !usedUnits)) {
    free(usedUnits);
    free(validBlocks);
    throw std::bad_alloc();
  }
  MappedBlockRegistry::add(this);
}

MappedBlocks::~MappedBlocks() {
  MappedBlockRegistry::remove(this);
  free(usedUnits);
  free(validBlocks);
}

Reason MappedBlocks::validate(size_t offset, BlockType type) const {
  if (offset >= bytes || offset % blockAlignment)
    return Reason::damaged("its offset is %: expected a multiple of 16 within the blocks of the geometry", offset);
  const char* const block = begin + offset;
  if (const Reason reason = validateBlock(type, record, block, bytes - offset, validateFramedInFile)) return reason;
  return isOwnSurface(offset, type) ? Reason() : Reason::damaged("its surface number differs from its geometry's");
}

AtomicRef<uint32_t> MappedBlocks::surfaceOf(size_t offset, BlockType type) const {
  return AtomicRef<uint32_t>(*(uint32_t*)(begin + offset + rowOf(type).surface));
}

bool MappedBlocks::isOwnSurface(size_t offset, BlockType type) const {
  const uint32_t surface = surfaceOf(offset, type).load(std::memory_order_acquire);
  return surface == record.surface || surface == surfaceNumber;
}

void MappedBlocks::mark(size_t offset) const {
  validBlocks[offset / (16 * 64)].fetch_or(uint64_t(1) << (offset / 16 % 64), std::memory_order_release);
}

Reason MappedBlocks::accept(size_t offset, BlockType type) const {
  if (const Reason reason = validate(offset, type)) return reason;
  if (!usedUnits) {
    mark(offset);
    return Reason();
  }
  Lock<MutexSys> lock(mutex);
  if (isMarked(offset)) return Reason(); // by another thread
  const size_t end = (offset + rowOf(type).bytes(begin + offset) + 15) / 16;
  for (size_t unit = offset / 16; unit < end; unit++)
    if ((usedUnits[unit / 64] >> (unit % 64)) & 1) return Reason::damaged("it overlaps another block");
  for (size_t unit = offset / 16; unit < end; unit++) usedUnits[unit / 64] |= uint64_t(1) << (unit % 64);
  uint32_t expected = record.surface; // unless the block has surfaceNumber already
  surfaceOf(offset, type).compareExchange(expected, surfaceNumber, std::memory_order_acq_rel);
  mark(offset);
  return Reason();
}

bool MappedBlocks::check(size_t offset, BlockType type) const {
  if (const Reason reason = accept(offset, type)) {
    if (!isReported.exchange(true)) {
      const std::string message = name + ": the block at " + std::to_string(offset) +
                                  " is damaged, possibly others too: " + reason.message() + "; rays miss it";
      Device::process_error(device, RTC_ERROR_INVALID_ARGUMENT, message.c_str());
    }
    return false;
  }
  return true;
}
} // namespace embree::cbvh
