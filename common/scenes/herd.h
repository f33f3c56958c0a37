// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Many copies of `trex`, none an instance and each in a pose of its own: for scale. */

#include "scenes/trex.h"

namespace cbvh {

constexpr int herdCount = 12;
constexpr int herdMostCount = 100000;

/* count: of copies, each a geometry of its own; heights and topology are shared. */
Model makeHerd(const TrexSettings& settings, int count = herdCount);

} // namespace cbvh
