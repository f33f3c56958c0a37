// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A model as an application dices it: the vertices that GRID tessellates, welded where patches share them, and the geometry that it
 * hands over. */

#include "building/built_scene.h"
#include "building/embree_device.h"
#include "surface/model.h"

#include <array>
#include <string>
#include <vector>

namespace cbvh {

/* How a surface is handed over: "grids" of a patch each, or "grids:N" of N x N quads; "quads", indexed, in the order in which OpenSubdiv's
 * uniform refinement has them, "quads:rows", patch by patch and in each row by row, or "quads:shuffled"; "triangles", two for each of these
 * quads, likewise. */
struct DicedInput
{
  enum Shape { Grids, Quads, Triangles };
  enum Order { Refined, Rows, Shuffled };

  std::string name;
  Shape shape = Grids;
  Order order = Refined;
  unsigned gridQuads = 0; // along a side, 0 for whole patches

  /* Throws Error that names the word. */
  static DicedInput parse(const std::string& text);
};

/* As an application welds it. */
struct QuadMesh
{
  std::vector<Vec3f> vertices;
  std::vector<std::array<unsigned, 4>> quads; // around each
};

/* A geometry that has its own copy of a mesh, as quads, or as two triangles for each; not committed. */
GeometryHandle makeIndexed(EmbreeDevice& device, const QuadMesh& mesh, bool asTriangles);

class DicedSurface
{
public:
  /* Tessellates. The model outlives the surface. Throws Error, Cancelled. */
  DicedSurface(const Model& model, const BuildSettings& settings);

  size_t numQuads() const { return layout.numQuads(); }

  /* A vertex for all that patches share. Throws Error where OpenSubdiv's refinement is not what the patches say. */
  QuadMesh mesh(DicedInput::Order order) const;

  /* A geometry that has its own copy of the vertices, not committed. gridQuads: as DicedInput has it */
  GeometryHandle makeGrids(EmbreeDevice& device, unsigned gridQuads) const;

private:
  void weld(const Cage& cage, size_t firstPatch, size_t numPatches);
  QuadMesh refinedMesh() const;
  QuadMesh meshRowByRow() const;

  const Model& model;
  int level;
  PatchLayout layout;
  std::vector<Vec3f> positions; // of the patches, one after the other
  std::vector<unsigned> first;  // vertex that each is the same as
};

} // namespace cbvh
