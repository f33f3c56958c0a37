// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which axis of a cage points upwards. OBJ files have no word for it: most are y up, those of CAD
 * and of programs whose ground is the plane of x and y are z up.
 *
 * Axes are named as on command lines: "x", "y", "z", "-x", "-y" and "-z". */

#include "surface/cage.h"
#include "surface/view_hints.h"

#include <string>
#include <vector>

namespace cbvh {

/* All six, the likeliest first. */
const std::vector<std::string>& upAxes();

struct UpGuess
{
  std::string axis = "y";
  std::string reason; // why it is not y; ends a sentence, "z is taken for up, as ..."
};

/* y, or z where there is clear evidence for it: a comment at the head of the file, or a shape that
 * would hardly be y up. Nothing else is guessed: who opens a file that is y up must not find it on
 * its side, so whatever leaves doubt is y.
 *
 * cage: at least one face; indices in range. */
UpGuess guessUp(const Cage& cage);

/* Turns hints that were made for an upward y axis, and back. up: one of upAxes(). */
ViewHints turnedFromY(ViewHints hints, const std::string& up);
ViewHints turnedToY(ViewHints hints, const std::string& up);

} // namespace cbvh
