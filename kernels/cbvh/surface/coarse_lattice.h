// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A warning for error bounds so large that quads flip, which shows as speckles, or irregular meshes lose detail. */

#include "../base/environment.h"
#include "../embree/scene.h"
#include <atomic>
#include <cmath>
#include <iostream>
#include <limits>

namespace embree::isa {
/*! Spacing, as a fraction of an edge, at which the first quads flip. */
static const double coarseSpacing = 0.5;

/*! Exponent of the lowest bit that is set in a number: the number is on all lattices of at most this exponent. The
 *  largest int for 0, and for numbers that are not finite, which no lattice moves. */
inline int exponentOfLowestBit(float x) {
  if (x == 0.0f || !std::isfinite(x)) return std::numeric_limits<int>::max();
  int exponent;
  const int mantissa = int(std::ldexp(std::frexp(x, &exponent), 24));
  return exponent - 24 + __builtin_ctz(unsigned(mantissa));
}

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
