// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the environment variable EMBREE_CBVH asks for, in the words of Embree CBVH itself: "max_error=0.001,grids=1,quads=1,triangles=1,verbose", "0" to leave
 * all to Embree. */

#include <embree4/rtcore.h>

namespace interposer {

struct Options
{
  bool isOn = true;
  bool takesGrids = false, takesQuads = false, takesTriangles = false;
  float maxError = -1;         // world units; 0: lossless, negative: as the library chooses

  bool takes(RTCGeometryType type) const;
};

/* Read once. What is no word is told on stderr, and left out. */
const Options& options();

/* One line on stderr, the first time that these words are said. */
void tellOnce(const char* format, ...) __attribute__((format(printf, 1, 2)));

} // namespace interposer
