// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Splits triangles into clusters of up to 256, usually one per block, and these into groups, recursively by the surface
 * area heuristic: a split minimizes the sum over both parts of surface area times the number of needed clusters or
 * groups. Parts of more than 512 triangles are split at borders of bins, smaller ones at the best of
 * all positions in the order of centers on an axis. Bounds have 16 bits per plane, and sums are exact integers, so that
 * all processors find the same clusters. */

#include "../format/mesh_block.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace cvert { inline namespace CVERT_ISA {
struct MeshCenter {
  float at[3];    //!< center of the triangle's bounds, finite
  uint32_t index; //!< chosen by the caller
};

/*! Groups of consecutive triangles. */
struct MeshGroups {
  uint32_t ends[maxMeshGroups]; //!< index of the group's last triangle plus 1
  uint32_t count = 0;

  void add(uint32_t end) { ends[count++] = end; }
  uint32_t numTriangles() const { return count == 0 ? 0 : ends[count - 1]; }
};

class MeshClusters {
public:
  /*! groupTriangles: of a full group, a power of two up to maxGroupTriangles. */
  explicit MeshClusters(uint32_t groupTriangles)
    : groupTriangles(groupTriangles),
      clusterTriangles(std::min(groupTriangles * maxMeshGroups, maxMeshTriangles)),
      batch(new Batch) {}

  /*! split() applies splitOnce() to larger parts. Threads can split both halves concurrently, each with its own
   *  object. */
  static const size_t batchTriangles = 4096;

  /*! Reorders triangles and calls onCluster(triangles,groups) for each cluster, in order. boundsOf(index,lower,upper)
   *  sets the bounds of a triangle. depth: previous calls of splitOnce() for these triangles. */
  template<typename BoundsOf, typename OnCluster>
  void split(MeshCenter* triangles, size_t count, const BoundsOf& boundsOf, const OnCluster& onCluster,
             uint32_t depth = 0) {
    if (count > batchTriangles) {
      const size_t left = splitOnce(triangles, count, boundsOf, depth);
      split(triangles, left, boundsOf, onCluster, depth + 1);
      split(triangles + left, count - left, boundsOf, onCluster, depth + 1);
      return;
    }
    load(triangles, count, 1, boundsOf);
    splitBinned(0, count, [&](size_t first, uint32_t begin, uint32_t end, const MeshGroups& groups) {
      for (uint32_t i = begin; i < end; i++)
        triangles[first + i] = batch->centers[batch->items[first + batch->order[0][i]].index()];
      onCluster(triangles + first + begin, groups);
    });
  }

  /*! Reorders more than batchTriangles triangles into two parts. Returns the size of the first. */
  template<typename BoundsOf>
  size_t splitOnce(MeshCenter* triangles, size_t count, const BoundsOf& boundsOf, uint32_t depth) {
    const size_t step = count / samples;
    const Quantizer quantizer = load(triangles, (count + step - 1) / step, step, boundsOf);
    const BinSplit split = chooseBinSplit(0, (count + step - 1) / step, step);
    if (depth < maxUnbalancedDepth && split.isPresent) {
      const int k = split.axis;
      const float end = quantizer.positionOf(split.begin, k);
      const size_t left = partition(triangles, count, [=](const MeshCenter& c) { return c.at[k] < end; });
      if (left != 0 && left != count) return left;
    }
    const int k = quantizer.longest;
    std::nth_element(triangles, triangles + count / 2, triangles + count,
                     [k](const MeshCenter& a, const MeshCenter& b) { return a.at[k] < b.at[k]; });
    return count / 2;
  }

  const uint32_t groupTriangles, clusterTriangles;

private:
  static const size_t samples = 256;             //!< splitOnce() samples at least this many triangles
  static const uint32_t maxUnbalancedDepth = 64; //!< splitOnce() halves deeper parts, to limit the recursion
  static const uint32_t bins = 32;               //!< per axis
  static const size_t sortedItems = 512;         //!< parts of up to this many triangles are sorted instead of binned

  /*! Quantized bounds. Lanes 0 to 2: lower; 4 to 6: 65535 minus upper, so that a minimum extends both. */
  typedef uint16_t Lanes __attribute__((vector_size(16)));

  /*! A triangle. Lane 3: index in Batch::centers; 7: 1 on the right side of a split, see splitSortedOnce. */
  struct Item {
    Lanes lanes;

    uint32_t center(int k) const { return uint32_t(lanes[k]) + 65535u - lanes[4 + k]; } //!< twice the center: 17 bits
    uint16_t index() const { return lanes[3]; }
  };

  struct Bounds {
    Lanes lanes = Lanes{} + uint16_t(65535);

    void extend(Lanes item) { lanes = item < lanes ? item : lanes; }

    /*! Half of the surface area. Requires bounds of at least one item. */
    uint64_t area() const {
      uint64_t halves[2];
      std::memcpy(halves, &lanes, sizeof(halves));
      const uint64_t sizes = ~(halves[0] + halves[1]); // subtracts all axes at once; no sum exceeds 16 bits
      const uint64_t x = sizes & 65535, y = (sizes >> 16) & 65535, z = (sizes >> 32) & 65535;
      return x * (y + z) + y * z;
    }
  };

  struct Batch {
    Item items[batchTriangles];
    MeshCenter centers[batchTriangles];
    /* For up to sortedItems consecutive items; indices are relative to the first of them. */
    uint16_t order[3][sortedItems]; //!< items sorted by center on each axis
    uint16_t spare[sortedItems];    //!< temporary, for sorting
    uint64_t areas[sortedItems];    //!< of the bounds of all items from a position on
  };

  /*! Converts world coordinates to 16 bits. Centers of items lie from 8192 to 8192 + 49152; bounds beyond 16 bits are
   *  clamped. */
  struct Quantizer {
    float lower[3], scale;
    int longest;

    static uint16_t quantized(float x) { return uint16_t(std::min(std::max(x + 8192.0f, 0.0f), 65535.0f)); }
    uint16_t at(float x, int k) const { return quantized((x - lower[k]) * scale); }
    float positionOf(uint32_t center, int k) const { return lower[k] + (0.5f * float(center) - 8192.0f) / scale; }
  };

  /*! Loads every step-th triangle into `batch`. */
  template<typename BoundsOf>
  Quantizer load(const MeshCenter* triangles, size_t count, size_t step, const BoundsOf& boundsOf) {
    Quantizer quantizer;
    float upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    std::fill(quantizer.lower, quantizer.lower + 3, INFINITY);
    for (size_t i = 0; i < count; i++) {
      batch->centers[i] = triangles[i * step];
      for (int k = 0; k < 3; k++) {
        quantizer.lower[k] = std::min(quantizer.lower[k], batch->centers[i].at[k]);
        upper[k] = std::max(upper[k], batch->centers[i].at[k]);
      }
    }
    quantizer.longest = 0;
    int& longest = quantizer.longest;
    for (int k = 1; k < 3; k++)
      if (upper[k] - quantizer.lower[k] > upper[longest] - quantizer.lower[longest]) longest = k;
    // 3/4 of the positions: triangles extend beyond their centers' bounds
    quantizer.scale = 49152.0f / std::max(upper[longest] - quantizer.lower[longest], 1e-30f);
    for (size_t i = 0; i < count; i++) {
      float l[3], u[3];
      boundsOf(batch->centers[i].index, l, u);
      uint16_t at[8] = {};
      for (int k = 0; k < 3; k++) {
        at[k] = quantizer.at(l[k], k);
        at[4 + k] = uint16_t(65535 - quantizer.at(u[k], k));
      }
      at[3] = uint16_t(i);
      std::memcpy(&batch->items[i].lanes, at, sizeof(at));
    }
    return quantizer;
  }

  /* --- many items --- */

  /*! Items with Item::center less than `begin` become the left part. */
  struct BinSplit {
    bool isPresent;
    int axis;
    uint32_t begin;
  };

  /*! Finds the split with the least cost at a border of bins. perItem: triangles that an item represents. */
  BinSplit chooseBinSplit(size_t first, size_t count, size_t perItem) {
    Item* const items = batch->items + first;
    uint32_t least[3] = {~0u, ~0u, ~0u}, most[3] = {0, 0, 0}, shifts[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++)
      for (int k = 0; k < 3; k++) {
        const uint32_t c = items[i].center(k);
        least[k] = std::min(least[k], c);
        most[k] = std::max(most[k], c);
      }
    for (int k = 0; k < 3; k++)
      while ((most[k] - least[k]) >> shifts[k] >= bins) shifts[k]++;
    Bounds bounds[3][bins];
    uint16_t counts[3][bins] = {};
    for (size_t i = 0; i < count; i++)
      for (int k = 0; k < 3; k++) {
        const uint32_t bin = (items[i].center(k) - least[k]) >> shifts[k];
        counts[k][bin]++;
        bounds[k][bin].extend(items[i].lanes);
      }
    BinSplit best = {false, 0, 0};
    uint64_t lowest = ~uint64_t(0);
    for (int k = 0; k < 3; k++) {
      const uint32_t last = (most[k] - least[k]) >> shifts[k];
      uint64_t areas[bins]; // of each bin and those after it
      Bounds after, before;
      for (uint32_t b = last; b > 0; b--) {
        after.extend(bounds[k][b].lanes);
        areas[b] = after.area();
      }
      size_t left = 0;
      for (uint32_t b = 1; b <= last; b++) {
        before.extend(bounds[k][b - 1].lanes);
        left += counts[k][b - 1];
        const uint64_t cost = before.area() * unitsFor(left * perItem, clusterTriangles) +
                              areas[b] * unitsFor((count - left) * perItem, clusterTriangles);
        if (cost < lowest) {
          lowest = cost;
          best = {true, k, least[k] + (b << shifts[k])};
        }
      }
    }
    return best;
  }

  /*! Groups or clusters of `unit` triangles that `count` triangles need. unit: a power of two, because a division
   *  would take longer than everything else at a position. */
  static uint64_t unitsFor(size_t count, uint32_t unit) { return (count + unit - 1) >> __builtin_ctz(unit); }

  /*! Moves items for which isLeft is true to the front, and returns their number. */
  template<typename T, typename IsLeft>
  static size_t partition(T* items, size_t count, const IsLeft& isLeft) {
    // without branches, which would be mispredicted
    T* to = items;
    for (T* i = items; i < items + count; i++) {
      const T item = *i;
      *i = *to;
      *to = item;
      to += isLeft(item);
    }
    return size_t(to - items);
  }

  /*! first: first item of the part. onCluster(first,begin,end,groups): receives positions in batch->order. */
  template<typename OnCluster>
  void splitBinned(size_t first, size_t count, const OnCluster& onCluster) {
    if (count <= sortedItems) {
      if (count > 0) splitSorted(first, uint32_t(count), onCluster);
      return;
    }
    const BinSplit split = chooseBinSplit(first, count, 1);
    const size_t left = split.isPresent
                            ? partition(batch->items + first, count,
                                        [=](const Item& item) { return item.center(split.axis) < split.begin; })
                            : count / 2;
    splitBinned(first, left, onCluster);
    splitBinned(first + left, count - left, onCluster);
  }

  /* --- few items --- */

  template<typename OnCluster>
  void splitSorted(size_t first, uint32_t count, const OnCluster& onCluster) {
    for (int k = 0; k < 3; k++) sort(first, count, k);
    splitSorted(first, 0, count, onCluster);
  }

  /*! first: first item of the sorted part. begin, end: positions in batch->order. */
  template<typename OnCluster>
  void splitSorted(size_t first, uint32_t begin, uint32_t end, const OnCluster& onCluster) {
    if (end - begin <= clusterTriangles) {
      MeshGroups groups;
      splitGroups(first, begin, end, begin, maxMeshGroups, groups);
      onCluster(first, begin, end, groups);
      return;
    }
    const uint32_t middle = begin + splitSortedOnce(first, begin, end, clusterTriangles, ~0u);
    splitSorted(first, begin, middle, onCluster);
    splitSorted(first, middle, end, onCluster);
  }

  /*! Splits a part of a cluster into at most `most` groups. cluster: position at which the cluster begins. */
  void splitGroups(size_t first, uint32_t begin, uint32_t end, uint32_t cluster, uint32_t most, MeshGroups& groups) {
    const uint32_t count = end - begin;
    if (count <= groupTriangles) {
      groups.add(end - cluster);
      return;
    }
    const uint32_t left = splitSortedOnce(first, begin, end, groupTriangles, most), right = count - left;
    const uint32_t leftUnits = unitsFor(left, groupTriangles),
                   spare = most - leftUnits - unitsFor(right, groupTriangles);
    const uint32_t mostOfLeft = leftUnits + spare * left / count;
    splitGroups(first, begin, begin + left, cluster, mostOfLeft, groups);
    splitGroups(first, begin + left, end, cluster, most - mostOfLeft, groups);
  }

  /*! Splits into two parts that need at most `most` units of `unit` triangles together. Sorts batch->order so that
   *  the left part comes first on each axis. Returns its size. */
  uint32_t splitSortedOnce(size_t first, uint32_t begin, uint32_t end, uint32_t unit, uint32_t most) {
    Item* const items = batch->items + first;
    const uint32_t count = end - begin;
    uint64_t lowest = ~uint64_t(0);
    uint32_t left = 0;
    int axis = 0;
    for (int k = 0; k < 3; k++) {
      const uint16_t* const order = batch->order[k] + begin;
      Bounds before, after;
      for (uint32_t i = count - 1; i > 0; i--) {
        after.extend(items[order[i]].lanes);
        batch->areas[i] = after.area();
      }
      for (uint32_t i = 1; i < count; i++) {
        before.extend(items[order[i - 1]].lanes);
        const uint32_t units = unitsFor(i, unit), others = unitsFor(count - i, unit);
        if (units + others > most) continue;
        const uint64_t cost = before.area() * units + batch->areas[i] * others;
        if (cost < lowest) {
          lowest = cost;
          left = i;
          axis = k;
        }
      }
    }
    for (uint32_t i = 0; i < count; i++) items[batch->order[axis][begin + i]].lanes[7] = i >= left;
    for (int k = 0; k < 3; k++) {
      if (k == axis) continue;
      uint16_t* const order = batch->order[k] + begin;
      uint32_t numLeft = 0, numRight = 0;
      for (uint32_t i = 0; i < count; i++) {
        const uint16_t item = order[i], isRight = items[item].lanes[7];
        order[numLeft] = batch->spare[numRight] = item;
        numLeft += 1 - isRight;
        numRight += isRight;
      }
      std::copy_n(batch->spare, numRight, order + numLeft);
    }
    return left;
  }

  /*! Radix sort of centers on axis k, by the lower 9 and then the upper 8 bits. */
  void sort(size_t first, uint32_t count, int k) {
    const Item* const items = batch->items + first;
    uint16_t lower[512] = {}, upper[256] = {}, sumLower = 0, sumUpper = 0;
    for (uint32_t i = 0; i < count; i++) {
      const uint32_t c = items[i].center(k);
      lower[c & 511]++;
      upper[c >> 9]++;
    }
    for (uint16_t& x : lower) {
      const uint16_t n = x;
      x = sumLower;
      sumLower = uint16_t(sumLower + n);
    }
    for (uint16_t& x : upper) {
      const uint16_t n = x;
      x = sumUpper;
      sumUpper = uint16_t(sumUpper + n);
    }
    for (uint32_t i = 0; i < count; i++) batch->spare[lower[items[i].center(k) & 511]++] = uint16_t(i);
    for (uint32_t i = 0; i < count; i++)
      batch->order[k][upper[items[batch->spare[i]].center(k) >> 9]++] = batch->spare[i];
  }

  const std::unique_ptr<Batch> batch;
};
}} // namespace cvert::CVERT_ISA
