// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Numbers the faces of all geometries of a scene consecutively, as SurfaceHit does. A face is a primitive of a
 * geometry: a face of a cage, a grid, a quad or a triangle. */

#include "basics/error.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace programs {

class FaceNumbers {
public:
  FaceNumbers() = default;

  /* Throws Error if the numbers of all faces do not fit into 32 bits. */
  explicit FaceNumbers(const std::vector<size_t>& facesOfGeometries) {
    for (const size_t faces : facesOfGeometries) first.push_back(first.back() + faces);
    if (count() >= RTC_INVALID_GEOMETRY_ID)
      throw Error("the scene has " + std::to_string(count()) + " primitives: expected less than 2^32 - 1");
  }

  size_t count() const { return first.back(); }
  size_t numGeometries() const { return first.size() - 1; }

  unsigned number(unsigned geomID, unsigned primID) const { return unsigned(first[geomID]) + primID; }
  unsigned geomID(unsigned number) const {
    return unsigned(std::upper_bound(first.begin(), first.end(), size_t(number)) - first.begin()) - 1;
  }
  unsigned primID(unsigned number) const { return number - unsigned(first[geomID(number)]); }

  bool operator==(const FaceNumbers& other) const { return first == other.first; }

private:
  std::vector<size_t> first{0}; // of each geometry, and the count of all
};

} // namespace programs
