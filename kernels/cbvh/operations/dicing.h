// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Chooses the edge rates of a subdivision surface by the size of its quads in a camera's picture. */

#include "../surface/dicing_camera.h"
#include <vector>

namespace embree {
class Geometry;

namespace core {
/*! As cbvhDiceSurface for a geometry: sets the level buffer of a subdivision surface and returns its rates, one per
 * index. An edge has the highest rate of its faces and time steps, rounded to the nearest power of two up to the
 * maximum. Thread safety: no other thread may use the geometry during this call; several threads call the displacement
 *  function. */
std::vector<float> dice(Geometry* geometry, const DicingCamera& camera);
} // namespace core
} // namespace embree
