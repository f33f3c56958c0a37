// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* local_ray.h for single rays on the CPU. The lanes of vectors are axes. */

#include "local_ray.h"
#include "nearest_hit.h"
#include "../base/vectors.h"
#include "../embree/traversal.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! A ray, and its nearest hit in blocks with frames. The largest component of the direction is scaled to 1, so
 *  that squares neither overflow nor underflow. t' is the distance along the scaled direction, t the distance
 *  along the application's. If no component exceeds 2^-128, `scale` is infinite or NaN and the ray misses all
 *  blocks, as with cVERT. */
struct RayState {
  Vec3fa org, dir;
  float scale;       //!< t = t' * scale
  float rcpScale;    //!< t' = t * rcpScale
  float rcpDir2;     //!< 1/(dir.dir)
  float scaledTnear; //!< tnear as t'
  float tfar;        //!< before any hit
  float entryT;      //!< lower bound of the distance to the block's bounds
  mutable NearestHit nearest;

  bool isSet;

  /*! set() must be called before the first block; many rays visit none. */
  __forceinline explicit RayState(float tfar) : tfar(tfar), entryT(neg_inf), isSet(false) {}
  __forceinline explicit RayState(const Ray& ray) : tfar(ray.tfar), entryT(neg_inf), isSet(false) { set(ray); }

  __forceinline void set(const Ray& ray) {
    if (likely(isSet)) return;
    isSet = true;
    const Vec3fa d = ray.dir;
    rcpScale = reduce_max(abs(d));
    scale = 1.0f / nonZero(rcpScale);
    dir = d * scale;
    org = ray.org;
    rcpDir2 = 1.0f / dot(dir, dir);
    scaledTnear = product(max(ray.tnear(), 0.0f), rcpScale);
  }
};

/*! Stretch of a block's map from world space to the frame, for LocalRay::epsilon. */
struct BlockStretch {
  vfloat4 withW; //!< stretch of x, y and z, each plus the stretch of W
  float longest; //!< approximate largest extent of the box, in world space

  __forceinline BlockStretch(const vfloat4& cx, const vfloat4& cy, const vfloat4& cz) {
    const vfloat4 stretch = abs(cx) + abs(cy) + abs(cz), size = vfloat4(1.0f) / withoutFourth(stretch);
    withW = stretch + shuffle<3>(stretch);
    longest = max(max(size[0], size[1]), size[2]);
  }
};

/*! Returns s at distance t along the scaled direction, at most 1. */
__forceinline float localParameter(float t0, float t1, float w0, float w1, float t) {
  return t < t1 ? localFraction(w0, w1, (t - t0) / nonZero(t1 - t0)) : 1.0f;
}

/*! Bound of the error of localParameter(). */
static const float slackOfS = 1e-5f;

/*! See Segment. Products in sums are explicitly fused or not, so that packets compute the same bits. */
struct LocalRay {
  vfloat4 P0, P1;    //!< both ends in the frame; lane 3 is undefined
  vfloat4 epsilon;   //!< see local_ray.h; lane 3 is undefined
  float t0, t1;      //!< ends of the segment, as t'
  float w0, w1;      //!< W at both ends
  bool startClipped; //!< see Segment
  bool endClipped;

  /*! Returns false if the ray misses the block's box between tnear and `nearestT`, the distance of its nearest
   *  hit. The segment does not depend on `nearestT`, so that results do not depend on the order of blocks. */
  __forceinline bool init(const RayState& state, const Block* block, float nearestT) {
    const vfloat4 cx = vfloat4::load(block->columns[0]);
    const vfloat4 cy = vfloat4::load(block->columns[1]);
    const vfloat4 cz = vfloat4::load(block->columns[2]);
    const Vec3fa o = state.org - Vec3fa(block->center[0], block->center[1], block->center[2]);

    const float tref = -dot(o, state.dir) * state.rcpDir2;
    const Vec3fa p = madd(Vec3fa(tref), state.dir, o);
    const vfloat4 O =
        madd(vfloat4(p.x), cx, madd(vfloat4(p.y), cy, madd(vfloat4(p.z), cz, vfloat4(0.5f, 0.5f, 0.5f, 1.0f))));
    const vfloat4 D = madd(vfloat4(state.dir.x), cx, madd(vfloat4(state.dir.y), cy, vfloat4(state.dir.z) * cz));
    const BlockStretch stretch(cx, cy, cz);
    const float farthest = fused(relativeBoxRadius, stretch.longest, reduce_max(abs(o)));
    epsilon = madd(vfloat4(distanceUlps * floatUlp * farthest), stretch.withW, vfloat4(unitUlps * floatUlp));

    Clip clip(O, D, epsilon);
    const float tauNear = state.scaledTnear - tref, tauFar = fused(state.tfar, state.rcpScale, -tref);
    const float tau0 = max(clip.tauIn, tauNear), tau1 = min(clip.tauOut, tauFar);
    if (clip.outside || !(tau0 <= min(tau1, fused(nearestT, state.rcpScale, -tref)))) return false;
    startClipped = tauNear > clip.tauIn;
    endClipped = tauFar < clip.tauOut;

    const vfloat4 h0 = madd(vfloat4(tau0), D, O), h1 = madd(vfloat4(tau1), D, O);
    w0 = h0[3];
    w1 = h1[3];
    if (unlikely(!(w0 > 0.0f && w1 > 0.0f))) return false;
    epsilon = epsilon / vfloat4(min(w0, w1));
    P0 = h0 / vfloat4(w0);
    P1 = h1 / vfloat4(w1);
    t0 = tref + tau0;
    t1 = tref + tau1;
    return true;
  }

  /*! Returns an s not before distance t along the application's ray, despite rounding. */
  __forceinline float parameterAfter(float rcpScale, float t) const {
    return localParameter(t0, t1, w0, w1, product(t, rcpScale)) + slackOfS;
  }

private:
  /*! Range of the ray inside of the box, widened by epsilon. It is empty if tauIn > tauOut, or if `outside` is
   *  set: the ray is parallel to a side and beyond it. */
  struct Clip {
    float tauIn, tauOut;
    bool outside;

    __forceinline Clip(const vfloat4& O, const vfloat4& D, const vfloat4& epsilon) {
      const vfloat4 W = shuffle<3>(O), DW = shuffle<3>(D);
      const vfloat4 a0 = O + epsilon, a1 = (W - O) + epsilon, d1 = DW - D;
      const vfloat4 zero4 = vfloat4(zero);
      const vfloat4 r0 = -a0 / nonZero(D), r1 = -a1 / nonZero(d1);
      const vbool4 xyz = vbool4(true, true, true, false);
      const vbool4 in0 = xyz & (D > zero4), out0 = xyz & (D < zero4);
      const vbool4 in1 = xyz & (d1 > zero4), out1 = xyz & (d1 < zero4);
      const vfloat4 enter = max(select(in0, r0, vfloat4(neg_inf)), select(in1, r1, vfloat4(neg_inf)));
      const vfloat4 leave = min(select(out0, r0, vfloat4(pos_inf)), select(out1, r1, vfloat4(pos_inf)));
      outside = any(xyz & (((D == zero4) & (a0 < zero4)) | ((d1 == zero4) & (a1 < zero4))));
      tauIn = reduce_max(enter);
      tauOut = reduce_min(leave);
    }
  };
};
} // namespace embree::isa::cbvh
