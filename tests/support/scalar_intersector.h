// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A readable reference for the SIMD intersectors of a block: any precision, one child at a time, no mirrored axes, no
 * nodes skipped because of a closer hit. Its decisions are functions of kernels/cbvh/paper.
 *
 * The SIMD path widens bounds by the float error of its ray. "widening" is the multiple of that error by which this
 * intersector widens: 0 gives the exact result, and SIMD's result lies between the results for 0 and for 2. */

#include "kernels/cbvh/paper/leaf/crossing.h"
#include "kernels/cbvh/paper/normal.h"
#include "kernels/cbvh/paper/tree.h"
#include <limits>
#include <utility>
#include <vector>

namespace embree::cbvh { inline namespace CBVH_ISA {
template<typename Real>
struct ScalarHit {
  bool found = false;
  Real t = std::numeric_limits<Real>::infinity();
  Real u = 0, v = 0; //!< on the face
  Real Ng[3] = {0, 0, 0};
  uint32_t leaf = 0; //!< Morton index
};

template<typename Real>
class ScalarIntersector {
public:
  typedef WorldRay<Real> Ray;
  typedef ScalarHit<Real> Hit;

  ScalarIntersector(const Block* block, Real widening = 0)
    : block(block),
      layout(block->layout()),
      kind(block->kind()),
      widening(widening) {}

  /*! all: receives every hit of the traversal, or NULL. */
  Hit intersect(const Ray& r, std::vector<Hit>* all = nullptr) {
    ray = r;
    met = all;
    best = Hit();
    state = startOfWalk();
    segment = enterBlock(*block, ray, widening);
    if (segment.valid) visit(0, 0, rootBox());
    return best;
  }

private:
  /*! Visits children in the order along the ray: mirrors x and y so that the ray ascends, then 0, 1 and 2 (the one
   *  entered first), 3. */
  void visit(uint32_t level, uint32_t m, const NodeBox& box) {
    if (!meets(box, 3)) return;
    if (level == layout.nodeLevels) {
      leaf(m, box);
      return;
    }
    NodeBox children[4];
    for (uint32_t c = 0; c < 4; c++) children[c] = childBox(block, level, m, c, box);
    const uint32_t flip = (segment.P1[0] < segment.P0[0] ? 1 : 0) | (segment.P1[1] < segment.P0[1] ? 2 : 0);
    uint32_t order[4] = {flip, 1 ^ flip, 2 ^ flip, 3 ^ flip};
    const NodeBox &first = children[order[1]], &second = children[order[2]];
    if (meets(first, 2) && meets(second, 2) &&
        rangeInBox(segment, second, 3).lower < rangeInBox(segment, first, 3).lower)
      std::swap(order[1], order[2]);
    for (uint32_t c : order) {
      if (meets(children[c], 3)) {
        if (isGroupLevel(uint32_t(kind), level, layout.nodeLevels)) patch = leafOfGroup(block, m, c, box);
        visit(level + 1, 4 * m + c, children[c]);
      } else if (needsPassedBoxes(state) && meets(children[c], 2)) passed(isAbove(children[c]));
    }
  }

  /*! True if the segment intersects a box in its first axes. */
  bool meets(const NodeBox& box, int axes) const { return isOnSegment(rangeInBox(segment, box, axes)); }

  /*! True if the segment passes above the box; it must overlap the box in x and y. */
  bool isAbove(const NodeBox& box) const {
    const Range<Real> range = rangeInBox(segment, box, 2);
    const Real middle = Real(0.5f) * (maximum(range.lower, Real(0)) + minimum(range.upper, Real(1)));
    return segmentAt(segment, 2, middle) > box.lower[2] + Real(0.5f) * box.extent[2];
  }

  void leaf(uint32_t m, const NodeBox& box) {
    switch (kind) {
    case Kind::CGRID: gridLeaf(m); break;
    case Kind::CVOXEL: voxelLeaf(m, box); break;
    case Kind::CLEAF: patchLeaf(m); break;
    case Kind::CVERT: break; // has no blocks with frames
    }
  }

  /* --- cLEAF --- */

  void patchLeaf(uint32_t m) {
    const Crossing<Real> x = crossPatch(segment, patch);
    const HitResult result = crossLeaf(state, x.event);
    const bool hadHit = state.found;
    state = result.next;
    Real s = x.s0;
    if (result.hit == hitRoot) s = x.s0 + parabolaRoot(x.f) * (x.s1 - x.s0);
    if (result.hit == hitLip) {
      const Lip<Real> lip = {Real(borderWidthOf(block->info)), Real(0.5f * patch.thickness), segment.epsilon[2]};
      const LipIntersection<Real> at = intersectLipsOfLeaf(x, mortonX(m), mortonY(m), layout.leavesPerSide - 1, lip);
      if (at.hit) s = x.s0 + at.k * (x.s1 - x.s0);
      else {
        rememberExit(m, x.s1);
        return;
      }
    }
    if (result.hit == hitNone) {
      if (!hadHit) rememberExit(m, x.s1);
      return;
    }
    hit(m, patch, s, result.from);
    state = afterHit(state);
  }

  void rememberExit(uint32_t m, Real s) {
    exitLeaf = m;
    exitPatch = patch;
    exitS = s;
  }

  void passed(bool above) {
    const HitResult result = passBox(state, above);
    state = result.next;
    if (result.hit == hitNone) return;
    hit(exitLeaf, exitPatch, exitS, result.from);
    state = afterHit(state);
  }

  /* --- cVOXEL --- */

  void voxelLeaf(uint32_t m, const NodeBox& box) {
    const Range<Real> range = rangeInBox(segment, box, 3);
    if (segment.startClipped && range.lower < Real(0)) return;
    LeafPatch solid;
    solid.box = box;
    solid.solid = true;
    hit(m, solid, maximum(range.lower, Real(0)), sideUnknown);
  }

  /* --- hits on leaves --- */

  void hit(uint32_t m, const LeafPatch& leaf, Real s, uint32_t from) {
    const Real t = worldT(segment, s);
    if (!met && !(t < best.t)) return;
    const Real u = positionInBox(segment, leaf.box, 0, s), v = positionInBox(segment, leaf.box, 1, s);
    Hit at = hitOf(m, t, mortonX(m) + u, mortonY(m) + v);
    const Vector<Real> p = {{segmentAt(segment, 0, s), segmentAt(segment, 1, s), segmentAt(segment, 2, s)}};
    const Vector<Real> n = worldNormal(*block, p, patchSlope(leaf, 0, v), patchSlope(leaf, 1, u));
    Real along = 0, dir2 = 0, Ng2 = 0;
    for (int i = 0; i < 3; i++) {
      at.Ng[i] = n.x[i];
      along += n.x[i] * ray.dir[i];
      dir2 += ray.dir[i] * ray.dir[i];
      Ng2 += n.x[i] * n.x[i];
    }
    if (isMirrored(along, Ng2, dir2, from))
      for (int i = 0; i < 3; i++) at.Ng[i] -= 2 * along / dir2 * ray.dir[i];
    take(at);
  }

  /*! x, y: in leaves, relative to the corner of the block */
  Hit hitOf(uint32_t m, Real t, Real x, Real y) const {
    const Real size = Real(1u << block->height()) / Real(layout.leavesPerSide); // size of a leaf in quads
    Hit at;
    at.found = true;
    at.t = t;
    at.leaf = m;
    at.u = block->faceU(size * x);
    at.v = block->faceV(size * y);
    return at;
  }

  void take(const Hit& at) {
    if (at.t < best.t) best = at;
    if (met) met->push_back(at);
  }

  /* --- cGRID --- */

  typedef Vector<Real> Point;

  static Point cross(const Point& a, const Point& b) {
    return {{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
  }
  static Real dot(const Point& a, const Point& b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }
  static Point minus(const Point& a, const Point& b) { return {{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}}; }

  /*! a vertex, its coordinates in quads, and its position in the quad */
  struct Corner {
    Point p;
    Real x, y;
  };

  Corner corner(uint32_t x, uint32_t y) const {
    const uint32_t width = (1u << block->height()) + 1;
    Corner c;
    for (uint32_t k = 0; k < 3; k++)
      c.p.x[k] = ((const float*)block->leaves())[size_t(k) * width * width + y * width + x];
    c.x = Real(x);
    c.y = Real(y);
    return c;
  }

  /*! the triangles (00,10,01) and (01,10,11) of every quad of a leaf */
  void gridLeaf(uint32_t m) {
    const uint32_t quads = (1u << block->height()) / layout.leavesPerSide;
    for (uint32_t y = quads * mortonY(m); y < quads * (mortonY(m) + 1); y++)
      for (uint32_t x = quads * mortonX(m); x < quads * (mortonX(m) + 1); x++) {
        triangle(m, corner(x, y), corner(x + 1, y), corner(x, y + 1));
        triangle(m, corner(x, y + 1), corner(x + 1, y), corner(x + 1, y + 1));
      }
  }

  void triangle(uint32_t m, const Corner& a, const Corner& b, const Corner& c) {
    const Point o = {{ray.org[0], ray.org[1], ray.org[2]}}, d = {{ray.dir[0], ray.dir[1], ray.dir[2]}};
    const Point e1 = minus(b.p, a.p), e2 = minus(c.p, a.p), n = cross(e1, e2), ao = minus(a.p, o);
    const Real den = dot(n, d);
    if (den == 0) return;
    const Real t = dot(n, ao) / den, n2 = dot(n, n);
    Point p;
    for (int k = 0; k < 3; k++) p.x[k] = t * d.x[k] - ao.x[k];
    const Real u = dot(cross(p, e2), n) / n2, v = dot(cross(e1, p), n) / n2;
    const Real slack = Real(1e-9); // rounding in double
    if (u < -slack || v < -slack || u + v > 1 + slack || t < ray.tnear || t > ray.tfar) return;
    const Real leafQuads = Real(1u << block->height()) / Real(layout.leavesPerSide);
    Hit at = hitOf(m, t, (a.x + u * (b.x - a.x) + v * (c.x - a.x)) / leafQuads,
                   (a.y + u * (b.y - a.y) + v * (c.y - a.y)) / leafQuads);
    for (int k = 0; k < 3; k++) at.Ng[k] = n.x[k];
    take(at);
  }

private:
  const Block* block;
  BlockLayout layout;
  Kind kind;
  Real widening;
  Ray ray;
  Hit best;
  std::vector<Hit>* met = nullptr;
  Segment<Real> segment;

  LeafPatch patch; //!< cLEAF: the leaf to visit next
  WalkState state;
  uint32_t exitLeaf; //!< the leaf that the ray left most recently
  LeafPatch exitPatch;
  Real exitS;
};
}} // namespace embree::cbvh::CBVH_ISA
