// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Also implements SurfaceNumber (base/surface_ids.h) and BlockMemory (base/block_memory.h). */

#include "surface_blocks.h"
#include "stored_triangles.h"
#include <algorithm>
#include <functional>
#include <new>
#include <set>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

namespace embree {
namespace cbvh {
namespace {
/*! Protects the following variables, and between concurrent builds of scenes also SurfaceState::number and
 *  blocks, and writes of surfaceIDs. Commits of geometries change the blocks without it. */
MutexSys mutex;
/*! Unused numbers below nextNumber, as a heap with the smallest first. Has capacity for all of them, because
 *  destructors add numbers and must not allocate. */
std::vector<uint32_t> freeNumbers;
uint32_t nextNumber = 0;
std::set<uint32_t> fileNumbers; //!< numbers from files that are in use, at least firstFileNumber
} // namespace

SurfaceNumber::SurfaceNumber(uint32_t fileNumber) {
  Lock<MutexSys> lock(mutex);
  if (fileNumber != none && fileNumbers.insert(fileNumber).second) {
    value = fileNumber;
    return;
  }
  if (freeNumbers.empty()) {
    if (freeNumbers.capacity() <= nextNumber) freeNumbers.reserve(2 * size_t(nextNumber) + 16);
    value = nextNumber++;
    return;
  }
  std::pop_heap(freeNumbers.begin(), freeNumbers.end(), std::greater<uint32_t>());
  value = freeNumbers.back();
  freeNumbers.pop_back();
}

SurfaceNumber::~SurfaceNumber() {
  Lock<MutexSys> lock(mutex);
  if (value >= firstFileNumber) fileNumbers.erase(value);
  else {
    freeNumbers.push_back(value);
    std::push_heap(freeNumbers.begin(), freeNumbers.end(), std::greater<uint32_t>());
  }
}

std::shared_ptr<const SurfaceNumber> numberOf(CompressibleGeometry* geometry) {
  {
    Lock<MutexSys> lock(mutex);
    if (geometry->surface.number) return geometry->surface.number;
  }
  /* Not under the mutex, which constructor and destructor of SurfaceNumber lock. If another thread assigns a number
   * meanwhile, this one is discarded. */
  std::shared_ptr<const SurfaceNumber> number = std::make_shared<SurfaceNumber>();
  Lock<MutexSys> lock(mutex);
  if (geometry->surface.number == nullptr) geometry->surface.number = number;
  return geometry->surface.number;
}

bool hasCompressedGeometry(const Scene* scene, bool moves) {
  for (size_t i = 0; i < scene->geometries.size(); i++) {
    const CompressibleGeometry* const geometry = asTreeGeometry(scene->geometries[i].ptr, moves);
    if (geometry && geometry->compression.resolve(scene->device->compression).compression != RTC_COMPRESSION_NONE)
      return true;
  }
  return false;
}

void updateSurfaceIDs(Scene* scene) {
  // without compressed static geometry, Embree traces static cages, and its grids store IDs
  const bool hasStatic = hasCompressedGeometry(scene, false);
  std::vector<std::pair<uint32_t, uint32_t>> ids;
  for (size_t i = 0; i < scene->size(); i++)
    for (bool moves : {false, true}) {
      CompressibleGeometry* const geometry = hasStatic || moves ? asTreeGeometry(scene->get(i), moves) : nullptr;
      if (geometry && geometry->size() != 0)
        ids.emplace_back(*numberOf(geometry) | (moves ? movingSurface : 0), uint32_t(i));
    }
  Lock<MutexSys> lock(mutex);
  scene->surfaceIDs.set(ids);
}

std::shared_ptr<const SurfaceBlocks> blocksOf(const CompressibleGeometry* geometry) {
  Lock<MutexSys> lock(mutex);
  return geometry->surface.blocks;
}

std::shared_ptr<const SurfaceBlocks> setBlocks(CompressibleGeometry* geometry,
                                               const std::shared_ptr<const SurfaceBlocks>& blocks) {
  Lock<MutexSys> lock(mutex);
  if (geometry->surface.blocks == nullptr) geometry->surface.blocks = blocks;
  // the regions are no longer needed; other builds in progress hold references
  std::atomic_store(&geometry->surface.regions, std::shared_ptr<const QuadRegions>());
  return geometry->surface.blocks;
}

void replaceBlocks(CompressibleGeometry* geometry, const std::shared_ptr<const SurfaceBlocks>& blocks) {
  Lock<MutexSys> lock(mutex);
  geometry->surface.blocks = blocks;
}

/*! Size of large pages, and of pieces that lie in them. */
static const size_t largePageBytes = size_t(2) << 20;

/*! Estimated size of a surface whose blocks lie in large pages: the peak of memory includes the last piece as a whole.
 *  Smaller ones have about numSmallPieces pieces. */
static const size_t minBytesForLargePages = size_t(16) << 20, numSmallPieces = 20;

BlockMemory::BlockMemory(Device* device) : device(device) {}

BlockMemory::~BlockMemory() {
  for (const Piece& piece : pieces) {
    if (piece.isMapped) ::munmap(piece.data, piece.bytes);
    else alignedFree(piece.data);
    device->memoryMonitor(-ssize_t(piece.bytes), true);
  }
}

void BlockMemory::reserve(size_t blockBytes, size_t nodeBytes) {
  static_assert(alignof(FastAllocator) <= 16, "alignment of new");
  allocator.reset(new FastAllocator(device, true));
  allocator->init_estimate(nodeBytes);
  pieceBytes = blockBytes >= minBytesForLargePages ? largePageBytes : blockBytes / numSmallPieces;
}

void* BlockMemory::allocate(size_t bytes) {
  bytes = (bytes + blockAlignment - 1) & ~size_t(blockAlignment - 1);
  Lock<MutexSys> lock(mutex);
  if (bytes > pieceBytes / allocationsPerPiece) {
    addPiece(bytes);
    return pieces.back().data;
  }
  if (bytes > size_t(end - next)) {
    if (pieceBytes == largePageBytes) addLargePages();
    else addPiece(pieceBytes);
    next = pieces.back().data;
    end = next + pieces.back().bytes;
  }
  char* const data = next;
  next += bytes;
  return data;
}

/*! So that adding a piece does not throw. */
void BlockMemory::reservePiece() {
  if (pieces.size() == pieces.capacity()) pieces.reserve(2 * pieces.size() + 1);
}

void BlockMemory::addPiece(size_t bytes) {
  reservePiece();
  device->memoryMonitor(ssize_t(bytes), false);
  try {
    pieces.push_back(Piece{(char*)alignedMalloc(bytes, blockAlignment), bytes, false});
  } catch (...) {
    device->memoryMonitor(-ssize_t(bytes), true);
    throw;
  }
}

/*! Adds a piece of the size and alignment of a large page. Maps twice as much, and keeps the aligned part. */
void BlockMemory::addLargePages() {
  reservePiece();
  device->memoryMonitor(ssize_t(largePageBytes), false);
  char* const mapped =
      (char*)::mmap(nullptr, 2 * largePageBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) {
    device->memoryMonitor(-ssize_t(largePageBytes), true);
    throw std::bad_alloc();
  }
  const size_t before = size_t(-intptr_t(mapped)) & (largePageBytes - 1);
  if (before) ::munmap(mapped, before);
  ::munmap(mapped + before + largePageBytes, largePageBytes - before);
#if defined(MADV_HUGEPAGE)
  ::madvise(mapped + before, largePageBytes, MADV_HUGEPAGE); // fails on systems without
#endif
  pieces.push_back(Piece{mapped + before, largePageBytes, true});
}

void BlockMemory::finish() {
  if (allocator) allocator->cleanup();
  const size_t page = size_t(::sysconf(_SC_PAGESIZE));
  for (Piece& piece : pieces) { // the one that contains free memory
    if (!piece.isMapped || piece.data + piece.bytes != end) continue;
    const size_t kept = (size_t(next - piece.data) + page - 1) & ~(page - 1);
    if (kept < piece.bytes && ::munmap(piece.data + kept, piece.bytes - kept) == 0) {
      device->memoryMonitor(-ssize_t(piece.bytes - kept), true);
      piece.bytes = kept;
    }
  }
  next = end = nullptr;
}
} // namespace cbvh

static std::atomic<uint64_t> numBuilds(0);

SurfaceBlocks::SurfaceBlocks(Device* device, const std::shared_ptr<const cbvh::SurfaceNumber>& number)
  : number(number),
    buildID(++numBuilds),
    memory(device),
    parts(device, 0),
    moving(device, 0),
    root(BVH4::emptyNode),
    bounds(empty),
    numPrimRefs(0),
    counted(device->compression.memory),
    blockIndex(nullptr) {}

SurfaceBlocks::~SurfaceBlocks() { delete blockIndex.load(); }

size_t SurfaceBlocks::bytes() const {
  return mapped && !unconverted ? statistics.sums.topLevelBytes : statistics.sums.allBytes();
}

void SurfaceBlocks::finish() {
  memory.finish();
  counted.set(bytes());
}

const cbvh::BlockIndex& SurfaceBlocks::index() const {
  if (const cbvh::BlockIndex* built = blockIndex) return *built;
  const cbvh::BlockIndex *built = new cbvh::BlockIndex(*this), *other = nullptr;
  if (blockIndex.compare_exchange_strong(other, built)) return *built;
  delete built; // another thread has already built one
  return *other;
}
} // namespace embree
