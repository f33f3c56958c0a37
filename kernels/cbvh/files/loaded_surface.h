// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Loads surfaces from a file, and verifies files. Blocks stay in the mapped file. Loading reads and checks the tree and
 * moving blocks. Other blocks are checked before their first use (mapped_blocks.h). */

#include "../base/codec_names.h"
#include "../../cvert/file/file.h"
#include <memory>

namespace embree {
class Device;
struct SurfaceBlocks;

namespace cbvh {
/*! Loads geometry i, which must exist. Never null. Throws std::bad_alloc, rtcore_error if the memory monitor
 *  refuses, or cvert::Error if its tree or a moving block is damaged or this library does not support its blocks.
 *  The result keeps the file mapped. If another surface has the geometry's surface number, blocks are copied when
 *  they are checked. */
std::shared_ptr<const SurfaceBlocks> loadSurface(const std::shared_ptr<const cvert::File>& file, Device* device,
                                                 size_t i);

/*! Reads the whole file. Throws cvert::Error if a checksum differs, or a tree or block is damaged or
 *  not supported. */
void verifyFile(const cvert::File& file);
} // namespace cbvh
} // namespace embree
