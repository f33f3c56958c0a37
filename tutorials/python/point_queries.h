// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Closest points, distances and insides of scenes, for arrays of points. */

#include "scene.h"

#include <memory>

namespace programs::python {

/* Adds the methods to the class Scene. */
void definePointQueries(py::class_<Scene, std::shared_ptr<Scene>>& scene);

} // namespace programs::python
