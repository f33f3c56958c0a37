// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Strict reader of STL, in text, also with several solids, and in binary. Exactly equal positions become one vertex;
 * no others are joined. Triangles without area are kept. Normals, names and attributes are skipped. */

#include "meshes/input_bytes.h"
#include "meshes/polygon_mesh.h"

namespace programs {

/* Throws Error with the path and the triangle or line for files that are damaged or have no triangles. */
PolygonMesh readStl(InputBytes& input);

} // namespace programs
