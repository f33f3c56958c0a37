// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices on the borders of diced grids, by the rule in shared_border.h. Two grids share a border vertex if it has the
 * same index, or equal floats at all time steps (position_table.h). All grids then have the same position for it, so
 * only its lattice is chosen, and whether it is stitched (stitched_vertices.h). Lossless geometry shares nothing: its
 * vertices stay in place. */

#include "border_lattices.h"
#include "diced_grids.h"
#include "irregular_triangles.h"
#include "patch_vertices.h"
#include "shared_border.h"
#include "stitched_vertices.h"

namespace embree::isa {
template<typename Grids>
class GridBorders : public StoredBorders {
public:
  typedef typename Grids::Grid Grid;
  typedef PatchVertices Scratch;

  GridBorders(const typename Grids::Mesh* mesh, const CompressionPlan& plan)
    : grids(mesh),
      plan(plan),
      lattices(mesh->device, plan),
      table(mesh->device),
      stitched(mesh->device, *this, table, lattices, plan.numTimeSteps,
               plan.settings.maxError > 0 ? plan.settings.maxError : INFINITY) {}
  GridBorders(const GridBorders&) = delete;

  size_t size() const { return grids.size(); }
  Grid operator[](size_t i) const { return grids[i]; }
  bool isValid(size_t i) const { return grids.isValid(i); }
  bool isError(size_t i) const { return grids.isError(i); }
  const float* position(size_t vertex, unsigned step = 0) const { return grids.position(vertex, step); }
  bool getNumbers(size_t i, cbvh::QuadNumbers& out) const { return grids.getNumbers(i, out); }

  template<typename Progress>
  void build(size_t gridsPerTask, const Progress& progress) {
    lattices.chooseForPrimitives(*this, gridsPerTask, progress);
    if ((size() < 2 && !grids.hasIrregular()) || size() == 0 || plan.isLossless()) return;
    table.reserve(reduceRanges(
        size(), 4 * gridsPerTask, size_t(0),
        [&](const range<size_t>& r) {
          size_t n = 0;
          for (size_t i = r.begin(); i != r.end(); i++)
            if (isValid(i)) n += 2 * (size_t((*this)[i].quads(0)) + (*this)[i].quads(1));
          return n;
        },
        std::plus<size_t>()));
    lattices.chooseForShared(*this, table.size(), gridsPerTask, progress);
    stitched.find(gridsPerTask, progress);
  }

  void release() {
    table.clear();
    lattices.clear();
    stitched.clear();
  }

  /*! Exponent of the spacing of a grid's lattice. */
  int exponent(size_t grid, unsigned step) const { return lattices.ofPrimitive(grid, step); }

  /*! Returns a vertex on a grid's border, the same for all grids if it is finite at this step.
   *  vertex: index in the buffer. own: exponent of the grid's lattice, for vertices that are not shared. */
  SharedVertex sharedVertex(size_t vertex, int own, unsigned step) const {
    const float* p = position(vertex, step);
    if (table.isEmpty() || !cbvh::isFinite(p)) return SharedVertex(p, own);
    const Entry entry = table.find(*this, vertex);
    if (!table.isMarked(entry)) return SharedVertex(p, lattices.ofShared(entry, step));
    return SharedVertex(p, stitched.stored(entry, step));
  }

  /*! See StoredBorders. Only for meshes with one time step. */
  bool find(size_t vertex, float out[3]) const override {
    if (table.isEmpty() || table.find(*this, vertex) == Table::none) return false;
    memcpy(out, sharedVertex(vertex, cbvh::losslessExponent, 0).stored, 3 * sizeof(float));
    return true;
  }

  /*! For PositionTable. Two NaNs count as equal. */
  bool areEqual(size_t a, size_t b) const {
    for (unsigned step = 0; step < plan.numTimeSteps; step++) {
      const float *p = position(a, step), *q = position(b, step);
      for (int k = 0; k < 3; k++)
        if (!(p[k] == q[k] || (std::isnan(p[k]) && std::isnan(q[k])))) return false;
    }
    return true;
  }

  /*! For StitchedVertices: calls closure with the entries of both ends for each edge on the border. Skips edges
   *  whose ends are equal, or not finite at the first time step. */
  template<typename Closure>
  void forEachBorderEdge(size_t i, const Closure& closure) const {
    if (!isValid(i)) return;
    const Grid grid = (*this)[i];
    for (int s = 0; s < 4; s++) {
      Entry before = Table::none;
      for (unsigned k = 0; k <= grid.quads(s & 1); k++) {
        const size_t vertex = grid.sideVertex(s, k);
        const Entry entry = cbvh::isFinite(position(vertex)) ? table.find(*this, vertex) : Table::none;
        if (before != Table::none && entry != Table::none && before != entry) closure(before, entry);
        before = entry;
      }
    }
  }

  /* Topology of border_lattices.h. Elements are entries of the table, which forEachShared() fills. */

  double spacingPerEdge() const { return Grids::spacingPerEdge(); }

  void extendBounds(size_t i, unsigned step, BBox3fa& bounds) const {
    if (!isValid(i)) return;
    forEachBorderVertex((*this)[i], [&](size_t vertex) {
      const float* p = position(vertex, step);
      if (cbvh::isFinite(p)) bounds.extend(Vec3fa(p[0], p[1], p[2]));
    });
  }

  bool addLines(size_t i, unsigned step, PatchVertices& memory, LatticeChoice& choice) const {
    if (!isValid(i)) return false;
    const Grid grid = (*this)[i];
    memory.setSize(max(grid.width, grid.height), 1);
    float(*line)[3] = memory.displaced();
    for (int d = 0; d < 2; d++)
      for (unsigned across : {0u, grid.quads(1 - d) / 2, grid.quads(1 - d)}) {
        for (unsigned i = 0; i <= grid.quads(d); i++)
          memcpy(line[i], position(d == 0 ? grid.vertex(i, across) : grid.vertex(across, i), step), sizeof(*line));
        choice.addLine(d == 0, line, grid.quads(d) + 1);
      }
    if (plan.settings.maxPixelError > 0)
      for (unsigned y = 0; y < grid.height; y++)
        for (unsigned x = 0; x < grid.width; x++) choice.extendBounds(position(grid.vertex(x, y), step));
    return true;
  }

  template<typename Closure>
  void forEachShared(size_t i, const Closure& closure) {
    if (!isValid(i)) return;
    forEachBorderVertex((*this)[i], [&](size_t vertex) { closure(table.add(*this, vertex)); });
  }

private:
  typedef PositionTable<GridBorders> Table;
  typedef typename Table::Entry Entry;

  /*! Calls closure for each border vertex once. */
  template<typename Closure>
  static void forEachBorderVertex(const Grid& grid, const Closure& closure) {
    for (int s = 0; s < 4; s++)
      for (unsigned k = 0; k < grid.quads(s & 1); k++) closure(grid.sideVertex(s, k));
  }

  const Grids grids;
  const CompressionPlan& plan;
  BorderLattices lattices;
  Table table; //!< vertices on borders; empty if none can be shared
  StitchedVertices<GridBorders> stitched;
};
} // namespace embree::isa
