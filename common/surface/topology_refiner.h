// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A cage in OpenSubdiv's terms. Only for sources of common/, which see its headers. */

#include "surface/cage.h"

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

namespace cbvh {

/* Not yet refined. validate: report bad topology through Far's callbacks, and make
 * none of it. */
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> makeTopologyRefiner(const Cage& cage, bool validate);

} // namespace cbvh
