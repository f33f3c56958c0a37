// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A squat toad of some hundred large smooth faces with a single sharp spike on many of
 * them: what figure 13 of the paper is about. */

#include "surface/model.h"

namespace cbvh {

/* amplitude: height of the longest spikes as a fraction of the cage's diagonal. */
constexpr float frogAmplitude = 0.07f;
Model makeFrog(float amplitude = frogAmplitude, int threads = 0);

} // namespace cbvh
