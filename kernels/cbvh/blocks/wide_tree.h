// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tree of nodes with 16 children above blocks of the exact kinds, for single rays: a copy of the scene's BVH4 with
 * fewer, wider nodes. Of all ways to join nodes, it has the one with the least sum of surface areas, thus the
 * least expected number of nodes per ray (Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs, 2017, section 3.1). */

#include "compressed_tree.h"
#include <vector>

namespace embree {
/*! Nodes of trees over surfaces at rest. */
struct StaticWideTree {
  typedef WideNode Wide;
  typedef BVH4::AABBNode Node; //!< of the BVH4
  static bool isNode(BVH4::NodeRef ref) { return ref.isAABBNode(); }
  static Node* nodeOf(BVH4::NodeRef ref) { return ref.getAABBNode(); }
  static BBox3fa boundsOf(const Node* node, size_t c) { return node->bounds(c); }
};

/*! Of trees over moving surfaces, unless nodes split time. Costs are those of the mean of both ends. */
struct MovingWideTree {
  typedef WideMovingNode Wide;
  typedef BVH4::AABBNodeMB Node;
  static bool isNode(BVH4::NodeRef ref) { return ref.isAABBNodeMB(); }
  static Node* nodeOf(BVH4::NodeRef ref) { return ref.getAABBNodeMB(); }
  static BBox3fa boundsOf(const Node* node, size_t c) {
    const BBox3fa begin = node->bounds0(c), end = node->bounds1(c);
    return BBox3fa(0.5f * begin.lower + 0.5f * end.lower, 0.5f * begin.upper + 0.5f * end.upper);
  }
};

/*! Joins the nodes of a BVH4 whose leaves are blocks. Tree: StaticWideTree or MovingWideTree. */
template<typename Tree>
class WideTreeBuilder {
  typedef typename Tree::Wide Wide;

public:
  /*! nodes: receives the tree's nodes, the root first; none if the BVH4 is a single leaf, or has other inner nodes.
   *  Throws std::bad_alloc. */
  WideTreeBuilder(BVH4::NodeRef root, const BBox3fa& bounds, mvector<Wide>& nodes) : nodes(nodes) {
    nodes.clear();
    if (!isInner(root)) return;
    visit(root, bounds);
    if (hasOtherNodes) return;
    nodes.resize(countNodes(0));
    next = 0;
    write(0);
  }

private:
  static bool isInner(BVH4::NodeRef ref) { return ref != BVH4::emptyNode && Tree::isNode(ref); }

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
    typename Tree::Node* node;
    uint32_t joints[4];             //!< of its inner children
    uint16_t joined;                //!< bit i: it becomes a part of the wide node above
    uint8_t share[4][wideChildren]; //!< number of children for child c and those before it: share of c
    bool isJoined(size_t children) const { return (joined >> (children - 1)) & 1u; }
  };

  Costs visit(BVH4::NodeRef ref, const BBox3fa& bounds) {
    Costs costs;
    if (!isInner(ref)) {
      hasOtherNodes |= !ref.isLeaf();
      for (double& cost : costs.at) cost = 0.0;
      return costs;
    }
    const size_t index = joints.size();
    joints.emplace_back();
    typename Tree::Node* const node = Tree::nodeOf(ref);
    Joint joint;
    joint.node = node;
    joint.joined = 0;
    double sum[wideChildren]; // of the children so far, for i + 1 children of the wide node
    size_t numChildren = 0;
    for (size_t c = 0; c < 4; c++) {
      if (node->child(c) == BVH4::emptyNode) continue;
      joint.joints[c] = uint32_t(joints.size());
      const Costs child = visit(node->child(c), Tree::boundsOf(node, c));
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

  /*! Calls f(c, joint, share) for the children of a node of the BVH4 that `children` children replace. */
  template<typename Function>
  void forEachChild(uint32_t index, size_t children, const Function& f) const {
    const Joint& joint = joints[index];
    for (size_t c = 4; c-- > 0;) {
      const BVH4::NodeRef child = joint.node->child(c);
      if (child == BVH4::emptyNode) continue;
      const size_t share = joint.share[c][children - 1];
      f(c, joint.joints[c], share);
      children -= share;
    }
  }

  /*! Calls f(node, c, joint) for the children of the wide node that a node of the BVH4 becomes: child c of a node. */
  template<typename Function>
  void forEachWideChild(uint32_t index, const Function& f, size_t children = wideChildren) const {
    const typename Tree::Node& node = *joints[index].node;
    forEachChild(index, children, [&](size_t c, uint32_t joint, size_t share) {
      if (isInner(node.child(c)) && joints[joint].isJoined(share)) forEachWideChild(joint, f, share);
      else f(node, c, joint);
    });
  }

  size_t countNodes(uint32_t index) const {
    size_t sum = 1;
    forEachWideChild(index, [&](const typename Tree::Node& node, size_t c, uint32_t joint) {
      if (isInner(node.child(c))) sum += countNodes(joint);
    });
    return sum;
  }

  Wide* write(uint32_t index) {
    Wide* const wide = &nodes[next++];
    size_t n = 0;
    forEachWideChild(index, [&](const typename Tree::Node& node, size_t c, uint32_t joint) {
      const BVH4::NodeRef child = node.child(c);
      wide->set(n++, isInner(child) ? size_t(write(joint)) : size_t(child), node, c);
    });
    return wide;
  }

  mvector<Wide>& nodes;
  std::vector<Joint> joints; //!< of inner nodes, parents first
  size_t next = 0;
  bool hasOtherNodes = false;
};
} // namespace embree
