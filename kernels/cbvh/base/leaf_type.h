// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Types of leaves of a scene's BVH4s, one over static and one over moving surfaces (blocks/compressed_tree.h):
 * BlockType, or one of Embree's types, so that a tree can contain blocks and uncompressed patches. Embree's references
 * have 3 bits for the type. */

#include "codec_names.h"
#include "../../cvert/format/block_type.h"
#include <cstddef>

/* For the rest of each source that includes this header: a switch over BlockType that forgets a type does not compile.
 */
#pragma GCC diagnostic error "-Wswitch"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Embree's types: inner leaves and root of a GridSOA. */
enum : uint32_t { GRID_SOA_QUADS = 0, GRID_SOA_ROOT = 1 };

/*! True if the type of a leaf is a BlockType. */
constexpr bool isBlock(std::size_t type) { return type >= FRAMED_BLOCK; }
}} // namespace embree::cbvh::CBVH_ISA
