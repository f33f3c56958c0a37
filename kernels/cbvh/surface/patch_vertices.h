// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a patch or a part of it, row by row, before and after displacement: the result of Patch::evaluate()
 * (source.h). A task reuses the memory for each patch. */

#include "../base/codec_names.h"
#include "../../cvert/portable/vertices4.h"
#include "../embree/scene.h"

namespace embree::isa {
/*! A rectangle of vertices of a patch: x0 to x1 along u and y0 to y1 along v, inclusive. */
struct PatchPart {
  unsigned x0, x1, y0, y1;
};

class PatchVertices {
public:
  explicit PatchVertices(Device* device) : interleaved(device, 0) {}

  /*! Leaves the vertices undefined. */
  void setSize(size_t width, size_t height) {
    this->width = width;
    this->height = height;
    count = width * height;
    interleaved.reserve(6 * count); // otherwise vectors grow to a power of two
    interleaved.resize(6 * count);
  }
  void setSize(const PatchPart& part) { setSize(part.x1 - part.x0 + 1, part.y1 - part.y0 + 1); }

  /*! Leaves the undisplaced vertices undefined. */
  void set(unsigned quadsX, unsigned quadsY, const float (*vertices)[3]) {
    setSize(quadsX + 1, quadsY + 1);
    memcpy(displaced(), vertices, count * sizeof(*vertices));
  }

  /*! Sets all vertices to NaN, for patches without a surface at a time step. */
  void setInvalid(const PatchPart& part) {
    setSize(part);
    std::fill(interleaved.begin(), interleaved.end(), std::numeric_limits<float>::quiet_NaN());
  }

  float (*undisplaced())[3] { return (float(*)[3])interleaved.data(); }
  float (*displaced())[3] { return (float(*)[3])(interleaved.data() + 3 * count); }

  /*! Bounds of the displaced vertices. Returns false, and undefined bounds, if one is not finite. */
  bool bounds(float lower[3], float upper[3]) { return cbvh::boundsOfVertices(displaced(), count, lower, upper); }

  size_t width = 0, height = 0; //!< in vertices

protected:
  size_t count = 0;

private:
  mvector<float> interleaved; //!< undisplaced, then displaced
};
} // namespace embree::isa
