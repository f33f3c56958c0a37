// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A squat toad of some hundred large smooth faces, many with a single sharp spike, as in the paper's figure 13. */

#include "surface/model.h"

namespace programs {

/* Height of the longest spikes as a fraction of the cage's diagonal. */
constexpr float frogAmplitude = 0.07f;
Model makeFrog(float amplitude = frogAmplitude, int threads = 0);

} // namespace programs
