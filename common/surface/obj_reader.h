// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Strict reader of Wavefront OBJ: v, vt, f with v, v/vt, v//vn and v/vt/vn, negative (relative) indices, faces of
 * any size, and OpenSubdiv's `t` tags (crease, corner, hole, interpolateboundary, creasemethod). Normals, groups,
 * objects, materials, smoothing groups, lines, display attributes and tags whose names begin with facevarying are
 * skipped. Everything else is an error, because a misread file makes a wrong picture. */

#include "surface/cage.h"

#include <istream>
#include <string>
#include <vector>

namespace programs {

/* Reads a file, or a pipe that a program opens for writing within 10 seconds. Appends a line to `warnings` for the
 * tag smoothtriangles with a rule that Embree does not support. Throws Error with path and line number, also for a file
 * without faces and for texture coordinates at only some corners of a face. Appends the positions as the file has
 * them, before they are rounded to 32 bits, to `exactPositions`. */
Cage readObj(const std::string& path, std::string& warnings, std::vector<Vec3d>* exactPositions = nullptr);

/* Messages use `name` as the path. */
Cage readObj(std::istream& stream, const std::string& name, std::string& warnings,
             std::vector<Vec3d>* exactPositions = nullptr);

} // namespace programs
