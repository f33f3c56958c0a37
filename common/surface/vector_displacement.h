// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/mapped_texture.h"

#include <memory>

namespace programs {

/* `texture` has three channels; `description` holds scale, mid level and axes. Throws Error for tangent-space vectors
 * without texture coordinates. */
std::unique_ptr<Displacement> displaceByVectors(const Cage& cage, std::unique_ptr<MappedTexture> texture,
                                                const DisplacementMap& description);

} // namespace programs
