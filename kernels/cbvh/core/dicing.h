// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Subdivision surfaces as fine as a picture of them needs: the rate of each edge by the size at which a camera sees
 * what lies along it. */

#include "../surface/dicing_camera.h"
#include <vector>

namespace embree
{
  class Geometry;

  namespace core
  {
    /*! Sets the level buffer of a subdivision surface so that its quads are about as large in a picture as the camera
     *  asks for, and returns the levels, one per index. Commit the geometry afterwards. A buffer that was there is
     *  replaced, not written.
     *
     *  Edges are measured on the limit surface, moved by the displacement function, which is called by several threads
     *  for points of all faces, about 1/16 as many as quads. Lengths count as if they were seen from the front, so that
     *  silhouettes, shadows and reflections have quads as fine as what is seen. The rate of an edge is the nearest
     *  power of two: quads are between 0.7 and 1.4 times as long as asked for. Both faces at an edge get the higher of
     *  the rates that they need. Of several time steps the one that needs most counts. Vertices that are not finite
     *  count as if they were not there.
     *
     *  Errors: RTC_ERROR_INVALID_ARGUMENT, with the name of the member and its value, for numbers of the camera that
     *  are not finite or out of range, and for indices that are no vertices; RTC_ERROR_INVALID_OPERATION for other
     *  geometry, a geometry of a file, and one that was not committed since its buffers were changed. The geometry
     *  keeps its levels if there is an error. Thread safety: no other thread may use the geometry meanwhile. */
    std::vector<float> dice (Geometry* geometry, const DicingCamera& camera);
  }
}
