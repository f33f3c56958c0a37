// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reader of the surfaces of glTF 2.0 and GLB: triangles, strips and fans of all nodes of the default scene, at their
 * places. Of animated models, the pose without animation: morph targets with the weights of the file, and skins with
 * the joints where the nodes are. Materials, textures, cameras and lights are skipped. */

#include "meshes/input_bytes.h"
#include "meshes/polygon_mesh.h"

#include <string>

namespace programs {

/* Appends a line to `warnings` for points and lines, and for further scenes, which are left out. Throws Error with the
 * path and the place in the document for files that are damaged, have no triangles, or require extensions that are not
 * supported, such as compression by Draco or meshoptimizer. */
PolygonMesh readGltf(InputBytes& input, std::string& warnings);

} // namespace programs
