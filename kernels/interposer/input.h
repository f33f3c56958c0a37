// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The input that an application sets on a geometry of Embree, and its conversion to input of a CbvhSurface. */

#include "real.h"

#include <cbvh/cbvh.h>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace interposer {

/* Thrown, with the reason, if a geometry cannot be compressed. Embree then traces it. */
struct Unsupported : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/* Throws std::bad_alloc or Unsupported if a function of libembree_cbvh failed. */
void check(CbvhError error);

/* A buffer that the application shares or that Embree owns. stride: in bytes. */
struct Buffer {
  RTCFormat format;
  const char* data;
  size_t stride, count;
  bool isOutOfBounds = false; // it ends past the RTCBuffer: some versions of Embree accept that, others reject it
};

struct Input {
  RTCGeometryType type;
  RTCGeometry original;
  void* const* userData;         // location of the application's user data, for displacement
  unsigned int numTimeSteps = 1; // can be 0, as in Embree
  float startTime = 0, endTime = 1;
  float tessellationRate = 2;
  RTCSubdivisionMode mode = RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;
  RTCDisplacementFunctionN displacement = nullptr;
  std::map<std::pair<RTCBufferType, unsigned int>, Buffer> buffers;
  bool hasWideNodes = false; // Embree's nodes for grids have eight children
  bool isRefitted = false;   // the application requests RTC_BUILD_QUALITY_REFIT
  bool isIncomplete = false; // memory ran out when a buffer was set

  /* Sets a surface's cage, grids or mesh. Throws Unsupported or std::bad_alloc. This Input and its buffers must exist
   * until the surface is committed. */
  void applyTo(CbvhSurface surface) const;

private:
  /* Returns NULL if there is no such buffer. Throws Unsupported if it is out of bounds. */
  const Buffer* find(RTCBufferType type, unsigned int slot = 0) const;
  /* The result points to `steps`, which receives a pointer to the vertices of each step. Throws Unsupported or
   * std::bad_alloc. */
  CbvhVertices vertices(std::vector<const float*>& steps) const;
  void applyCage(CbvhSurface surface) const;
  void applyGrids(CbvhSurface surface) const;
  void applyMesh(CbvhSurface surface) const;
};

} // namespace interposer
