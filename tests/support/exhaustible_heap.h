// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A heap that refuses allocations by operator new while a test says so, on the thread of the test. To be included by
 * one source file of a program. */

#include <cstdlib>
#include <new>

namespace {
thread_local bool isExhausted = false;
thread_local unsigned allowed = 0;     // allocations that an exhausted heap does not refuse yet
thread_local bool refusesOnce = false; // there is memory again after an allocation was refused
thread_local unsigned refused = 0;
} // namespace

// Replaces the operators of the C++ library, also for the libraries that this program loads. Not inlined: GCC 14 warns
// about a free() whose memory comes from operator new.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  if (isExhausted && allowed == 0) {
    refused++;
    isExhausted = !refusesOnce;
    throw std::bad_alloc();
  }
  if (isExhausted) allowed--;
  if (void* p = std::malloc(bytes ? bytes : 1)) return p;
  throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* p) noexcept { std::free(p); }
__attribute__((noinline)) void operator delete(void* p, std::size_t) noexcept { std::free(p); }
