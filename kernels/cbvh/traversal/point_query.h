// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/traversal.h"

namespace embree::isa::cbvh {
/*! Runs a point query over a scene's tree of static, or moving, compressed surfaces. bvh: a CompressedTree. Skips
 *  cages, as Embree does. Returns true if a call of the application's function returned true, because it changed
 *  the query. */
bool queryPoint(const BVH4* bvh, PointQuery* query, PointQueryContext* context);
} // namespace embree::isa::cbvh
