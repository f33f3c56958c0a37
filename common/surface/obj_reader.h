// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Strict reader of control cages in Wavefront OBJ: v, vt, f with v, v/vt, v//vn and v/vt/vn, negative (relative)
 * indices, faces of any size, and OpenSubdiv's `t` tags (crease, corner, hole, interpolateboundary, creasemethod).
 * Normals, groups, objects, materials, smoothing groups, lines and display attributes are skipped. Everything else is
 * an error, because a file that is misread silently makes a wrong picture. */

#include "surface/cage.h"

#include <istream>
#include <string>

namespace cbvh {

/* Reads a cage from a file, or from a pipe that a program opens for writing within 10 seconds. Appends a line to
 * `warnings` for the tag smoothtriangles, because Embree has no such rule.
 * Throws Error, one line with path and line number, for a file that cannot be read or has no faces, a face of fewer
 * than 3 vertices, an index out of range, a malformed or infinite number, an unknown statement, a malformed tag, and a
 * face with texture coordinates at only some corners. Throws Canceled. */
Cage readObj(const std::string& path, std::string& warnings);

/* Reads a cage from a stream; messages use `name` as the path. */
Cage readObj(std::istream& stream, const std::string& name, std::string& warnings);

} // namespace cbvh
