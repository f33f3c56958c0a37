// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Only for sources of common/, which have OpenSubdiv's headers. */

#include "surface/cage.h"

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

namespace programs {

/* Converts an unrefined cage. If `validate`, reports invalid topology through Far's callbacks and returns null. */
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> makeTopologyRefiner(const Cage& cage, bool validate);

} // namespace programs
