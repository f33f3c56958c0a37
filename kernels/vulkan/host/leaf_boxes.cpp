// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "leaf_boxes.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace embree::vulkan {

using namespace cbvh;

namespace {

Bounds boundsOf(const LeafBox& box) {
  Bounds out;
  std::copy(box.lower, box.lower + 3, out.lower);
  std::copy(box.upper, box.upper + 3, out.upper);
  return out;
}

Bounds boundsOfChild(const FlatNode& node, int child) {
  Bounds out;
  for (int k = 0; k < 3; k++) {
    out.lower[k] = node.lower[k][child];
    out.upper[k] = node.upper[k][child];
  }
  return out;
}

/* Bounds over the child's time interval. Its ends suffice, because planes move linearly. */
Bounds boundsOfChild(const FlatMovingNode& node, int child) {
  Bounds out = Bounds::empty();
  for (float time : {node.begin[child], node.end[child]}) {
    time = std::min(std::max(time, 0.0f), 1.0f);
    for (int k = 0; k < 3; k++) {
      out.lower[k] = std::min(out.lower[k], node.atZero.lower[k][child] + time * node.lowerDifference[k][child]);
      out.upper[k] = std::max(out.upper[k], node.atZero.upper[k][child] + time * node.upperDifference[k][child]);
    }
  }
  return out;
}

/* Collects the leaves below a reference and their boxes. */
class Leaves {
public:
  explicit Leaves(const Tree& tree) : tree(tree) {}

  /* Each leaf once, sorted by reference. Joins the bounds of equal references. */
  std::vector<std::pair<uint32_t, Bounds>> merged() {
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    size_t n = 0;
    for (const auto& leaf : found)
      if (n && found[n - 1].first == leaf.first) found[n - 1].second.extend(leaf.second);
      else found[n++] = leaf;
    found.resize(n);
    return std::move(found);
  }

  void gather(uint32_t reference, const Bounds& b) {
    const uint32_t type = referenceType(reference), index = referenceIndex(reference);
    if (reference == emptyReference || type == instanceReferenceType) return;
    if (type == nodeReferenceType)
      for (int i = 0; i < 4; i++) gather(tree.nodes[index].children[i], boundsOfChild(tree.nodes[index], i));
    else if (type == movingNodeReferenceType)
      for (int i = 0; i < 4; i++)
        gather(tree.movingNodes[index].atZero.children[i], boundsOfChild(tree.movingNodes[index], i));
    else found.push_back({reference, b});
  }

private:
  const Tree& tree;
  std::vector<std::pair<uint32_t, Bounds>> found;
};

/* Moves bit i to bit 3i, for the lower 21 bits, to interleave three coordinates. */
uint64_t spread(uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  return (x | x << 2) & 0x1249249249249249;
}

/* Distance by which boxes must grow for rounding errors of drivers. Errors, in units of 2^-24 D for a plane at distance
 * D: 7 for (plane - origin)*(1/direction) with a quotient that is off by up to 2.5 ulps, and up to 9 for the shear of
 * cvert/rule/rule.h, which has such a quotient too. The sum is 2^-20 D. 2^-15 of the largest coordinate suffices for
 * rays that start 20 times as far away, with a margin for transforming the ray. */
float roundingSlack(const Bounds& all) {
  float largest = 0;
  for (int k = 0; k < 3; k++) largest = std::max({largest, std::fabs(all.lower[k]), std::fabs(all.upper[k])});
  return std::ldexp(largest, -15);
}

Bounds boundsOf(const std::vector<LeafBox>& boxes) {
  Bounds all = Bounds::empty();
  for (const LeafBox& box : boxes) all.extend(boundsOf(box));
  return all;
}

/* Sorts boxes by the Morton codes of their centers, then by reference, so that the result is deterministic. all: bounds
 * of the boxes. */
void sortByMorton(std::vector<LeafBox>& boxes, const Bounds& all) {
  std::vector<std::pair<uint64_t, LeafBox>> order;
  for (const LeafBox& box : boxes) {
    uint64_t code = 0;
    for (int k = 0; k < 3; k++) {
      const double extent = double(all.upper[k]) - all.lower[k],
                   x = 0.5 * (double(box.lower[k]) + box.upper[k]) - all.lower[k];
      code |= spread(uint64_t(extent > 0 ? x / extent * 0x1FFFFF : 0)) << k;
    }
    order.push_back({code, box});
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first < b.first || (a.first == b.first && a.second.reference < b.second.reference);
  });
  std::transform(order.begin(), order.end(), boxes.begin(), [](const auto& entry) { return entry.second; });
}

} // namespace

std::vector<VkAabbPositionsKHR> LeafBoxes::driverBoxes(const std::function<Bounds(const Bounds&)>& transform) const {
  std::vector<Bounds> all;
  all.reserve(boxes.size());
  Bounds sum = Bounds::empty();
  for (const LeafBox& box : boxes) {
    all.push_back(transform(boundsOf(box)));
    sum.extend(all.back());
  }
  const float width = roundingSlack(sum);
  std::vector<VkAabbPositionsKHR> out;
  out.reserve(boxes.size());
  for (const Bounds& b : all)
    out.push_back({b.lower[0] - width, b.lower[1] - width, b.lower[2] - width, b.upper[0] + width, b.upper[1] + width,
                   b.upper[2] + width});
  return out;
}

std::vector<LeafBoxes> leafBoxesOf(const Tree& tree, const Subtree& subtree,
                                   const std::function<uint32_t(uint32_t)>& geomIDOf) {
  Leaves leaves(tree);
  leaves.gather(subtree.root, subtree.bounds);
  std::map<uint32_t, std::vector<LeafBox>> byGeometry;
  for (const auto& leaf : leaves.merged()) {
    LeafBox box = LeafBox();
    std::copy(leaf.second.lower, leaf.second.lower + 3, box.lower);
    std::copy(leaf.second.upper, leaf.second.upper + 3, box.upper);
    box.reference = leaf.first;
    byGeometry[geomIDOf(leaf.first)].push_back(box);
  }
  std::vector<LeafBoxes> out;
  for (auto& entry : byGeometry) {
    sortByMorton(entry.second, boundsOf(entry.second));
    out.push_back({entry.first, std::move(entry.second)});
  }
  return out;
}

} // namespace embree::vulkan
