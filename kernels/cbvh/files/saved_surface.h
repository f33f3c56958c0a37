// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../base/codec.h"
#include "../../cvert/file/writer.h"

namespace embree
{
  class CompressibleGeometry;
  struct SurfaceBlocks;

  namespace cbvh
  {
    /*! Prepares a compressed geometry for cvert::FileWriter. The result refers to the blocks. Throws if a part of the
     *  geometry is not compressed. */
    FileSurface savedSurface (const CompressibleGeometry* geometry, const SurfaceBlocks& blocks);
  }
}
