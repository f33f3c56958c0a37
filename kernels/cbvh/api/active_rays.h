// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* For rtcIntersect8/16 and rtcOccluded8/16 (kernels/upstream/patches/packet-masks.patch). Embree traces packets that
 * are wider than the instruction set's vectors as ray streams, which have no mask. */

#include "../embree/simd.h"

namespace embree {
/*! Gives the inactive rays of a packet an empty range [tnear,tfar], so that they hit nothing, until the destructor
 *  restores it. valid: the application's mask, -1 for active rays. */
template<typename Packet, int N>
struct OnlyActiveRays {
  OnlyActiveRays(const int* valid, Packet& rays) : valid(valid), rays(rays) {
    for (int i = 0; i < N; i++) {
      if (valid[i] == -1) continue;
      tnear[i] = rays.tnear[i];
      rays.tnear[i] = inf;
      tfar[i] = rays.tfar[i];
      rays.tfar[i] = neg_inf;
    }
  }

  ~OnlyActiveRays() {
    for (int i = 0; i < N; i++) {
      if (valid[i] == -1) continue;
      rays.tnear[i] = tnear[i];
      rays.tfar[i] = tfar[i];
    }
  }

  const int* valid;
  Packet& rays;
  float tnear[N], tfar[N];
};
} // namespace embree
