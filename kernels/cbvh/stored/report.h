// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface_blocks.h"
#include <string>
#include <vector>

namespace embree
{
  /*! Results of a build other than its BVH. */
  struct CompressionReport
  {
    std::vector<std::shared_ptr<const SurfaceBlocks>> surfaces; //!< whose parts are in the BVH
    cbvh::CompressionStatistics statistics;
    std::vector<std::string> errors; //!< that did not stop the build
    MutexSys mutex;                  //!< protects errors, which any thread that joins a commit may read

    void clear ()
    {
      surfaces.clear();
      statistics = cbvh::CompressionStatistics();
      Lock<MutexSys> lock(mutex);
      errors.clear();
    }
  };

  /*! Accelerator for the moving compressed surfaces of a scene, or for its static subdivision surfaces if one of them
   *  is compressed. */
  struct CompressedAccel : public AccelInstance
  {
    CompressedAccel (AccelData* accel, Builder* builder, Intersectors& intersectors, CompressionReport* report,
        bool moves)
      : AccelInstance(accel,builder,intersectors), report(report), moves(moves) {}

    std::unique_ptr<CompressionReport> report; //!< report of the last build
    const bool moves;
  };
}
