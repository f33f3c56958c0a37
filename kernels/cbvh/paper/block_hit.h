// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts a hit in a leaf of cLEAF or cVOXEL to what Embree reports: face parameters, distance and normal. (cGRID uses
 * Embree's triangle test.) `Real` is float, or a vector with one ray of a packet per lane. Both compute the same bits:
 * every product in a sum is explicitly fused or not. */

#include "local_ray4.h"
#include "normal.h"

namespace embree::isa::cbvh {
/*! A hit in the frame. */
template<typename Real, typename Bool>
struct LeafHit {
  Real s;                    //!< parameter along the segment, see local_ray.h
  Real u, v;                 //!< position in the leaf's box, 0 to 1
  Real slopeX, slopeY;       //!< slopes of the surface, dz/dx and dz/dy
  Bool fromAbove, fromBelow; //!< remembered side (HitResult::from); none is set if the hit does not depend on it
};

/*! The part of a ray in a block's box. */
template<typename Real>
struct HitSegment {
  Real P[3], D[3];     //!< start and direction of the segment in the frame
  Real t0, t1, w0, w1; //!< see LocalRay
  Real dir[3];         //!< see RayState
  Real scale, rcpDir2; //!< the same
  Real tnear, tfar;    //!< of the ray before any hit
  Real entryT;         //!< lower bound of the distance at which the ray enters the block's bounds

  /*! Distance of a hit along the application's ray, between tnear and tfar. */
  __forceinline Real distanceAt(const Real& s) const {
    const Real sw = product(s, w0);
    const Real divisor = fused(w1, Real(Real(1.0f) - s), sw); // 0 only in lanes of rays without a hit
    return min(max(fused(Real(sw / nonZero(divisor)), Real(t1 - t0), t0) * scale, tnear), tfar);
  }

  /*! Distance by which NearestHit compares a hit at distance `hitT`. */
  __forceinline Real comparedT(const Real& hitT) const { return min(max(hitT, entryT), tfar); }
};

/*! A hit as Embree reports it. */
template<typename Real>
struct BlockHit {
  Real u, v, t;
  Vec3<Real> Ng;
};

template<typename Real, typename Bool>
class HitConverter {
public:
  __forceinline HitConverter(const Block* block, const BlockLayout& layout)
    : block(block),
      leafSize(float(1u << block->height()) / float(layout.leavesPerSide)) {}

  /*! leaf: index in Morton order. t: distance to report. */
  __forceinline BlockHit<Real> convert(const HitSegment<Real>& ray, uint32_t leaf, const LeafHit<Real, Bool>& at,
                                       const Real& t) const {
    BlockHit<Real> hit;
    hit.u = block->faceU(Real(leafSize) * (Real(float(mortonX(leaf))) + at.u));
    hit.v = block->faceV(Real(leafSize) * (Real(float(mortonY(leaf))) + at.v));
    hit.t = t;
    setNormal(ray, at, hit.Ng);
    return hit;
  }

private:
  /*! Sets the world-space unit normal, mirrored if necessary, see normal.h. */
  __forceinline void setNormal(const HitSegment<Real>& ray, const LeafHit<Real, Bool>& at, Vec3<Real>& Ng) const {
    Real p[3], n[3];
    for (int k = 0; k < 3; k++) p[k] = fused(at.s, ray.D[k], ray.P[k]);
    const Real level = fusedNegative(at.slopeY, p[1], fusedNegative(at.slopeX, p[0], p[2]));
    for (int k = 0; k < 3; k++) {
      const float* column = block->columns[k];
      n[k] = fusedNegative(
          level, Real(column[3]),
          fusedNegative(at.slopeY, Real(column[1]), fusedNegative(at.slopeX, Real(column[0]), Real(column[2]))));
    }
    /* scaled first: squares would overflow in blocks smaller than 1e-19; the limits avoid divisions by 0 */
    const Real largest = max(max(abs(n[0]), abs(n[1])), abs(n[2])), toUnit = Real(1.0f) / max(largest, Real(1e-37f));
    for (int k = 0; k < 3; k++) n[k] = n[k] * toUnit;
    const Real length2 = dotOf(n, n), along = dotOf(n, ray.dir);
    const Bool away = (at.fromAbove & (along > Real(0.0f))) | (at.fromBelow & (along < Real(0.0f)));
    const Bool isMirrored = away & (along * along * ray.rcpDir2 < Real(mirroredSine2) * length2);
    const Real mirroring = select(isMirrored, Real(2.0f) * along * ray.rcpDir2, Real(zero)),
               rcpLength = Real(1.0f) / sqrt(max(length2, Real(1e-30f)));
    for (int k = 0; k < 3; k++) n[k] = fusedNegative(mirroring, ray.dir[k], n[k]) * rcpLength;
    Ng = Vec3<Real>(n[0], n[1], n[2]);
  }

  static __forceinline Real dotOf(const Real a[3], const Real b[3]) {
    return fused(a[0], b[0], fused(a[1], b[1], product(a[2], b[2])));
  }

  const Block* block;
  const float leafSize; //!< side of a leaf, in quads
};
} // namespace embree::isa::cbvh
