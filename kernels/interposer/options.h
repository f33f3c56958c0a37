// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Settings of the environment variable EMBREE_CBVH, with the syntax and the meaning that they have for libembree3 of
 * this project: "1,max_error=0.001,triangles=0,verbose". Without "1" or the name of a representation, everything is
 * left to Embree. All representations count as "1". Settings of the paper's representations, with any value, and
 * release_input have no effect. */

#include <embree4/rtcore.h>

namespace interposer {

struct Options {
  bool isOn = false;
  bool isVerbose = false;
  bool compressesGrids = true, compressesQuads = true, compressesTriangles = true;
  float maxError = -1; // world units; 0: lossless; negative: the library's default

  /* True if geometry of this type is compressed when isOn. Subdivision geometry always is. */
  bool compresses(RTCGeometryType type) const;
};

/* Read once. Invalid items are reported on stderr and turn compression off. */
const Options& options();

/* Prints a line to stderr, unless it was printed before. Thread-safe. Throws nothing. */
void warnOnce(const char* format, ...) __attribute__((format(printf, 1, 2)));

/* If verbose, prints why geometry is left to Embree. geometry: for example "a grid geometry". Prints a single line for
 * reasons that differ only in numbers. Thread-safe. Throws nothing. */
void reportLeftToEmbree(const char* geometry, const char* reason);

} // namespace interposer
