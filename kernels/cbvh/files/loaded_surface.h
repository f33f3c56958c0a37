// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces of a file. Loading reads and checks the tree; blocks are checked when rays first reach them
 * (mapped_blocks.h). */

#include "../base/codec.h"
#include "../../cvert/file/file.h"
#include <memory>

namespace embree
{
  class Device;
  struct SurfaceBlocks;

  namespace cbvh
  {
    /*! Throws cvert::Error if the geometry's tree or a moving block is damaged. */
    std::shared_ptr<const SurfaceBlocks> loadSurface (const std::shared_ptr<const cvert::File>& file, Device* device,
                                                      size_t i);

    /*! Reads the whole file. Throws cvert::Error if a checksum differs or a block is damaged. */
    void verifyFile (const cvert::File& file);
  }
}
