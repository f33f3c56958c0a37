// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces of a file. The tree is read and checked when a surface is loaded, its blocks when rays first reach them
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
    /*! Returns the blocks of geometry i and the tree above them. Throws cvert::Error if the tree or a moving block is
     *  damaged. */
    std::shared_ptr<const SurfaceBlocks> loadSurface (const std::shared_ptr<const cvert::File>& file, Device* device,
                                                      size_t i);

    /*! Reads a whole file. Throws cvert::Error if a checksum differs or a block is damaged. */
    void verifyFile (const cvert::File& file);
  }
}
