// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The paper's figure 1: a cube of 6 faces with 9 smooth spikes each. */

#include "surface/model.h"

namespace programs {

/* Height of the spikes as a fraction of the cage's diagonal. */
constexpr float cubeAmplitude = 0.09f;
Model makeCube(float amplitude = cubeAmplitude);

} // namespace programs
