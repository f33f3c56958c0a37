// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Replaces paper/framed_raysK.h in libraries without the paper's representations (EMBREE_CBVH_NO_PAPER). */

#include "../embree/traversal.h"

namespace embree::isa::cbvh {
template<int K>
struct FramedRaysK {
  __forceinline explicit FramedRaysK(const vfloat<K>&) {}
  __forceinline void setEntryT(const vfloat<K>&) {}
  template<typename Rays>
  __forceinline vbool<K> intersect(const vbool<K>&, Rays&, IntersectContext*, const void*) {
    return vbool<K>(false);
  }
  __forceinline void setFinalTfar(const vbool<K>&, vfloat<K>&) const {}
};
} // namespace embree::isa::cbvh
