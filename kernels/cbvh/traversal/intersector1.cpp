// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Single-ray intersectors, instantiated for one instruction set. */

#include "compressed_intersector1.h"

namespace embree::isa {
DEFINE_INTERSECTOR1(BVH4CompressedSubdivIntersector1, CompressedSubdivTraversal1);
DEFINE_INTERSECTOR1(BVH4CompressedMotionIntersector1, CompressedMotionTraversal1);
} // namespace embree::isa
