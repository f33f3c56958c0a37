// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "tracing/camera.h"

#include <utility>

namespace programs::python {

/* Raises ValueError if out of range. */
ImageSize imageSize(std::pair<int, int> size);

} // namespace programs::python
