// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "stand_in.h"

#include <atomic>
#include <cstring>
#include <mutex>
#include <sys/mman.h>

namespace interposer {

StandInRange standInRange = {{0}, {0}};

namespace {

constexpr size_t maxStandIns = size_t(1) << 20;   // only reserves addresses; the system adds memory on demand

struct FreeEntry { FreeEntry* next; }; // takes the place of a deleted StandIn

std::mutex& mutex = *new std::mutex;
FreeEntry* firstFree = nullptr;
size_t numUsed = 0;                    // used entries from the start of the range, including free ones
std::atomic<bool> hasAny{false};       // stays true

} // namespace

bool hasStandIns() { return hasAny.load(std::memory_order_relaxed); }

StandIn* newStandIn()
{
  static_assert(sizeof(StandIn) >= sizeof(FreeEntry), "StandIn must be large enough for an entry of the free list");
  const std::lock_guard<std::mutex> lock(mutex);
  if (standInRange.size == 0) {
    void* const base = mmap(nullptr, maxStandIns*sizeof(StandIn), PROT_READ | PROT_WRITE,
      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (base == MAP_FAILED) return nullptr;
    standInRange.begin.store(uintptr_t(base), std::memory_order_relaxed);
    standInRange.size.store(maxStandIns*sizeof(StandIn), std::memory_order_release);
  }
  StandIn* standIn = (StandIn*)firstFree;
  if (firstFree) firstFree = firstFree->next;
  else if (numUsed < maxStandIns) standIn = (StandIn*)standInRange.begin.load() + numUsed++;
  else return nullptr;
  std::memset((void*)standIn, 0, sizeof(StandIn));
  hasAny = true;
  return standIn;
}

void deleteStandIn(StandIn* standIn)
{
  const std::lock_guard<std::mutex> lock(mutex);
  FreeEntry* const entry = (FreeEntry*)standIn;
  entry->next = firstFree;
  firstFree = entry;
}

} // namespace interposer
