// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Strict reader of control cages in Wavefront OBJ: v, vt, f with v, v/vt, v//vn
 * and v/vt/vn, negative (relative) indices, faces of any size, and OpenSubdiv's
 * `t` tags (crease, corner, hole, interpolateboundary, creasemethod). Normals, groups, objects,
 * materials, smoothing groups and lines are skipped; anything else is an error,
 * for what is silently misread comes back as a wrong picture. */

#include "surface/cage.h"

#include <istream>
#include <string>

namespace cbvh {

/* Reads a cage.
 *
 * path: file to read, or a pipe that some program opens for writing within 10 seconds.
 * warnings: a line is added on the tag smoothtriangles, as Embree has no such rule.
 * Errors: throws Error, one line with path and line number, for a file that cannot
 * be read or has no faces, a face of fewer than 3 vertices, an index out of range,
 * a number that is none or not finite, an unknown statement, a malformed tag, and
 * a face with texture coordinates on some of its corners only. */
Cage readObj(const std::string& path, std::string& warnings);

/* The same from a stream; name stands for the path in messages. */
Cage readObj(std::istream& stream, const std::string& name, std::string& warnings);

} // namespace cbvh
