// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The operations of C++20's std::atomic_ref that are used here. Objects must be aligned to their size. While a thread
 * accesses an object through an AtomicRef, no other thread may access it directly. */

#include <atomic>

namespace embree::cbvh {
template<typename T>
class AtomicRef {
public:
  explicit AtomicRef(T& object) : object(object) {}

  T load(std::memory_order order) const { return __atomic_load_n(&object, int(order)); }

  /*! fetchAdd and fetchOr return the previous value. */
  T fetchAdd(T value, std::memory_order order) const { return __atomic_fetch_add(&object, value, int(order)); }
  T fetchOr(T bits, std::memory_order order) const { return __atomic_fetch_or(&object, bits, int(order)); }

  /*! Stores `value` if the object equals `expected`. Otherwise returns false and sets `expected` to the current
   *  value. May fail spuriously, so callers loop. */
  bool compareExchangeWeak(T& expected, T value, std::memory_order order) const {
    return __atomic_compare_exchange_n(&object, &expected, value, true, int(order), failureOrder(order));
  }

  /*! As compareExchangeWeak(), but never fails spuriously. */
  bool compareExchange(T& expected, T value, std::memory_order order) const {
    return __atomic_compare_exchange_n(&object, &expected, value, false, int(order), failureOrder(order));
  }

private:
  static_assert(__atomic_always_lock_free(sizeof(T), nullptr), "expected a type without locks");
  static_assert(int(std::memory_order_relaxed) == __ATOMIC_RELAXED &&
                    int(std::memory_order_acquire) == __ATOMIC_ACQUIRE &&
                    int(std::memory_order_release) == __ATOMIC_RELEASE &&
                    int(std::memory_order_acq_rel) == __ATOMIC_ACQ_REL &&
                    int(std::memory_order_seq_cst) == __ATOMIC_SEQ_CST,
                "orders are passed to the compiler as they are");

  /*! A failed exchange stores nothing, so it must not release. */
  static int failureOrder(std::memory_order order) {
    if (order == std::memory_order_acq_rel) return __ATOMIC_ACQUIRE;
    return order == std::memory_order_release ? __ATOMIC_RELAXED : int(order);
  }

  T& object;
};
} // namespace embree::cbvh
