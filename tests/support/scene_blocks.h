// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a committed scene. Reads internal structures of the patched tree from which tests and library are
 * built. */

#include "kernels/cbvh/paper/block.h"
#include "kernels/cvert/format/block.h"
#include <embree3/rtcore.h>

#include <vector>

namespace programs::test {

// The scene must have compressed subdivision surfaces only. Blocks are valid until the next commit.
std::vector<const embree::cbvh::Block*> sceneBlocks(RTCScene scene);

// The same for cVERT and cTILE, whose blocks and tiles have a different layout.
std::vector<const cvert::VertHeader*> sceneVertBlocks(RTCScene scene);

// Returns the ID of the geometry of a block, given the surface number in the block's header.
unsigned geometryOf(RTCScene scene, uint32_t surface);

} // namespace programs::test
