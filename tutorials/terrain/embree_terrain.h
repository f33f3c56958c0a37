// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The terrain in Embree's own kernels, for comparison. */

#include "terrain_tile.h"
#include "building/embree_device.h"

#include <cbvh/cbvh.h>

#include <string>

namespace programs {

class EmbreeTerrain {
public:
  /* `kernel` is "grid", "quad" or "triangle". */
  explicit EmbreeTerrain(const std::string& kernel);

  /* Copies the tile: Embree needs the buffers until the geometry is released. Throws Error. */
  void add(const TerrainTile& tile);

  /* Uses Embree's compact and robust modes. Throws Error. */
  void commit();

  bool isOccluded(CbvhRay ray) const;
  size_t bytes() { return device.memory().live(); }
  size_t numQuads() const { return quads; }
  float maxDeviation() const { return 0; }

private:
  EmbreeDevice device;
  SceneHandle scene; // released before its device
  std::string kernel;
  size_t quads = 0;
};

} // namespace programs
