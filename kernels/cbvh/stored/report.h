// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface_blocks.h"
#include <string>
#include <vector>

namespace embree
{
  /*! what a build leaves behind besides its BVH */
  struct CompressionReport
  {
    std::vector<std::shared_ptr<const SurfaceBlocks>> surfaces; //!< whose parts the BVH is made of
    RTCCompressionStatistics statistics = RTCCompressionStatistics();
    std::vector<std::string> errors; //!< that did not stop it, for reportBuildErrors
    MutexSys mutex;                  //!< of errors, which any thread that joins a commit may fetch

    void clear ()
    {
      surfaces.clear();
      statistics = RTCCompressionStatistics();
      Lock<MutexSys> lock(mutex);
      errors.clear();
    }
  };
}
