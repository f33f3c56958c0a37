// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../paper/block.h"
#include "../base/codec_names.h"
#include "../base/primitive_type.h"
#include "../../cvert/format/mesh_block.h"
#include "../../cvert/format/motion.h"

namespace embree::cbvh {
/*! Size of a block, without the bytes after it that decoders may read. */
inline uint32_t bytesOfBlock(const void* block, BlockFormat format) {
  switch (format) {
  case VERT_FORMAT: return vertBytes((const VertHeader*)block);
  case MESH_FORMAT: return ((const MeshHeader*)block)->bytes;
  default: return uint32_t(((const Block*)block)->layout().bytes);
  }
}

/*! Offset of the surface number (base/surface_ids.h) in a block, in bytes. */
inline uint32_t offsetOfSurface(BlockFormat format) {
  static_assert(offsetof(MeshHeader, surface) == offsetof(VertHeader, surface), "same offset in both headers");
  return format == FRAMED_FORMAT ? uint32_t(offsetof(BlockHeader, surface)) : uint32_t(offsetof(VertHeader, surface));
}
} // namespace embree::cbvh
