// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Settings of the environment variable EMBREE_CBVH, in the same syntax as for libembree3 of this project:
 * "max_error=0.001,grids=1,quads=1,triangles=1,verbose", or "0" to leave everything to Embree. If the variable is
 * unset, the defaults below apply. Names of the paper's representations count as "1". Their settings, with any value,
 * and release_input have no effect. */

#include <embree4/rtcore.h>

namespace interposer {

struct Options {
  bool isOn = true;
  bool compressesGrids = false, compressesQuads = false, compressesTriangles = false;
  float maxError = -1; // world units; 0: lossless; negative: the library's default

  /* True if geometry of this type is compressed when isOn. Subdivision geometry always is. */
  bool compresses(RTCGeometryType type) const;
};

/* Read once. Invalid items are reported on stderr and turn compression off. */
const Options& options();

/* Prints a line to stderr, unless it was printed before. Thread-safe. Throws nothing. */
void warnOnce(const char* format, ...) __attribute__((format(printf, 1, 2)));

} // namespace interposer
