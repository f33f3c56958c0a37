// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Text in pictures, without a library for fonts. */

#include "pictures/image.h"

#include <string>

namespace programs {

constexpr int labelHeight = 9, labelAdvance = 6; // of a character, in dots; two rows are below the baseline

inline int labelWidth(const std::string& text) { return int(text.size()) * labelAdvance - 1; }

/* Writes black text with its upper left corner at (x,y). A dot has scale x scale pixels; dots outside of the image are
 * left out. Letters of a to z that no label contains, and other characters, are blank. */
void drawLabel(Image& image, int x, int y, int scale, const std::string& text);

/* Fills a rectangle. `color` is linear. */
void fillRectangle(Image& image, int x, int y, int width, int height, Vec3f color);

} // namespace programs
