// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Collects the blocks and statistics of all tasks that build a surface. Tasks may call add() concurrently. The order of
 * blocks after collect() does not depend on the timing of threads. */

#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../base/resize_to_fit.h"
#include <tuple>

namespace embree::isa {
struct BuildResults {
  /*! If strip is 0: blocks of consecutive patches, beginning with `patch` of `primitive`. Otherwise blocks of that
   *  patch's strip number `strip`, from 1. For mesh blocks, `primitive` is the number of grids plus the index of
   *  the batch (irregular_blocks.h). */
  struct List {
    size_t primitive;
    unsigned patch, strip;
    mvector<PrimRef> prims;
    mvector<cbvh::StepBox> boxes;

    bool operator<(const List& other) const {
      return std::tie(primitive, patch, strip) < std::tie(other.primitive, other.patch, other.strip);
    }
  };

  std::vector<std::unique_ptr<List>> lists;
  cbvh::BuildStatistics statistics;
  cbvh::WorldBounds hitBounds;
  MutexSys mutex;

  /*! Flushes a store and adds its blocks. The store may be used again. */
  void add(size_t primitive, unsigned patch, unsigned strip, BlockStore& store) {
    store.flush();
    std::unique_ptr<List> list;
    if (store.prims.size())
      list.reset(new List{primitive, patch, strip, copyAndClear(store.device, store.prims),
                          copyAndClear(store.device, store.boxes)});
    Lock<MutexSys> lock(mutex);
    hitBounds.extend(store.hitBounds);
    if (list) lists.push_back(std::move(list));
  }

  /*! Returns a copy without unused capacity, and frees the memory of `from`. */
  template<typename T>
  static mvector<T> copyAndClear(Device* device, mvector<T>& from) {
    mvector<T> copy(device, 0);
    cbvh::resizeToFit(copy, from.size());
    std::copy(from.begin(), from.end(), copy.begin());
    from.clear();
    return copy;
  }

  void add(const cbvh::BuildStatistics& taskStatistics) {
    Lock<MutexSys> lock(mutex);
    statistics.merge(taskStatistics);
  }

  /*! Concatenates the lists in the order of primitives, patches and strips, and frees them. prims, boxes: empty. */
  void collect(mvector<PrimRef>& prims, mvector<cbvh::StepBox>& boxes) {
    std::sort(lists.begin(), lists.end(),
              [](const std::unique_ptr<List>& a, const std::unique_ptr<List>& b) { return *a < *b; });
    size_t n = 0, b = 0;
    for (const auto& list : lists) {
      n += list->prims.size();
      b += list->boxes.size();
    }
    cbvh::resizeToFit(prims, n);
    cbvh::resizeToFit(boxes, b);
    n = b = 0;
    for (auto& list : lists) {
      for (const PrimRef& prim : list->prims) prims[n++] = prim;
      for (const cbvh::StepBox& box : list->boxes) boxes[b++] = box;
      list.reset();
    }
  }
};
} // namespace embree::isa
