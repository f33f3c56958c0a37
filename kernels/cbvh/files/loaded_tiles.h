// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"

namespace embree {
struct SurfaceBlocks;

namespace cbvh {
/*! True if surfaces that the device loads become tiles where they can: if cTILE is its representation. */
bool makesTilesOfFiles(const Device* device);

/*! Replaces the blocks of a loaded surface at rest by tiles, in parallel; those that tiles do not support, and damaged
 *  ones, remain. Reads all blocks of the file. surface: with its tree or list of blocks, without other parts. root: of
 *  its tree; emptyNode for a list. Throws std::bad_alloc, or rtcore_error if the memory monitor refuses. */
void makeTiles(Device* device, SurfaceBlocks& surface, BVH4::NodeRef& root);
} // namespace cbvh
} // namespace embree
