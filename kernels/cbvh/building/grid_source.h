// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A source of patches (surface/source.h): the grids of a grid geometry, or regions of quad and triangle meshes that
 * form grids. All are stored as cVERT. */

#include "../surface/grid_patch.h"
#include "../exact/writer.h"

namespace embree::isa {
/*! Grids: see surface/diced_grids.h. */
template<typename Grids>
class GridSource {
  typedef typename Grids::Grid Grid;

public:
  typedef GridPatch<Grids> Patch;
  typedef typename Patch::Scratch Scratch;
  typedef typename Grids::Mesh Mesh;

  static const bool isDeterministic = true;

  GridSource(Mesh* mesh, const CompressionPlan& plan) : mesh(mesh), plan(plan), borders(mesh, plan) {}

  size_t size() const { return borders.size(); }

  size_t estimateBlocks() const {
    return sumOverGrids([](const Grid& grid) {
      return size_t(cbvh::vertBlocksAlong(grid.quads(0))) * cbvh::vertBlocksAlong(grid.quads(1));
    });
  }

  /*! For primitives that are in no grid but share vertices with one. */
  const StoredBorders& storedBorders() const { return borders; }

  size_t perTask(bool isSmall) const {
    if (isSmall) return max(size(), size_t(1));
    const size_t quads = sumOverGrids([](const Grid& grid) { return size_t(grid.quads(0)) * grid.quads(1); });
    return clamp(size() / (4 * TaskScheduler::threadCount()), size_t(1),
                 1 + quadsPerTask * size() / max(quads, size_t(1)));
  }

  template<typename Progress>
  void prepare(size_t perTask, const Progress& progress) {
    borders.build(perTask, [&] { progress(0.0); });
  }
  void release() { borders.release(); }

  /*! Quads with vertices that are not finite are skipped without an error, as in Embree. */
  bool isInvalid(size_t grid, bool) const { return borders.isError(grid); }

  size_t quadsWithoutSurface(size_t) const { return 0; }
  cbvh::InvalidVertex invalidVertex(size_t) const { return cbvh::InvalidVertex(); }
  bool isUnsupported(size_t) const { return false; }

  template<typename Closure>
  void forEachPatch(size_t grid, Scratch& scratch, const Closure& closure) const {
    if (!borders.isValid(grid)) return;
    Patch patch(borders, plan.surfaceNumber, grid, scratch);
    closure(patch);
  }

  size_t bytesInEmbree(const SurfacePatch& patch) const {
    return Grids::bytesInEmbree(patch.quads[0], patch.quads[1], plan.numTimeSteps, mesh->device);
  }

  class Writer {
  public:
    Writer(const GridSource& source, BlockStore& store, cbvh::BuildStatistics& statistics)
      : source(source),
        vert(source.plan, source.mesh->device, store, statistics) {}

    bool write(size_t, Patch& patch) {
      if (patch.quads[1] > VertWriter::rowsOfStrip(patch, source.plan.numTimeSteps)) return false;
      vert.write(patch, [](unsigned) { return (const float(*)[3]) nullptr; });
      return true;
    }

  private:
    const GridSource& source;
    VertWriter vert;
  };

private:
  static const size_t quadsPerTask = 1 << 14; //!< a task has at most this many on average, plus one grid

  template<typename Value>
  size_t sumOverGrids(const Value& value) const {
    return reduceRanges(
        size(), size_t(1024), size_t(0),
        [&](const range<size_t>& grids) {
          size_t n = 0;
          for (size_t i = grids.begin(); i != grids.end(); i++)
            if (borders.isValid(i)) n += value(borders[i]);
          return n;
        },
        std::plus<size_t>());
  }

  Mesh* mesh;
  const CompressionPlan& plan;
  GridBorders<Grids> borders;
};
} // namespace embree::isa
