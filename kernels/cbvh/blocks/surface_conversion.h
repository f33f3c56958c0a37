// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The same surface in another form: its cVERT blocks as tiles, or its tiles as cVERT blocks, with the same vertices. */

#include "../base/leaf_type.h"
#include "surface_blocks.h"
#include <functional>

namespace embree::cbvh {
/*! True if a surface is exact and has blocks of which there are two forms. */
bool isConvertible(const SurfaceBlocks& surface);

/*! Converts a surface for which isConvertible() holds, in parallel. Blocks that tiles do not support stay as they are:
 *  those of a mapped file, including damaged ones, remain there, others are copied. A surface of a file that was
 *  converted to tiles returns to the file. form: TILE_BLOCK or VERT_BLOCK. progress: called by many threads; may throw
 *  to cancel. Throws std::bad_alloc, or rtcore_error if the memory monitor refuses. */
std::shared_ptr<const SurfaceBlocks> convertSurface(Device* device, const std::shared_ptr<const SurfaceBlocks>& from,
                                                    BlockType form, const std::function<void()>& progress);

/*! TILE_BLOCK if some of the surface's blocks are tiles, otherwise VERT_BLOCK. */
inline BlockType formOf(const SurfaceBlocks& surface) {
  return surface.types >> TILE_BLOCK & 1u ? TILE_BLOCK : VERT_BLOCK;
}
inline BlockType otherForm(BlockType form) { return form == TILE_BLOCK ? VERT_BLOCK : TILE_BLOCK; }

/*! Estimates SurfaceBlocks::bytes() of a convertible surface in its other form: the first call from a sample of its
 *  blocks. Returns bytes() if none of these has another form. Thread-safe. */
size_t bytesInOtherForm(Device* device, const SurfaceBlocks& surface);
} // namespace embree::cbvh
