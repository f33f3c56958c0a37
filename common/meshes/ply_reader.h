// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Strict reader of PLY 1.0, in text and binary of both byte orders: elements vertex (x, y, z of any type), face (list
 * vertex_indices or vertex_index, of any number of corners) and tristrips, in any order. Other elements and properties
 * are skipped. */

#include "meshes/input_bytes.h"
#include "meshes/polygon_mesh.h"

namespace programs {

/* Throws Error with the path and the element or line for files that are damaged or have no faces. */
PolygonMesh readPly(InputBytes& input);

} // namespace programs
