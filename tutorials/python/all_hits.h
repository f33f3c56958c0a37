// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* All hits of rays, not only the closest ones. */

#include "scene.h"

#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <memory>
#include <vector>

namespace programs::python {

/* Replaces `hits` by all hits of the ray in ascending order of distance, then of IDs and (u,v). One traversal. A ray
 * through an edge or a vertex may hit several of its triangles. */
void findAllHits(RTCScene scene, const Ray& ray, std::vector<RTCRayHit>& hits);

/* Adds the method to the class Scene. */
void defineAllHits(py::class_<Scene, std::shared_ptr<Scene>>& scene);

} // namespace programs::python
