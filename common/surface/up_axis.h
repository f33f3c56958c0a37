// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OBJ files do not store the up axis: most are y up; files of CAD programs, and of programs whose ground is the
 * plane of x and y, are z up.
 *
 * Axes are named "x", "y", "z", "-x", "-y" and "-z". */

#include "surface/cage.h"
#include "surface/view_hints.h"

#include <string>
#include <vector>

namespace programs {

/* The most likely first. */
const std::vector<std::string>& upAxes();

struct UpGuess {
  std::string axis = "y";
  std::string reason; // for an axis other than y; completes "z is the up axis, because ..."
};

/* Returns z only with clear evidence, a comment at the beginning of the file or a shape that is implausible as y up:
 * files that are y up must never be rotated. The cage must have a face and valid indices. */
UpGuess guessUp(const Cage& cage);

/* Convert hints between an upward y axis and `up`, one of upAxes(). */
ViewHints rotatedFromY(ViewHints hints, const std::string& up);
ViewHints rotatedToY(ViewHints hints, const std::string& up);

} // namespace programs
