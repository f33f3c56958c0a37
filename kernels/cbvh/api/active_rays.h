// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Used by rtcIntersect8/16 and rtcOccluded8/16 (kernels/upstream/patches/packet-masks.patch). Embree traces packets
 * that are wider than the vectors of the instruction set as ray streams. A stream has no mask: all of its rays with
 * tnear <= tfar are traced, including those that the application's mask excludes. */

#include "../embree/simd.h"

namespace embree
{
  /*! Sets an empty range [tnear,tfar] for the inactive rays of a packet, so that they hit nothing. The destructor
   *  restores their ranges. valid: the application's mask, -1 for active rays. */
  template<typename Packet, int N>
  struct OnlyActiveRays
  {
    OnlyActiveRays (const int* valid, Packet& rays) : valid(valid), rays(rays)
    {
      for (int i=0; i<N; i++) {
        if (valid[i] == -1) continue;
        tnear[i] = rays.tnear[i]; rays.tnear[i] = inf;
        tfar[i] = rays.tfar[i]; rays.tfar[i] = neg_inf;
      }
    }

    ~OnlyActiveRays ()
    {
      for (int i=0; i<N; i++) {
        if (valid[i] == -1) continue;
        rays.tnear[i] = tnear[i];
        rays.tfar[i] = tfar[i];
      }
    }

    const int* valid;
    Packet& rays;
    float tnear[N], tfar[N];
  };
}
