// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Packets that are wider than the instruction set go as a stream, which traces every ray that has
 * tnear <= tfar and knows of no mask. */

#include "../embree/simd.h"

namespace embree
{
  /*! Until this ends, rays of a packet that its mask switches off have no such range. */
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
