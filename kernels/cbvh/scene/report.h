// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include "../../../include/embree3/rtcore_compression.h"
#include <string>
#include <vector>

namespace embree
{
  /*! what a build leaves behind besides its BVH */
  struct CompressionReport
  {
    RTCCompressionStatistics statistics = RTCCompressionStatistics();
    std::vector<std::string> errors; //!< that did not stop it, for reportBuildErrors
    MutexSys mutex;                  //!< of errors, which any thread that joins a commit may fetch
  };
}
