// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The result of a build of a scene, and the acceleration structure that owns it. */

#include "surface_blocks.h"
#include <string>
#include <vector>

namespace embree {
/*! Results of a build other than its BVH. */
struct CompressionReport {
  std::vector<std::shared_ptr<const SurfaceBlocks>> surfaces; //!< surfaces whose blocks are in the BVH
  cbvh::CompressionStatistics statistics;

  void clear() {
    surfaces.clear();
    statistics = cbvh::CompressionStatistics();
    takeErrors();
  }

  /*! Adds an error that does not stop the build. Thread-safe. */
  void addError(const std::string& error) {
    Lock<MutexSys> lock(mutex);
    errors.push_back(error);
  }

  /*! Returns the errors and removes them. Thread-safe: any thread that joins a commit calls this function. */
  std::vector<std::string> takeErrors() {
    std::vector<std::string> taken;
    Lock<MutexSys> lock(mutex);
    taken.swap(errors);
    return taken;
  }

private:
  std::vector<std::string> errors;
  MutexSys mutex; //!< protects errors
};

/*! A scene's acceleration structure with a CompressedTree (compressed_tree.h). */
struct CompressedAccel : public AccelInstance {
  CompressedAccel(AccelData* accel, Builder* builder, Intersectors& intersectors, CompressionReport* report, bool moves,
                  bool isNextToGrid)
    : AccelInstance(accel, builder, intersectors),
      report(report),
      moves(moves),
      isNextToGrid(isNextToGrid) {}

  std::unique_ptr<CompressionReport> report; //!< report of the last build
  const bool moves;
  const bool isNextToGrid; //!< the scene also got Embree's own structure for moving subdivision surfaces
};

/*! Returns the scene's structure for static or moving geometry, or null if there is none. */
inline const CompressedAccel* findCompressedAccel(const Scene* scene, bool moves) {
  for (const Accel* accel : scene->accels) {
    const CompressedAccel* const compressed = dynamic_cast<const CompressedAccel*>(accel);
    if (compressed && compressed->moves == moves) return compressed;
  }
  return nullptr;
}
} // namespace embree
