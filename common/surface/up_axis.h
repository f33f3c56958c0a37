// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Guesses the up axis of a cage. OBJ files do not store it: most are y up; files of CAD programs, and of programs whose
 * ground is the plane of x and y, are z up.
 *
 * Axes have the names of the command line: "x", "y", "z", "-x", "-y" and "-z". */

#include "surface/cage.h"
#include "surface/view_hints.h"

#include <string>
#include <vector>

namespace cbvh {

/* All six axes, the most likely first. */
const std::vector<std::string>& upAxes();

struct UpGuess
{
  std::string axis = "y";
  std::string reason; // why the axis is not y; ends the sentence "z is the up axis, because ..."
};

/* Returns y, or z if there is clear evidence for it: a comment at the beginning of the file, or a shape that is
 * implausible as y up. Other axes are never guessed, and doubtful cases are y, so that files that are y up are never
 * turned. The cage must have at least one face and valid indices. */
UpGuess guessUp(const Cage& cage);

/* Rotate hints for an upward y axis to the up axis `up`, one of upAxes(), and back. */
ViewHints turnedFromY(ViewHints hints, const std::string& up);
ViewHints turnedToY(ViewHints hints, const std::string& up);

} // namespace cbvh
