// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "tracing/camera.h"

#include <utility>

namespace cbvh::python {

/* Width and height of a picture; refuses what is out of range. */
ImageSize imageSize(std::pair<int, int> size);

} // namespace cbvh::python
