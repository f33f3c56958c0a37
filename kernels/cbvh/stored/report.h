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
    cbvh::CompressionStatistics statistics;
    std::vector<std::string> errors; //!< that did not stop it, for reportBuildErrors
    MutexSys mutex;                  //!< of errors, which any thread that joins a commit may fetch

    void clear ()
    {
      surfaces.clear();
      statistics = cbvh::CompressionStatistics();
      Lock<MutexSys> lock(mutex);
      errors.clear();
    }
  };

  /*! Accelerator of a scene: either of its compressed surfaces that move, or of its subdivision surfaces that do not
   *  move, if at least one is compressed. */
  struct CompressedAccel : public AccelInstance
  {
    CompressedAccel (AccelData* accel, Builder* builder, Intersectors& intersectors, CompressionReport* report,
        bool moves)
      : AccelInstance(accel,builder,intersectors), report(report), moves(moves) {}

    std::unique_ptr<CompressionReport> report; //!< of the last build
    const bool moves;
  };
}
