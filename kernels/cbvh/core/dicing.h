// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../surface/dicing_camera.h"
#include <vector>

namespace embree
{
  class Geometry;

  namespace core
  {
    /*! Sets the level buffer of a subdivision surface so that its quads have about the size in the picture that the
     *  camera requests. Returns the levels, one per index. Replaces an existing level buffer, without writing into it.
     *  Commit the geometry afterwards.
     *
     *  Measures the limit surface with displacement: several threads call the displacement function, for about 1/16 as
     *  many points as quads. Lengths are measured as if seen from the front, so that silhouettes, shadows and
     *  reflections have quads as fine as visible surfaces. Rates are rounded to the nearest power of two: quads are 0.7
     *  to 1.4 times as long as requested. An edge has the highest rate of its faces and time steps. Vertices that are
     *  not finite are ignored.
     *
     *  Errors: RTC_ERROR_INVALID_ARGUMENT, naming the member and its value, for camera values that are not finite or
     *  out of range, and for indices that are out of range. RTC_ERROR_INVALID_OPERATION for other types of geometry,
     *  for geometry loaded from a file, and if the geometry was not committed since its buffers changed. After an error
     *  the geometry keeps its levels. Thread safety: no other thread may use the geometry during this call. */
    std::vector<float> dice (Geometry* geometry, const DicingCamera& camera);
  }
}
