// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A bent limb of few faces, as in the paper's figure 15. */

#include "surface/model.h"

namespace programs {

/* Displacement between heights 0 and 1 as a fraction of the cage's diagonal. */
constexpr float kneeAmplitude = 0.02f;
Model makeKnee(float amplitude = kneeAmplitude, int threads = 0);

} // namespace programs
