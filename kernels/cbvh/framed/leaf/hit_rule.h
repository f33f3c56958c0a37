// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Where a ray hits the surface of a cLEAF block: the decision alone. How a ray crosses a
 * leaf is measured elsewhere (crossing.h; of decoded leaves: framed/leaf/crossing1.h), and what becomes
 * of a hit, too. docs/formats/framed_hits.md has the rule as tables, which a test compares with this code.
 *
 * Along a ray
 *
 *   f(s) = z of the ray - z of the leaf's patch,
 *
 * taken where the ray enters and leaves the leaf's box (the paper's line test; its root is
 * that of the patch, not of the line). The ray is above where f >= 0, and, as a box holds
 * all of its quads, where it passes the upper face, below where it passes the lower one. It
 * hits where f changes sign, or where it enters and leaves on different sides.
 *
 * Patches of neighbouring groups do not meet exactly, each is off the edge between them by
 * up to half a thickness, and a ray could slip through the step. Therefore the ray
 * remembers on which side it left the last leaf, or passed the last box. It hits
 *
 * - at the entry of a leaf, if it enters on the other side;
 * - where it left a leaf that it was within half a thickness of, if it then passes over (under)
 *   the boxes that come next, but was under (over) that leaf;
 * - a lip at the border of the block, as the neighbour is in another block, which knows
 *   nothing of the ray's side.
 *
 *      surface of A  ____           The encoder keeps both surfaces above the edge that
 *      ---------.....|   ....---    they share, and less than half a thickness. Lips
 *                 lip|---|lip       hang from the border that far down: each reaches the
 *                     edge          edge, so together they close what is between.
 *
 * Why no ray slips through. Inside a block leaves and boxes passed cover the ray's way in x
 * and y without a gap, and every change of the remembered side is a hit: a ray could only
 * get through if the first or the last side that it remembers were wrong. Over its first
 * place in the block the ray is either outside of the box of the quads there, and its side
 * that of the box it passes or of the face by which it enters; or it comes over an edge on
 * the border. Say that it is above that edge (below: the same, mirrored; the patch is above
 * the edge anyway). The patch is there at most half a thickness above the edge. If the ray
 * is below the patch, it is in the lip. If it is above, then f >= 0 there, and the ray
 * leaves the leaf on the upper side, or f changes sign behind, or f changes sign before,
 * which is in the lip unless the ray entered through the lower face: that is why a change
 * of sign is a hit even between equal sides, where the box ends and its patch does not.
 *
 * A ray that starts on the surface of a leaf, within half a thickness, does not hit a step
 * that it is beyond again when it leaves the step's leaf: it would shadow the surface it
 * comes from. A segment that starts (ends) in a leaf, at tnear (tfar), hits it only if f
 * changes sign.
 *
 * The paper takes every ray that meets an interval for a hit, at its near side. That closes
 * the steps too, but thickens the surface: rays along a crest hit what they should pass,
 * hits are early by half a bin, and rays that start on the surface hit it again.
 *
 * Where a surface folds over, leaves overlap and the walk's order is not the ray's: a walk
 * for the closest hit goes on after a hit, and takes nearer changes of sign.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing Subdivision
 * Surfaces with Displacement", 2018, section 4. */

#ifndef CBVH_HIT_RULE_H
#define CBVH_HIT_RULE_H

#include "../../base/language.h"

CBVH_BEGIN

/* sides of the surface, in the frame */
CVERT_CONSTANT uint32_t sideUnknown = 0u, sideBelow = 1u, sideAbove = 2u;

/*! what a ray remembers from leaf to leaf of one block */
struct WalkState
{
  uint32_t side;    //!< on which it left the last leaf, or passed the last box
  bool pending;     //!< it was near the patch of the leaf that it left last, and has not changed its side since
  bool fromSurface; //!< it starts in a leaf, within half a thickness
  bool found;       //!< a hit was accepted
};

CVERT_FUNCTION WalkState startOfWalk ()
{
  WalkState state;
  state.side = sideUnknown;
  state.pending = state.fromSurface = state.found = false;
  return state;
}

/*! how a ray crosses one leaf */
struct LeafEvent
{
  uint32_t enter;   //!< side at the entry
  uint32_t leave;   //!< side at the exit
  bool changes;     //!< f has another sign at the exit than at the entry
  bool nearEntry;   //!< within half a thickness of the patch at the entry
  bool near;        //!< may be so anywhere between entry and exit
  bool started;     //!< the segment starts inside the box, at tnear
  bool ended;       //!< it ends inside, at tfar
  bool solid;       //!< the leaf has no patch, its box is the surface
  bool empty;       //!< the leaf has no surface
};

/* where in a leaf a ray hits */
CVERT_CONSTANT uint32_t hitNone = 0u;
CVERT_CONSTANT uint32_t hitBox  = 1u; //!< at the entry, the box is the surface
CVERT_CONSTANT uint32_t hitStep = 2u; //!< at the entry, behind a step
CVERT_CONSTANT uint32_t hitRoot = 3u; //!< where f changes sign
CVERT_CONSTANT uint32_t hitLip  = 4u; //!< in a lip, if the ray meets one
CVERT_CONSTANT uint32_t hitExit = 5u; //!< where the ray left the leaf before

struct Verdict
{
  uint32_t hit;
  uint32_t from;    //!< side that the ray comes from, as far as that is known from more than this leaf
  WalkState next;   //!< without the hit: none, or not accepted
};

CVERT_FUNCTION Verdict verdict (uint32_t hit, uint32_t from, WalkState next)
{
  Verdict v;
  v.hit = hit;
  v.from = from;
  v.next = next;
  return v;
}

/*! the walk goes on after a hit that was accepted: a nearer one may follow */
CVERT_FUNCTION WalkState afterHit (WalkState state)
{
  state.found = true;
  state.pending = false;
  return state;
}

/*! a ray in a leaf */
CVERT_FUNCTION Verdict crossLeaf (WalkState state, LeafEvent leaf)
{
  bool crosses = leaf.enter != leaf.leave || leaf.changes;
  bool entersBox = leaf.solid && !leaf.started;

  if (state.found) { // of interest where it lies nearer
    if (leaf.solid || leaf.empty) return verdict(entersBox ? hitBox : hitNone,sideUnknown,state);
    return verdict(crosses ? hitRoot : hitNone,sideUnknown,state);
  }

  WalkState next = state;
  if (leaf.solid || leaf.empty) {
    next.side = sideUnknown;
    next.pending = false;
    return verdict(entersBox ? hitBox : hitNone,sideUnknown,next);
  }
  if (leaf.started) next.fromSurface = leaf.nearEntry;
  next.side = leaf.leave;
  next.pending = leaf.near;

  bool beyond = next.fromSurface && !leaf.started && state.side == leaf.leave;
  bool step = !leaf.started && state.side != sideUnknown && state.side != leaf.enter;
  if (step && !beyond) return verdict(hitStep,state.side,next);
  if (crosses) return verdict(beyond ? hitNone : hitRoot,sideUnknown,next);
  if (leaf.near && !leaf.started && !leaf.ended) return verdict(hitLip,sideUnknown,next);
  return verdict(hitNone,sideUnknown,next);
}

/*! whether boxes that a ray passes say anything */
CVERT_FUNCTION bool wantsPassed (WalkState state) { return state.pending || (state.side == sideUnknown && !state.found); }

/*! A ray that passes over (under) a box, sharing its x and y without meeting it; only if
 *  wantsPassed. */
CVERT_FUNCTION Verdict passBox (WalkState state, bool above)
{
  WalkState next = state;
  next.side = above ? sideAbove : sideBelow;
  bool step = state.pending && state.side != next.side;
  if (step) next.pending = false;
  return verdict(step ? hitExit : hitNone,state.side,next);
}

CBVH_END

#endif
