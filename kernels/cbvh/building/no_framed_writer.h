// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Replaces paper/writer.h in libraries without the paper's representations (EMBREE_CBVH_NO_PAPER). Only
 * the constructor is called. */

#include "../base/grid_soa_writer.h"
#include "../surface/cage_patch.h"
#include "../surface/plan.h"

namespace embree::isa {
struct PatchTiling {
  size_t size() const { return 0; }
};

inline unsigned levelOf(const float*) { return 0; }
inline PatchTiling tilingOf(cbvh::Kind, const float*, unsigned) { return PatchTiling(); }

struct FramedWriter {
  FramedWriter(const CompressionPlan&, SubdivMesh*, BlockStore&, cbvh::BuildStatistics&) {}
  unsigned boundedFrameLevel(CagePatch&) { return 0; }
  bool write(CagePatch&, const PatchTiling&) { return false; }
  const float (*evaluatedVertices(unsigned, unsigned) const)[3] { return nullptr; }
};
} // namespace embree::isa
