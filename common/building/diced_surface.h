// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A model as an application dices it: the vertices that GRID tessellates, welded where patches share them, and the geometry that it
 * hands over. */

#include "building/built_scene.h"
#include "building/embree_device.h"
#include "surface/model.h"

#include <string>
#include <vector>

namespace cbvh {

/* How a surface is handed over: "grids" of a patch each, or "grids:N" of N x N quads. */
struct DicedInput
{
  std::string name;
  unsigned gridQuads = 0; // along a side, 0 for whole patches

  /* Throws Error that names the word. */
  static DicedInput parse(const std::string& text);
};

class DicedSurface
{
public:
  /* Tessellates. Throws Error, Cancelled. */
  DicedSurface(const Model& model, const BuildSettings& settings);

  size_t numQuads() const { return layout.numQuads(); }
  const std::vector<Vec3f>& vertices() const { return positions; }

  /* A geometry that has its own copy of the vertices, not committed. */
  GeometryHandle makeGeometry(EmbreeDevice& device, const DicedInput& input) const;

private:
  void weld(const Cage& cage, size_t firstPatch, size_t numPatches);

  PatchLayout layout;
  std::vector<Vec3f> positions; // of the patches, one after the other
};

} // namespace cbvh
