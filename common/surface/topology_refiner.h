// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts a cage to OpenSubdiv. Only for sources of common/, which have OpenSubdiv's headers. */

#include "surface/cage.h"

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

namespace cbvh {

/* Returns the unrefined cage. If `validate` is set, reports invalid topology through Far's callbacks and returns null
 * for it. */
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> makeTopologyRefiner(const Cage& cage, bool validate);

} // namespace cbvh
