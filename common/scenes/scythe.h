// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A blade of few large, strongly displaced patches that end in a thin tip, on a shaft, as in the paper's figure 14. */

#include "surface/model.h"

namespace programs {

/* Displacement between heights 0 and 1 as a fraction of the cage's diagonal. */
constexpr float scytheAmplitude = 0.045f;
Model makeScythe(float amplitude = scytheAmplitude, int threads = 0);

} // namespace programs
