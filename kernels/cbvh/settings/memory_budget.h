// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The limit of the bytes that the compressed surfaces of a device take (the setting memory), and who counts against it:
 * blocks and trees, each from the end of its build until it is freed. */

#include <atomic>
#include <cstddef>
#include <memory>

namespace embree::cbvh {
class MemoryBudget {
public:
  explicit MemoryBudget(size_t limit) : limit(limit) {}

  /*! Bytes of all that counts. Thread-safe. */
  size_t used() const { return bytes; }

  const size_t limit;

private:
  friend class BudgetedBytes;

  std::atomic<size_t> bytes{0};
};

/*! What an object counts. Without a budget, only remembers it. */
class BudgetedBytes {
public:
  explicit BudgetedBytes(const std::shared_ptr<MemoryBudget>& budget) : budget(budget) {}
  ~BudgetedBytes() { set(0); }
  BudgetedBytes(const BudgetedBytes&) = delete;
  BudgetedBytes& operator=(const BudgetedBytes&) = delete;

  void set(size_t bytes) {
    if (budget) budget->bytes += bytes - own; // wraps around if bytes < own
    own = bytes;
  }

  size_t get() const { return own; }

private:
  const std::shared_ptr<MemoryBudget> budget;
  size_t own = 0;
};
} // namespace embree::cbvh
