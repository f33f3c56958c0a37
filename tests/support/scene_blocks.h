// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks that a committed scene holds, for tests that compare what the library
 * traces with the reference on the very same bytes. Looks into the library's own
 * structures, which have the layout of the patched tree that both are built from. */

#include "kernels/cbvh/framed/block.h"
#include "kernels/cvert/format/block.h"
#include <embree3/rtcore.h>

#include <vector>


namespace cbvh::test {

// Blocks of a scene of nothing but compressed subdivision surfaces; they live as long
// as its commit.
std::vector<const embree::cbvh::Block*> sceneBlocks(RTCScene scene);

// The same of cVERT, whose blocks have another form.
std::vector<const cvert::VertHeader*> sceneVertBlocks(RTCScene scene);

// ID of the geometry that a block is of, by the number in its header.
unsigned geometryOf(RTCScene scene, uint32_t surface);

} // namespace cbvh::test
