// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A bent limb of few faces: high curvature at the knee, moderate displacement. What
 * figure 15 of the paper is about. */

#include "surface/model.h"

namespace cbvh {

/* amplitude: from height 0 to 1 as a fraction of the cage's diagonal. */
constexpr float kneeAmplitude = 0.02f;
Model makeKnee(float amplitude = kneeAmplitude, int threads = 0);

} // namespace cbvh
