// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The rule that decides where a ray hits a cLEAF block. crossing.h and crossing1.h compute how the ray crosses a leaf.
 * tests/codec/hit_rule.txt has the rule as tables, which a test compares with this code.
 *
 * Along a ray, the height above the patch,
 *
 *   f(s) = z of the ray - z of the leaf's patch,
 *
 * is evaluated where the ray enters and leaves the leaf's box, as in the paper's line test. But hits are at roots of
 * the parabola f, not of a line. The ray is above where f >= 0. A box contains its quads, so the ray is also above
 * where it passes through the upper face, and below where it passes through the lower face. It hits where f changes
 * sign, or if it enters and leaves on different sides.
 *
 * Patches of adjacent groups (format.h) deviate from their shared edge by up to half a thickness. So that no ray passes
 * through the step between them, a ray remembers on which side it left the last leaf, or passed the last box. It hits
 *
 * - at the entry of a leaf, if it enters on the other side;
 * - where it left a leaf that it came within half a thickness of, if it then passes over (under) the next boxes,
 *   although it was under (over) that leaf;
 * - in a lip at the block's border, where the neighbor is in another block, which does not know the remembered side.
 *
 *      surface of A  ____           The encoder keeps both surfaces above their shared
 *      ---------.....|   ....---    edge by less than half a thickness. Lips extend down
 *                 lip|---|lip       from the border by half a thickness: both reach the
 *                     edge          edge, so together they close the gap.
 *
 * Proof that no ray passes through. Inside a block, the leaves and passed boxes cover the ray's path in x and y without
 * a gap, and every change of the remembered side is a hit. So only the first or last side that a ray remembers could be
 * wrong. At its first position in the block there are two cases. First, the ray is outside of the box of the quads
 * there; its side is where it passes the box, or the face through which it enters. Second, it crosses an edge on the
 * border. Assume that it is above that edge (below is the same, mirrored, but the patch is above the edge in both). At
 * this position, the patch is at most half a thickness above the edge. If the ray is below the patch, it is in the lip.
 * If it is above, f >= 0 there, and the ray leaves the leaf on the upper side; or f changes sign after this position;
 * or f changes sign before, which is in the lip unless the ray entered through the lower face. For this reason, a
 * change of sign is a hit even if the ray enters and leaves on the same side, as where the box ends but its patch does
 * not.
 *
 * A ray that starts within half a thickness of a leaf's surface does not hit steps and changes of sign in other leaves
 * that it leaves on the remembered side: the surface must not shadow its own points. A segment that starts in a leaf,
 * at tnear, does not hit its steps, lips or solid box. A segment that ends in a leaf, at tfar, does not hit its lips.
 *
 * In the paper, rays hit the nearer bound of a leaf. This also closes the steps, but thickens the surface: rays along a
 * crest hit what they should pass, hits are early by half a thickness, and rays that start on the surface hit it again.
 *
 * If a surface folds over, leaves overlap and are not visited in their order along the ray. A walk for the closest hit
 * therefore continues after a hit, and accepts nearer changes of sign and solid boxes.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing Subdivision Surfaces with Displacement",
 * 2018, section 4. */

#ifndef CBVH_PAPER_LEAF_HIT_RULE_H
#define CBVH_PAPER_LEAF_HIT_RULE_H

#include "../../base/codec_names.h"

CBVH_BEGIN

/* Sides of a leaf's surface, along the z axis of the frame. */
CVERT_CONSTANT uint32_t sideUnknown = 0u, sideBelow = 1u, sideAbove = 2u;

/*! State of a ray's walk through a block. */
struct WalkState {
  uint32_t side;    //!< on which it left the last leaf, or passed the last box
  bool pending;     //!< it was near the patch of the last leaf, and has not changed its side since
  bool fromSurface; //!< it starts in a leaf, within half a thickness of the patch
  bool found;       //!< a hit was accepted
};

CVERT_FUNCTION WalkState startOfWalk() {
  WalkState state;
  state.side = sideUnknown;
  state.pending = state.fromSurface = state.found = false;
  return state;
}

/*! How a ray crosses a leaf. */
struct LeafEvent {
  uint32_t enter; //!< side where it enters the box
  uint32_t leave; //!< side where it leaves the box
  bool changes;   //!< f has different signs at entry and exit
  bool nearEntry; //!< within half a thickness of the patch at the entry
  bool near;      //!< possibly within half a thickness between entry and exit
  bool started;   //!< the segment starts inside the box
  bool ended;     //!< the segment ends inside the box
  bool solid;     //!< the leaf's box is its surface
  bool empty;     //!< the leaf has no surface
};

/* Where a ray hits a leaf. */
CVERT_CONSTANT uint32_t hitNone = 0u;
CVERT_CONSTANT uint32_t hitBox = 1u;  //!< at the entry: the box is the surface
CVERT_CONSTANT uint32_t hitStep = 2u; //!< at the entry, after a step
CVERT_CONSTANT uint32_t hitRoot = 3u; //!< where f changes sign; if it does not, at the end nearer to the patch
CVERT_CONSTANT uint32_t hitLip = 4u;  //!< in a lip, if the caller finds that the ray intersects one; otherwise no hit
CVERT_CONSTANT uint32_t hitExit = 5u; //!< where the ray left the previous leaf

/*! Result of the rule for a leaf or a passed box. */
struct HitResult {
  uint32_t hit;   //!< hitNone, or where the ray hits; hitLip may be a miss
  uint32_t from;  //!< remembered side, if a hit follows from it; sideUnknown for other hits
  WalkState next; //!< state if there is no hit, or if it is not accepted
};

CVERT_FUNCTION HitResult hitResult(uint32_t hit, uint32_t from, WalkState next) {
  HitResult result;
  result.hit = hit;
  result.from = from;
  result.next = next;
  return result;
}

/*! State after an accepted hit. */
CVERT_FUNCTION WalkState afterHit(WalkState state) {
  state.found = true;
  state.pending = false;
  return state;
}

/*! The rule for a leaf whose box the ray crosses. */
CVERT_FUNCTION HitResult crossLeaf(WalkState state, LeafEvent leaf) {
  bool crosses = leaf.enter != leaf.leave || leaf.changes;
  bool entersBox = leaf.solid && !leaf.started;

  if (state.found) { // only nearer hits count
    if (leaf.solid || leaf.empty) return hitResult(entersBox ? hitBox : hitNone, sideUnknown, state);
    return hitResult(crosses ? hitRoot : hitNone, sideUnknown, state);
  }

  WalkState next = state;
  if (leaf.solid || leaf.empty) {
    next.side = sideUnknown;
    next.pending = false;
    return hitResult(entersBox ? hitBox : hitNone, sideUnknown, next);
  }
  if (leaf.started) next.fromSurface = leaf.nearEntry;
  next.side = leaf.leave;
  next.pending = leaf.near;

  bool isPastStep = next.fromSurface && !leaf.started && state.side == leaf.leave;
  bool step = !leaf.started && state.side != sideUnknown && state.side != leaf.enter;
  if (step && !isPastStep) return hitResult(hitStep, state.side, next);
  if (crosses) return hitResult(isPastStep ? hitNone : hitRoot, sideUnknown, next);
  if (leaf.near && !leaf.started && !leaf.ended) return hitResult(hitLip, sideUnknown, next);
  return hitResult(hitNone, sideUnknown, next);
}

/*! True if passBox() must be called for boxes that the ray passes. */
CVERT_FUNCTION bool needsPassedBoxes(WalkState state) {
  return state.pending || (state.side == sideUnknown && !state.found);
}

/*! The rule for a box that the ray overlaps in x and y, but passes over (`above`) or under. Requires
 *  needsPassedBoxes(). */
CVERT_FUNCTION HitResult passBox(WalkState state, bool above) {
  WalkState next = state;
  next.side = above ? sideAbove : sideBelow;
  bool step = state.pending && state.side != next.side;
  if (step) next.pending = false;
  return hitResult(step ? hitExit : hitNone, state.side, next);
}

CBVH_END

#endif
