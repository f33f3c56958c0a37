// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The paper's figure 1: a cube of 8 control points and 6 faces, 9 spikes on each,
 * by a smooth displacement function. */

#include "surface/model.h"

namespace cbvh {

/* amplitude: height of the spikes as a fraction of the diagonal of the cage. */
constexpr float cubeAmplitude = 0.09f;
Model makeCube(float amplitude = cubeAmplitude);

} // namespace cbvh
