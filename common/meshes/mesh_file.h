// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "meshes/polygon_mesh.h"

#include <istream>
#include <string>

namespace programs {

/* Extensions of the formats, in lower case with a dot: PLY, STL and glTF, without OBJ. */
bool isMeshExtension(const std::string& extension);

/* Reads OBJ, PLY, STL, glTF or GLB. PLY, GLB, and STL from a pipe are recognized by their first bytes, the others by
 * the extension of the path; files with other extensions are OBJ. Appends lines to `warnings` for parts that are no
 * surface. Records the file, and those that it refers to, as inputs of the run.
 *
 * Throws Error with the path, and the line or element, for files that are damaged, or that can be read only in part.
 * Positions are finite as floats and indices are in range. */
PolygonMesh readMesh(const std::string& path, std::string& warnings);

/* The same from a stream. Messages use `name` as the path, and other files are searched next to it. */
PolygonMesh readMesh(std::istream& stream, const std::string& name, std::string& warnings);

/* Rounds positions to 32 bits. Appends a line to `warnings` if that moves one by more than a millionth of the mesh's
 * size, as with coordinates of maps. */
std::vector<Vec3f> roundedPositions(const PolygonMesh& mesh, const std::string& path, std::string& warnings);

} // namespace programs
