// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "substitute_data.h"
#include "immortal.h"

#include <atomic>
#include <cstring>
#include <mutex>
#include <sys/mman.h>

namespace interposer {

SubstituteDataRange substituteDataRange = {{0}, {0}};

namespace {

constexpr size_t maxSubstitutes = size_t(1) << 20; // reserves address space, not memory

struct FreeEntry {
  FreeEntry* next;
}; // stored in place of a deleted SubstituteData

struct RangeMutex : std::mutex {}; // a type of its own: immortal() creates one object per type
std::mutex& mutex() { return immortal<RangeMutex>(); }

FreeEntry* firstFree = nullptr;
size_t numEverUsed = 0;          // entries from the start of the range that are or were in use
std::atomic<bool> hasAny{false}; // stays true

} // namespace

bool hasSubstitutes() { return hasAny.load(std::memory_order_relaxed); }

SubstituteData* newSubstituteData() {
  static_assert(sizeof(SubstituteData) >= sizeof(FreeEntry), "a free entry fits into a SubstituteData");
  const std::lock_guard<std::mutex> lock(mutex());
  if (substituteDataRange.size == 0) {
    void* const base = mmap(nullptr, maxSubstitutes * sizeof(SubstituteData), PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (base == MAP_FAILED) return nullptr;
    substituteDataRange.begin.store(uintptr_t(base), std::memory_order_relaxed);
    substituteDataRange.size.store(maxSubstitutes * sizeof(SubstituteData), std::memory_order_release);
  }
  SubstituteData* data = (SubstituteData*)firstFree;
  if (firstFree) firstFree = firstFree->next;
  else if (numEverUsed < maxSubstitutes) data = (SubstituteData*)substituteDataRange.begin.load() + numEverUsed++;
  else return nullptr;
  std::memset((void*)data, 0, sizeof(SubstituteData));
  hasAny = true;
  return data;
}

void deleteSubstituteData(SubstituteData* data) {
  const std::lock_guard<std::mutex> lock(mutex());
  FreeEntry* const entry = (FreeEntry*)data;
  entry->next = firstFree;
  firstFree = entry;
}

} // namespace interposer
