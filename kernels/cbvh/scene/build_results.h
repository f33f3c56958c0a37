// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the tasks of a build leave behind, together. */

#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include <tuple>

namespace embree
{
  namespace isa
  {
    struct BuildResults
    {
      /*! Blocks of primitives, or of strips of a patch, which begin with one. */
      struct List
      {
        size_t primitive;
        unsigned patch, strip;
        mvector<PrimRef> prims;

        bool operator< (const List& other) const { return std::tie(primitive,patch,strip) < std::tie(other.primitive,other.patch,other.strip); }
      };

      std::vector<std::unique_ptr<List>> lists;
      cbvh::BuildStatistics statistics;
      cbvh::WorldBounds hitBounds;
      MutexSys mutex;

      void add (size_t primitive, unsigned patch, unsigned strip, BlockStore& store)
      {
        store.flush();
        Lock<MutexSys> lock(mutex);
        hitBounds.extend(store.hitBounds);
        if (store.prims.size()) lists.emplace_back(new List{ primitive,patch,strip,std::move(store.prims) });
      }

      void add (const cbvh::BuildStatistics& ofTask)
      {
        Lock<MutexSys> lock(mutex);
        statistics.merge(ofTask);
      }

      /*! the lists of all tasks, in the order of their primitives, whichever task was through first */
      void collect (mvector<PrimRef>& prims)
      {
        std::sort(lists.begin(),lists.end(),[](const std::unique_ptr<List>& a, const std::unique_ptr<List>& b) { return *a < *b; });
        size_t n = 0;
        for (const auto& list : lists) n += list->prims.size();
        prims.resize(n);
        n = 0;
        for (auto& list : lists) {
          for (const PrimRef& prim : list->prims) prims[n++] = prim;
          list.reset();
        }
      }
    };
  }
}
