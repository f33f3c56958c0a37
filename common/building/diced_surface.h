// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A model as an application dices it: GRID's vertices, merged where patches share them, as the geometries that the
 * application passes to Embree. */

#include "building/built_scene.h"
#include "building/embree_device.h"
#include "surface/model.h"

#include <array>
#include <string>
#include <vector>

namespace programs {

/* The form in which a surface is passed to Embree:
 * - "grids": one grid per patch; "grids:N": grids of N x N quads;
 * - "quads": indexed quads in the order of OpenSubdiv's uniform refinement; "quads:rows": patch by patch, row by row;
 *   "quads:shuffled";
 * - "triangles", "triangles:rows", "triangles:shuffled": two triangles for each of these quads. */
struct DicedInput {
  enum Shape { Grids, Quads, Triangles };
  enum Order { Refined, Rows, Shuffled };

  std::string name;
  Shape shape = Grids;
  Order order = Refined;
  unsigned gridQuads = 0; // per side of a grid, 0 for whole patches

  /* Throws Error if the word is unknown. */
  static DicedInput parse(const std::string& text);
};

struct QuadMesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<unsigned, 4>> quads; // vertices in order around the quad
};

/* Returns an uncommitted geometry with its own copy of the mesh. */
GeometryHandle makeIndexedGeometry(EmbreeDevice& device, const QuadMesh& mesh, bool asTriangles);

class DicedSurface {
public:
  /* The model must outlive the surface. Throws Error. */
  DicedSurface(const Model& model, const BuildSettings& settings);

  size_t numQuads() const { return layout.numQuads(); }

  /* Throws Error if OpenSubdiv's refinement has other vertices. */
  QuadMesh mesh(DicedInput::Order order) const;

  /* Returns an uncommitted geometry with its own copy of the vertices. `gridQuads` as in DicedInput. */
  GeometryHandle makeGrids(EmbreeDevice& device, unsigned gridQuads) const;

private:
  void weld(const Cage& cage, size_t firstPatch, size_t numPatches);
  QuadMesh refinedMesh() const;
  QuadMesh meshRowByRow() const;

  const Model& model;
  int level;
  PatchLayout layout;
  std::vector<Vec3f> positions; // of the patches, concatenated
  std::vector<unsigned> first;  // per vertex: the first vertex at the same position
};

} // namespace programs
