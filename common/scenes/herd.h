// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Copies of `trex`, each a geometry with its own pose. */

#include "scenes/trex.h"

namespace programs {

constexpr int herdCount = 12;
constexpr int maxHerdCount = 100000;

/* The copies share heights and topology. */
Model makeHerd(const TrexSettings& settings, int count = herdCount);

} // namespace programs
