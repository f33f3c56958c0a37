// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "pictures/image.h"

#include <vector>

namespace programs {

/* errorHeatMap with its scale below, so that a picture that is blue all over explains itself: the colors from 0 to 5
 * pixels, the length of a quad's edge on that scale (`quadPixels`; 0 if it is unknown), and the colors of false hits
 * and misses. The picture is higher than `size`; labels for which it is too narrow are left out. */
Image errorPicture(ImageSize size, const std::vector<float>& errors, float quadPixels);

} // namespace programs
