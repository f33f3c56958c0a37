// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tree of nodes with 16 children above static blocks of the exact kinds, for single rays: a copy of the scene's BVH4
 * with fewer, wider nodes. Of all ways to join nodes, it has the one with the least sum of surface areas, thus the
 * least expected number of nodes per ray (Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs, 2017, section 3.1). */

#include "compressed_tree.h"
#include <vector>

namespace embree {
/*! Joins the nodes of a BVH4 whose leaves are blocks. */
class WideTreeBuilder {
public:
  /*! nodes: receives the tree's nodes, the root first; none if the BVH4 is a single leaf. Throws std::bad_alloc. */
  WideTreeBuilder(BVH4::NodeRef root, const BBox3fa& bounds, mvector<WideNode>& nodes) : nodes(nodes) {
    nodes.clear();
    if (!isInner(root)) return;
    visit(root, bounds);
    nodes.resize(countNodes(0));
    next = 0;
    write(0);
  }

private:
  static bool isInner(BVH4::NodeRef ref) { return ref != BVH4::emptyNode && ref.isAABBNode(); }

  /*! Least cost of a subtree's nodes if at most i + 1 children of the wide node above replace it. */
  struct Costs {
    double at[wideChildren];
  };

  /*! Half of the surface area. Finite: infinity marks what is impossible. */
  static double costOf(const BBox3fa& bounds) {
    double size[3];
    for (size_t axis = 0; axis < 3; axis++) {
      const double difference = double(bounds.upper[axis]) - double(bounds.lower[axis]);
      size[axis] = difference > 0.0 ? min(difference, 1e39) : 0.0;
    }
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }

  /*! How a node of the BVH4 is joined if at most i + 1 children replace it. */
  struct Joint {
    BVH4::AABBNode* node;
    uint32_t joints[4];             //!< of its inner children
    uint16_t joined;                //!< bit i: it becomes a part of the wide node above
    uint8_t share[4][wideChildren]; //!< number of children for child c and those before it: share of c
    bool isJoined(size_t children) const { return (joined >> (children - 1)) & 1u; }
  };

  Costs visit(BVH4::NodeRef ref, const BBox3fa& bounds) {
    Costs costs;
    if (!isInner(ref)) {
      for (double& cost : costs.at) cost = 0.0;
      return costs;
    }
    const size_t index = joints.size();
    joints.emplace_back();
    BVH4::AABBNode* const node = ref.getAABBNode();
    Joint joint;
    joint.node = node;
    joint.joined = 0;
    double sum[wideChildren]; // of the children so far, for i + 1 children of the wide node
    size_t numChildren = 0;
    for (size_t c = 0; c < 4; c++) {
      if (node->child(c) == BVH4::emptyNode) continue;
      joint.joints[c] = uint32_t(joints.size());
      const Costs child = visit(node->child(c), node->bounds(c));
      for (size_t i = wideChildren; i-- > 0;) {
        double best = pos_inf;
        uint8_t share = 0;
        if (numChildren == 0) {
          best = child.at[i];
          share = uint8_t(i + 1);
        } else {
          for (size_t j = 0; j < i; j++) {
            const double cost = child.at[j] + sum[i - j - 1];
            if (cost < best) {
              best = cost;
              share = uint8_t(j + 1);
            }
          }
        }
        sum[i] = best;
        joint.share[c][i] = share;
      }
      numChildren++;
    }
    const double own = costOf(bounds) + sum[wideChildren - 1];
    for (size_t i = 0; i < wideChildren; i++) {
      const bool isJoined = sum[i] <= own;
      costs.at[i] = isJoined ? sum[i] : own;
      if (isJoined) joint.joined |= uint16_t(1u << i);
    }
    joints[index] = joint;
    return costs;
  }

  /*! Calls f(child, joint, bounds, share) for the children of a node of the BVH4 that `children` children replace. */
  template<typename Function>
  void forEachChild(uint32_t index, size_t children, const Function& f) const {
    const Joint& joint = joints[index];
    for (size_t c = 4; c-- > 0;) {
      const BVH4::NodeRef child = joint.node->child(c);
      if (child == BVH4::emptyNode) continue;
      const size_t share = joint.share[c][children - 1];
      f(child, joint.joints[c], joint.node->bounds(c), share);
      children -= share;
    }
  }

  /*! Calls f(child, joint, bounds) for the children of the wide node that a node of the BVH4 becomes. */
  template<typename Function>
  void forEachWideChild(uint32_t index, const Function& f, size_t children = wideChildren) const {
    forEachChild(index, children, [&](BVH4::NodeRef child, uint32_t joint, const BBox3fa& bounds, size_t share) {
      if (isInner(child) && joints[joint].isJoined(share)) forEachWideChild(joint, f, share);
      else f(child, joint, bounds);
    });
  }

  size_t countNodes(uint32_t index) const {
    size_t sum = 1;
    forEachWideChild(index, [&](BVH4::NodeRef child, uint32_t joint, const BBox3fa&) {
      if (isInner(child)) sum += countNodes(joint);
    });
    return sum;
  }

  WideNode* write(uint32_t index) {
    WideNode* const node = &nodes[next++];
    size_t n = 0;
    forEachWideChild(index, [&](BVH4::NodeRef child, uint32_t joint, const BBox3fa& bounds) {
      node->set(n++, isInner(child) ? size_t(write(joint)) : size_t(child), bounds);
    });
    return node;
  }

  mvector<WideNode>& nodes;
  std::vector<Joint> joints; //!< of inner nodes, parents first
  size_t next = 0;
};
} // namespace embree
