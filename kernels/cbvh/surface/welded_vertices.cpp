// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A hash of positions distributes vertices to buckets. A task processes a bucket with a table that fits into a
 * cache. */

#include "welded_vertices.h"
#include "../base/resize_to_fit.h"
#include <atomic>
#include <vector>

namespace embree {
namespace {
const size_t perTask = size_t(1) << 15, perBucket = size_t(1) << 12, maxBuckets = size_t(1) << 12;

class Welding {
public:
  Welding(const BufferView<Vec3fa>* steps, unsigned numSteps, size_t n)
    : steps(steps),
      numSteps(numSteps),
      n(n),
      numTasks((n + perTask - 1) / perTask) {
    while (numBuckets < maxBuckets && numBuckets * perBucket < n) {
      numBuckets *= 2;
      bucketBits++;
    }
  }

  /*! Sets firsts[v] to the lowest vertex that is equal to v. Returns true if any vertices are equal. */
  bool run(mvector<unsigned>& firsts) {
    distribute();
    cbvh::resizeToFit(firsts, n);
    std::atomic<bool> anyEqual(false);
    parallel_for(size_t(0), numBuckets, size_t(1), [&](const range<size_t>& r) {
      std::vector<unsigned> table;
      for (size_t b = r.begin(); b != r.end(); b++)
        if (weld(b == 0 ? 0 : ends[b * numTasks - 1], ends[(b + 1) * numTasks - 1], table, firsts)) anyEqual = true;
    });
    return anyEqual;
  }

private:
  enum : unsigned { none = ~0u };

  /*! A vertex in its bucket, with its position at the first time step, for which a task reads only its bucket. */
  struct Entry {
    unsigned hash, vertex;
    unsigned at[3]; //!< see bitsOf()
  };

  static unsigned bitsOf(float x) // equal for both zeros
  {
    unsigned bits;
    memcpy(&bits, &x, sizeof(bits));
    return bits == 0x80000000u ? 0u : bits;
  }

  const float* position(size_t vertex, unsigned step) const { return (const float*)steps[step].getPtr(vertex); }

  uint64_t hashOf(size_t vertex) const {
    uint64_t h = 0;
    for (unsigned step = 0; step < numSteps; step++) {
      const float* const p = position(vertex, step);
      for (int k = 0; k < 3; k++) {
        h = (h ^ bitsOf(p[k])) * 0x9E3779B97F4A7C15ull;
        h ^= h >> 29;
      }
    }
    return h * 0x9E3779B97F4A7C15ull;
  }

  size_t bucketOf(uint64_t hash) const { return bucketBits == 0 ? 0 : size_t(hash >> (64 - bucketBits)); }

  bool isSame(const Entry& a, const Entry& b) const {
    if (a.hash != b.hash || a.at[0] != b.at[0] || a.at[1] != b.at[1] || a.at[2] != b.at[2]) return false;
    for (unsigned step = 1; step < numSteps; step++) {
      const float *const p = position(a.vertex, step), *const q = position(b.vertex, step);
      for (int k = 0; k < 3; k++)
        if (bitsOf(p[k]) != bitsOf(q[k])) return false;
    }
    return true;
  }

  template<typename Closure>
  void forEachOfTask(size_t task, const Closure& closure) const {
    for (size_t i = task * perTask; i < min(n, (task + 1) * perTask); i++) closure(i, hashOf(i));
  }

  /*! Fills the buckets (counting sort by bucket, then task), with vertices in ascending order. */
  void distribute() {
    cbvh::resizeToFit(ends, numBuckets * numTasks);
    std::fill(ends.begin(), ends.end(), 0u);
    parallel_for(size_t(0), numTasks, size_t(1), [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++)
        forEachOfTask(t, [&](size_t, uint64_t hash) { ends[bucketOf(hash) * numTasks + t]++; });
    });
    unsigned sum = 0;
    for (unsigned& end : ends) {
      const unsigned count = end;
      end = sum;
      sum += count;
    }
    cbvh::resizeToFit(entries, n);
    parallel_for(size_t(0), numTasks, size_t(1), [&](const range<size_t>& r) {
      for (size_t t = r.begin(); t != r.end(); t++)
        forEachOfTask(t, [&](size_t vertex, uint64_t hash) {
          const float* const p = position(vertex, 0);
          entries[ends[bucketOf(hash) * numTasks + t]++] =
              Entry{unsigned(hash), unsigned(vertex), {bitsOf(p[0]), bitsOf(p[1]), bitsOf(p[2])}};
        });
    });
  }

  /*! Welds a bucket, entries begin to end-1. Returns true if any vertices are equal. table: temporary memory for a
   *  hash table. */
  bool weld(size_t begin, size_t end, std::vector<unsigned>& table, mvector<unsigned>& firsts) const {
    size_t size = 16;
    while (size < 2 * (end - begin)) size *= 2;
    table.assign(size, unsigned(none));
    bool anyEqual = false;
    for (size_t i = begin; i != end; i++) {
      const Entry& entry = entries[i];
      size_t at = entry.hash & (size - 1);
      for (; table[at] != none; at = (at + 1) & (size - 1))
        if (isSame(entries[table[at]], entry)) break;
      if (table[at] == none) table[at] = unsigned(i);
      else anyEqual = true;
      firsts[entry.vertex] = entries[table[at]].vertex;
    }
    return anyEqual;
  }

  const BufferView<Vec3fa>* const steps;
  const unsigned numSteps;
  const size_t n, numTasks;
  size_t numBuckets = 1;
  unsigned bucketBits = 0;
  cbvh::UnmonitoredVector<Entry> entries;
  cbvh::UnmonitoredVector<unsigned> ends; //!< ends of each task's entries in each bucket
};
} // namespace

std::shared_ptr<const WeldedVertices> WeldedVertices::find(const BufferView<Vec3fa>* steps, unsigned numSteps,
                                                           size_t n) {
  const std::shared_ptr<WeldedVertices> found = std::make_shared<WeldedVertices>();
  if (n == 0 || n > 0xFFFFFFFEu || !Welding(steps, numSteps, n).run(found->firsts)) return nullptr;
  return found;
}
} // namespace embree
