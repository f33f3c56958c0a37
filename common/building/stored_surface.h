// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Triangles that compressed geometries store. Scenes in cLEAF and cVOXEL have none: the functions throw Error. */

#include "building/face_numbers.h"
#include "building/traced_scene.h"

#include <array>
#include <vector>

namespace programs {

/* Each quad is the triangles 00, 10, 01 and 01, 10, 11. In meshes, one of them may have two equal vertices: then the
 * quad is a triangle. */
struct StoredMesh {
  std::vector<Vec3f> vertices;                // parts repeat border vertices: equal floats, for cGRID only in a face
  std::vector<std::array<unsigned, 4>> quads; // 00, 10, 11, 01
  std::vector<unsigned> faces;                // per quad, as hits report them (the first of two triangles)
};

/* Writes the vertices of the stored triangle that a ray hit at `time`. Returns false for a miss, or if no triangle is
 * stored there. */
bool storedTriangle(const TracedScene& scene, const FaceNumbers& faces, const SurfaceHit& hit, float time,
                    Vec3f vertices[3]);

/* Throws Canceled. */
StoredMesh storedMesh(const TracedScene& scene, const FaceNumbers& faces, float time);

} // namespace programs
