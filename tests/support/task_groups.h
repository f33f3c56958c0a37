// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Task groups of an application that commits in its own tasks. */

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <new>
#include <sys/mman.h>

namespace programs::test {

/* Runs the closure in a task of a group whose memory cannot be read afterwards. */
template<typename Closure>
void runInTemporaryGroup(const Closure& closure) {
  static_assert(sizeof(tbb::task_group) <= 4096, "a page holds a group");
  void* const page = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::bad_alloc();
  tbb::task_group* const group = new (page) tbb::task_group;
  group->run([&] { closure(); });
  group->wait();
  group->~task_group();
  mprotect(page, 4096, PROT_NONE); // stays mapped, so that nothing else gets this address
}

/* Cancels a group while its tasks run loops. TBB then looks for descendants of the group in all contexts that exist. */
inline void cancelOtherGroup() {
  tbb::task_group group;
  group.run([&] { tbb::parallel_for(0, 100, [&](int) { group.cancel(); }); });
  group.wait();
}

} // namespace programs::test
