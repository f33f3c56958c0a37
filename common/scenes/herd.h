// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Many copies of `trex`, each a geometry with its own pose instead of an instance, to measure scaling. */

#include "scenes/trex.h"

namespace cbvh {

constexpr int herdCount = 12;
constexpr int herdMostCount = 100000;

/* Creates `count` copies, which share heights and topology. */
Model makeHerd(const TrexSettings& settings, int count = herdCount);

} // namespace cbvh
