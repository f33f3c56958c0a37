// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include <set>

namespace embree {
/*! Bytes of a geometry's buffers that Embree allocated, and of the topology that Embree made.
 *  counted: buffers to skip; receives this geometry's buffers. */
size_t bytesOfInput(const CompressibleGeometry* geometry, std::set<const void*>& counted);
} // namespace embree
