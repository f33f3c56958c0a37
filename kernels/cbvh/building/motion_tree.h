// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tree over the moving blocks of a scene: Embree's BVH4 for motion blur, with boxes that are linear in time and nodes
 * that split the time range. Boxes contain the blocks despite rounding in traversal (see MovingPlane). */

#include "../embree/motion_builder.h"
#include "../base/step_box.h"
#include "../base/tasks.h"
#include <vector>

namespace embree::isa {
class MotionTree {
  typedef BVH4::NodeRef NodeRef;
  typedef BVHBuilderMSMBlur::BuildRecord BuildRecord;
  typedef BVHNodeRecordMB4D<NodeRef> NodeRecord;

public:
  struct Block {
    NodeRef leaf;
    const cbvh::StepBox* boxes; //!< one per step; not all are empty
    BBox1f range;               //!< times of the first and last step
    unsigned segments;          //!< steps minus 1
  };

  LBBox3fa bounds = LBBox3fa(empty); //!< bounds at times 0 and 1, set by build()
  size_t bytes = 0;                  //!< size of the nodes

  /*! Returns the root, allocated in `memory`; emptyNode without blocks. progress() may throw to cancel. */
  template<typename Progress>
  NodeRef build(Device* device, FastAllocator& memory, const mvector<Block>& blocks, const Progress& progress) {
    if (blocks.size() == 0) return BVH4::emptyNode;
    const Recalculate recalculate = {blocks};
    mvector<PrimRefMB> prims(device, blocks.size());
    const PrimInfoMB info = reduceRanges(
        blocks.size(), size_t(1024), PrimInfoMB(empty),
        [&](const range<size_t>& r) {
          PrimInfoMB info(empty);
          for (size_t i = r.begin(); i != r.end(); i++) {
            prims[i] = recalculate(i, BBox1f(0.0f, 1.0f));
            info.add_primref(prims[i]);
          }
          return info;
        },
        [](const PrimInfoMB& a, const PrimInfoMB& b) { return PrimInfoMB::merge2(a, b); });
    PrimInfoMB all = info;
    all.object_range = range<size_t>(0, blocks.size());

    BVHBuilderMSMBlur::Settings settings;
    settings.branchingFactor = 4;
    settings.maxDepth = BVH4::maxDepth;
    settings.logBlockSize = bsr(4);
    settings.minLeafSize = settings.maxLeafSize = 1;
    settings.travCost = settings.intCost = 1.0f;
    settings.singleLeafTimeSegment = false;

    auto createLeaf = [&](const BuildRecord& current, const FastAllocator::CachedAllocator&) {
      const Block& block = blocks[(*current.prims.prims)[current.prims.begin()].ID()];
      return NodeRecord(block.leaf, linearBounds(block, current.prims.time_range), current.prims.time_range);
    };
    auto monitor = [&](size_t) { progress(); };
    std::atomic<size_t> used(0);
    auto createNode = [&](BuildRecord*, size_t, const FastAllocator::CachedAllocator& alloc, bool splitsTime) {
      used += splitsTime ? sizeof(BVH4::AABBNodeMB4D) : sizeof(BVH4::AABBNodeMB);
      return BVH4::AABBNodeMB4D::Create()((BuildRecord*)nullptr, 0, alloc, splitsTime);
    };
    const NodeRecord root =
        BVHBuilderMSMBlur::build<NodeRef>(prims, all, device, recalculate, FastAllocator::Create(&memory), createNode,
                                          SetNode(), createLeaf, monitor, settings);
    for (int k = 0; k < 3; k++) {
      const MovingPlane lower(root.lbounds.bounds0.lower[k], root.lbounds.bounds1.lower[k], root.dt, false),
          upper(root.lbounds.bounds0.upper[k], root.lbounds.bounds1.upper[k], root.dt, true);
      bounds.bounds0.lower[k] = lower.at0;
      bounds.bounds1.lower[k] = lower.at0 + lower.difference;
      bounds.bounds0.upper[k] = upper.at0;
      bounds.bounds1.upper[k] = upper.at0 + upper.difference;
    }
    bytes = used;
    return root.ref;
  }

private:
  /*! Bounds of a block in a range of times, for Embree's builder. */
  struct Recalculate {
    const mvector<Block>& blocks;

    PrimRefMB operator()(size_t i, const BBox1f& range) const {
      const Block& block = blocks[i];
      const int active = max(1, int(getTimeSegmentRange(range, block.range, float(block.segments)).size()));
      return PrimRefMB(MotionTree::linearBounds(block, range), unsigned(active), widened(block.range), block.segments,
                       i);
    }
    PrimRefMB operator()(const PrimRefMB& prim, const BBox1f& range) const { return (*this)(prim.ID(), range); }
    LBBox3fa linearBounds(const PrimRefMB& prim, const BBox1f& range) const {
      return MotionTree::linearBounds(blocks[prim.ID()], range);
    }

  private:
    /*! Widens a range: Embree's builder omits a block from a part of the time if 0.9999 times its end is not
     *  after the part's beginning, or 1.0001 times its beginning is not before the part's end. */
    static BBox1f widened(const BBox1f& range) {
      return BBox1f(range.lower > 0.0f ? range.lower * 0.9998f : range.lower,
                    range.upper < 1.0f ? range.upper * 1.0002f : range.upper);
    }
  };

  /*! A plane of a block's boxes on axis k in a range of times. It is linear between knots: the steps in the range
   *  and its two ends. */
  class Knots {
  public:
    /*! first, last: range of times, in steps. */
    Knots(const Block& block, int k, bool isUpper, double first, double last)
      : block(block),
        k(k),
        isUpper(isUpper),
        first(first),
        last(last) {}

    template<typename Closure>
    void forEach(const Closure& closure) const {
      at(first, closure);
      for (unsigned i = unsigned(first) + 1; double(i) < last; i++) at(double(i), closure);
      if (last > first) at(last, closure);
    }

    /*! Plane at any step at which the block exists. */
    double anyPlane() const {
      unsigned i = 0;
      while (!exists(i)) i++;
      return plane(i);
    }

  private:
    double plane(unsigned i) const { return double((isUpper ? block.boxes[i].upper : block.boxes[i].lower)[k]); }
    bool exists(unsigned i) const { return !block.boxes[i].isEmpty(); }

    template<typename Closure>
    void at(double position, const Closure& closure) const {
      const unsigned i = std::min(unsigned(position), block.segments - 1);
      const double f = position - i;
      if (f == 0.0) {
        if (exists(i)) closure(position, plane(i));
      } else if (f == 1.0) {
        if (exists(i + 1)) closure(position, plane(i + 1));
      } else if (exists(i) && exists(i + 1)) closure(position, (1 - f) * plane(i) + f * plane(i + 1));
    }

    const Block& block;
    const int k;
    const bool isUpper;
    const double first, last;
  };

  /*! Returns boxes at the ends of a range of times. Interpolated linearly, they contain the block whenever it
   *  exists: each plane is a line from the first to the last knot, moved until no knot is outside. */
  static LBBox3fa linearBounds(const Block& block, const BBox1f& range) {
    const double n = double(block.segments), scale = n / (double(block.range.upper) - double(block.range.lower));
    const double begin = (double(range.lower) - double(block.range.lower)) * scale,
                 end = (double(range.upper) - double(block.range.lower)) * scale;
    const double first = std::min(std::max(begin, 0.0), n), last = std::max(std::min(end, n), first);
    LBBox3fa out(empty);
    for (int k = 0; k < 3; k++)
      for (bool isUpper : {false, true}) {
        const Knots knots(block, k, isUpper, first, last);
        size_t count = 0;
        double positions[2] = {first, first}, planes[2] = {0, 0}; // first and last knot
        knots.forEach([&](double position, double plane) {
          const int i = count++ > 0;
          positions[i] = position;
          planes[i] = plane;
        });
        if (count == 0) planes[0] = knots.anyPlane(); // no ray hits the block in this range
        const double slope = count > 1 ? (planes[1] - planes[0]) / (positions[1] - positions[0]) : 0.0;
        double outside = 0; // largest distance of a knot outside of the line
        knots.forEach([&](double position, double plane) {
          const double line = planes[0] + slope * (position - positions[0]);
          outside = std::max(outside, isUpper ? plane - line : line - plane);
        });
        const double from = planes[0] + (isUpper ? outside : -outside);
        (isUpper ? out.bounds0.upper : out.bounds0.lower)[k] = outwards(from + slope * (begin - positions[0]), isUpper);
        (isUpper ? out.bounds1.upper : out.bounds1.lower)[k] = outwards(from + slope * (end - positions[0]), isUpper);
      }
    // the builder compares areas: lines must not cross, even when the block does not exist
    out.bounds0.upper = max(out.bounds0.upper, out.bounds0.lower);
    out.bounds1.upper = max(out.bounds1.upper, out.bounds1.lower);
    return out;
  }

  static float outwards(double x, bool isUpper) {
    const float largest = std::numeric_limits<float>::max() / 8,
                f = float(std::min(std::max(x, -double(largest)), double(largest)));
    if (isUpper) return double(f) >= x ? f : std::nextafter(f, largest);
    return double(f) <= x ? f : std::nextafter(f, -largest);
  }

  /*! A plane of a child's box, at0 + time*difference in floats, moved outwards by a bound of traversal's rounding
   *  errors. In units of 2^-24 of the sum of both absolute values: the sum is rounded by 1, the product by 1 if it
   *  is not fused, and the stored difference by 1. The block derives its position between two steps from the ray's
   *  time with 4 roundings, each worth at most the difference; shaders' quotient, off by up to 2.5 ulps, adds 4.
   *  The vertices at that position are rounded by 3. The total is less than 16. */
  struct MovingPlane {
    float at0, difference;

    /*! Extrapolates from the ends of a range to times 0 and 1. */
    MovingPlane(double begin, double end, const BBox1f& range, bool isUpper) {
      const double slope = (end - begin) / (double(range.upper) - double(range.lower)),
                   from = begin - slope * double(range.lower);
      const double wide =
          (std::fabs(from) + std::fabs(slope)) * (1.0 / (1 << 20)) + double(std::numeric_limits<float>::min());
      at0 = outwards(isUpper ? from + wide : from - wide, isUpper);
      difference = float(slope);
    }
  };

  struct SetNode {
    void operator()(const BuildRecord&, const BuildRecord* records, NodeRef ref, NodeRecord* children,
                    size_t count) const {
      BVH4::AABBNodeMB* const node = ref.getAABBNodeMB();
      for (size_t i = 0; i < count; i++) {
        const NodeRecord& child = children[i];
        node->setRef(i, child.ref);
        vfloat4* const planes = &node->lower_x; // lower and upper planes per axis, then their differences
        for (int k = 0; k < 3; k++) {
          const MovingPlane lower(child.lbounds.bounds0.lower[k], child.lbounds.bounds1.lower[k], child.dt, false),
              upper(child.lbounds.bounds0.upper[k], child.lbounds.bounds1.upper[k], child.dt, true);
          planes[2 * k][i] = lower.at0;
          planes[2 * k + 6][i] = lower.difference;
          planes[2 * k + 1][i] = upper.at0;
          planes[2 * k + 7][i] = upper.difference;
        }
        if (ref.isAABBNodeMB()) continue;
        BVH4::AABBNodeMB4D* const split = ref.getAABBNodeMB4D();
        /* traversal visits a child at times lower_t <= t < upper_t, but a block also exists at its last step */
        split->lower_t[i] = child.dt.lower;
        split->upper_t[i] =
            endsAtTime(records[i], child.dt.upper) ? std::nextafter(child.dt.upper, 2.0f) : child.dt.upper;
      }
    }

    /*! True if the widened range of a block ends by this time. Other blocks are also in the next child, if any,
     *  which begins there. */
    static bool endsAtTime(const BuildRecord& record, float time) {
      for (size_t i = record.prims.begin(); i != record.prims.end(); i++)
        if ((*record.prims.prims)[i].time_range.upper <= time) return true;
      return false;
    }
  };
};
} // namespace embree::isa
