// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Loads the surfaces of a file, for core/files.h. Loading reads and checks trees and moving blocks. Other blocks stay
 * in the mapped file, and are checked when rays first reach them (mapped_blocks.h). */

#include "../base/codec_names.h"
#include "../../cvert/file/file.h"
#include <memory>

namespace embree
{
  class Device;
  struct SurfaceBlocks;

  namespace cbvh
  {
    /*! Loads geometry i. Throws cvert::Error if its tree or a moving block is damaged. The result keeps the file
     *  mapped. */
    std::shared_ptr<const SurfaceBlocks> loadSurface (const std::shared_ptr<const cvert::File>& file, Device* device,
                                                      size_t i);

    /*! Reads the whole file. Throws cvert::Error if a checksum differs or a block is damaged. */
    void verifyFile (const cvert::File& file);
  }
}
