// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A ray in the frame of a block.
 *
 * The projective map takes the part of the ray inside the block's box to a
 * segment P(s) = P0 + s (P1-P0), s in [0,1]. All of traversal happens in s; the
 * world parameter follows exactly from W at the two ends:
 *
 *   tau(s) = s w0 / (w1 (1-s) + s w0),   t = t0 + tau (t1-t0)
 *
 * Numerics. The ray is first moved to its point nearest to the block's centre,
 * relative to that centre; what is lost there is a few ulps of the distance
 * between ray origin and block, as in any float ray tracer, and as many of the block's
 * own size: O and D are rounded by 3/2 ulps of their terms, and from the centre no point
 * of the box is much farther than its longest side. That loss, times the map's stretch of each axis and
 * of W, plus a few ulps of 1, all over W, is the vector "epsilon" by which the traversal
 * widens every bound, axis by axis: neighbouring blocks see the same ray displaced by
 * less than their epsilons, so no ray slips between them. */

#include "block.h"
#include "../common/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      using namespace embree::cbvh;

      /*! per ray: direction scaled to a largest component of 1, so that directions
       *  of length 1e-20 or 1e20 have a square */
      struct RayPrecalculations
      {
        Vec3fa org, dir;
        float scale;    //!< t = t' * scale, t' along dir
        float rcpScale;
        float rcpDir2;  //!< 1/dot(dir,dir)
        float scaledTnear; //!< tnear in t'

        __forceinline RayPrecalculations (const Ray& ray)
        {
          const Vec3fa d = ray.dir;
          rcpScale = reduce_max(abs(d));
          scale = 1.0f/rcpScale;
          dir = d*scale;
          org = ray.org;
          rcpDir2 = 1.0f/dot(dir,dir);
          scaledTnear = max(ray.tnear(),0.0f)*rcpScale;
        }
      };

      struct LocalRay
      {
        /*! lanes: x, y, z (lane 3 is W, undefined after division) */
        vfloat4 P0, P1;
        vfloat4 epsilon;
        float t0, t1;     //!< world parameter of the segment's ends, in t'
        float w0, w1;
        bool startClipped; //!< the segment starts at tnear, inside the box
        bool endClipped;   //!< the segment ends at tfar, inside the box

        /*! false if the ray misses the block's box between tnear and tfar */
        __forceinline bool init (const RayPrecalculations& pre, const Block* block, float tfar)
        {
          const vfloat4 cx = vfloat4::load(block->columns[0]);
          const vfloat4 cy = vfloat4::load(block->columns[1]);
          const vfloat4 cz = vfloat4::load(block->columns[2]);
          const Vec3fa o = pre.org - Vec3fa(block->centre[0],block->centre[1],block->centre[2]);

          /* move to the point nearest to the centre */
          const float tref = -dot(o,pre.dir)*pre.rcpDir2;
          const Vec3fa p = o + tref*pre.dir;
          const vfloat4 O = madd(vfloat4(p.x),cx,madd(vfloat4(p.y),cy,madd(vfloat4(p.z),cz,vfloat4(0.5f,0.5f,0.5f,1.0f))));
          const vfloat4 D = madd(vfloat4(pre.dir.x),cx,madd(vfloat4(pre.dir.y),cy,vfloat4(pre.dir.z)*cz));
          const vfloat4 stretch = abs(cx)+abs(cy)+abs(cz);
          const vfloat4 size = vfloat4(1.0f)/stretch; // of the box
          const float reach = reduce_max(abs(o)) + 0.75f*max(max(size[0],size[1]),size[2]);
          epsilon = madd(vfloat4(4.0f*float(ulp)*reach),stretch+shuffle<3>(stretch),vfloat4(8.0f*float(ulp)));

          /* clip to X >= 0 and W-X >= 0, and so on: linear in the parameter */
          const vfloat4 W = shuffle<3>(O), DW = shuffle<3>(D);
          const vfloat4 a0 = O + epsilon, a1 = (W - O) + epsilon, d1 = DW - D;
          const vfloat4 zero4 = vfloat4(zero);
          const vfloat4 r0 = -a0/D, r1 = -a1/d1;
          const vbool4 xyz = vbool4(true,true,true,false);
          const vbool4 in0 = xyz & (D > zero4), out0 = xyz & (D < zero4);
          const vbool4 in1 = xyz & (d1 > zero4), out1 = xyz & (d1 < zero4);
          const vfloat4 enter = max(select(in0,r0,vfloat4(neg_inf)),select(in1,r1,vfloat4(neg_inf)));
          const vfloat4 leave = min(select(out0,r0,vfloat4(pos_inf)),select(out1,r1,vfloat4(pos_inf)));
          const vbool4 outside = xyz & (((D == zero4) & (a0 < zero4)) | ((d1 == zero4) & (a1 < zero4)));
          const float tauIn  = reduce_max(enter), tauOut = reduce_min(leave);
          const float tauNear = pre.scaledTnear - tref, tauFar = tfar*pre.rcpScale - tref;
          const float tau0 = max(tauIn,tauNear), tau1 = min(tauOut,tauFar);
          if (any(outside) || !(tau0 <= tau1)) return false;
          startClipped = tauNear > tauIn;
          endClipped = tauFar < tauOut;

          const vfloat4 h0 = madd(vfloat4(tau0),D,O), h1 = madd(vfloat4(tau1),D,O);
          w0 = h0[3]; w1 = h1[3];
          epsilon = epsilon/vfloat4(min(w0,w1));
          P0 = h0/vfloat4(w0); P1 = h1/vfloat4(w1);
          t0 = tref + tau0; t1 = tref + tau1;
          return w0 > 0.0f && w1 > 0.0f;
        }

        /*! world parameter of s, between the segment's ends */
        __forceinline float worldT (const RayPrecalculations& pre, float s) const
        {
          const float sw = s*w0;
          const float tau = sw/(w1*(1.0f-s) + sw);
          return (t0 + tau*(t1-t0))*pre.scale;
        }

        /*! s of a world parameter: the inverse */
        __forceinline float localS (const RayPrecalculations& pre, float t) const
        {
          if (!(t1 > t0)) return 1.0f;
          const float tau = (t*pre.rcpScale - t0)/(t1-t0);
          const float tw = tau*w1;
          return tw/(w0*(1.0f-tau) + tw);
        }
      };
    }
  }
}
