// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/cvert/encoder/mesh_partition.h"

namespace programs::test {

// Consecutive groups of `size` triangles; the last one may be smaller. At most maxMeshGroups.
inline cvert::MeshGroups fullGroups(uint32_t count, uint32_t size) {
  cvert::MeshGroups groups;
  for (uint32_t end = size; end < count + size; end += size) groups.add(std::min(end, count));
  return groups;
}

} // namespace programs::test
