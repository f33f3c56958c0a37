// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A warning for error bounds so large that quads flip, which shows as speckles, or irregular meshes lose detail. */

#include "../base/environment.h"
#include "../embree/scene.h"
#include <atomic>
#include <iostream>

namespace embree::isa {
/*! Spacing, as a fraction of an edge, at which the first quads flip. */
static const double coarseSpacing = 0.5;

/*! Warns on stderr, once per process and instruction set, or in every call if the device or environment is verbose.
 *  spacing, edge: the lattice's spacing and the median edge; averages if each primitive has its own lattice. */
inline void warnIfCoarse(Device* device, double spacing, double edge) {
  static std::atomic<bool> wasReported(false);
  if (!(edge > 0 && spacing >= coarseSpacing * edge)) return;
  const bool isFirst = !wasReported.exchange(true);
  if (!isFirst && !device->verbosity(1) && !environmentRequestsCommitLines()) return;
  Lock<MutexSys> lock(g_printMutex);
  std::cerr << "compression: max_error or maxPixelError selects a spacing of " << spacing << ", " << spacing / edge
            << " times the median edge: pictures may have speckles or lose detail; expected at most " << edge / 36
            << ", 1/36 of the edge" << std::endl;
}
} // namespace embree::isa
