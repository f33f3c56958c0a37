// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Also implements SurfaceNumber (base/surface_ids.h) and BlockMemory (base/block_memory.h). */

#include "surface_blocks.h"
#include "stored_triangles.h"
#include <algorithm>
#include <functional>
#include <set>
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

BlockMemory::BlockMemory(Device* device) : device(device) {}

BlockMemory::~BlockMemory() {
  for (const Piece& piece : pieces) {
    alignedFree(piece.data);
    device->memoryMonitor(-ssize_t(piece.bytes), true);
  }
}

void BlockMemory::reserve(size_t bytes) {
  static_assert(alignof(FastAllocator) <= 16, "alignment of new");
  if (bytes == 0) return;
  allocator.reset(new FastAllocator(device, true));
  allocator->init_estimate(bytes);
  maxPooledBytes = min(bytes / chunks, size_t(maxChunkBytes)) / piecesPerChunk;
}

void* BlockMemory::allocate(size_t bytes) {
  if (allocator && bytes <= maxPooledBytes) return allocator->getCachedAllocator().malloc1(bytes, blockAlignment);
  device->memoryMonitor(ssize_t(bytes), false);
  Piece piece = {nullptr, bytes};
  try {
    piece.data = alignedMalloc(bytes, blockAlignment);
    Lock<MutexSys> lock(mutex);
    pieces.push_back(piece);
  } catch (...) {
    if (piece.data) alignedFree(piece.data);
    device->memoryMonitor(-ssize_t(bytes), true);
    throw;
  }
  return piece.data;
}

void BlockMemory::detachThreads() {
  if (allocator) allocator->cleanup();
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
    blockIndex(nullptr) {}

SurfaceBlocks::~SurfaceBlocks() { delete blockIndex.load(); }

const cbvh::BlockIndex& SurfaceBlocks::index() const {
  if (const cbvh::BlockIndex* built = blockIndex) return *built;
  const cbvh::BlockIndex *built = new cbvh::BlockIndex(*this), *other = nullptr;
  if (blockIndex.compare_exchange_strong(other, built)) return *built;
  delete built; // another thread has already built one
  return *other;
}
} // namespace embree
