// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Closest points of scenes, for arrays of points. */

#include "scene.h"

namespace programs::python {

/* Arguments as for Scene.closest_points, except for `threads`, which is at least 1. Returns positions and Hits. */
py::tuple closestPoints(const Scene& scene, const py::object& points, const py::object& radius, const py::object& time,
                        unsigned threads);

} // namespace programs::python
