// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The faces of a cage as a source of patches (surface/source.h). Patches become blocks of the requested kind, or of
 * another one if it cannot represent them (paper/writer.h). They become Embree's grids if the geometry is not
 * compressed, or if blocks do not support their edge rates. Parts of a patch without a valid frame can also become
 * grids (FramedWriter::writeBlock). */

#include "../base/tasks.h"
#include "../surface/cage_patch.h"
#include "../surface/embree_bytes.h"
#include "../exact/writer.h"
#if defined(EMBREE_CBVH_NO_PAPER)
#include "no_framed_writer.h"
#else
#include "../paper/writer.h"
#endif

namespace embree::isa {
class CageSource {
public:
  typedef CagePatch Patch;
  typedef PatchEvaluator Scratch;

  static const bool isDeterministic = false; //!< displacement functions may return other values each time

  CageSource(SubdivMesh* mesh, const CompressionPlan& plan)
    : mesh(mesh),
      plan(plan),
      frameLevel(mesh->device, plan.maxErrorSetsFrameLevel() ? mesh->size() : 0),
      holes(sortedHoles(mesh)) {}

  size_t size() const { return mesh->size(); }

  /*! Exact unless a bound on the error selects frame levels, faces fall back to cVERT, or blocks are left out. */
  size_t estimateBlocks() const {
    return reduceRanges(
        mesh->size(), size_t(64), size_t(0),
        [&](const range<size_t>& faces) {
          size_t n = 0;
          for (size_t f = faces.begin(); f != faces.end(); f++)
            if (hasSurface(mesh, f))
              isa::forEachPatch(mesh, f, [&](const PatchOfFace& patch) { n += estimateBlocks(patch); });
          return n;
        },
        std::plus<size_t>());
  }

  /*! Tasks of large surfaces are small, because faces can cost milliseconds and differ widely. */
  size_t perTask(bool isSmall) const {
    return isSmall ? max(mesh->size(), size_t(1))
                   : clamp(mesh->size() / (4 * TaskScheduler::threadCount()), size_t(1), size_t(8));
  }

  template<typename Progress>
  void prepare(size_t perTask, const Progress& progress) {
    if (plan.sharesBorders()) {
      borders.reset(new CageBorders(mesh, plan));
      borders->build(perTask, [&] { progress(0.0); });
    }
    if (plan.maxErrorSetsFrameLevel()) chooseFrameLevels(perTask, progress);
  }

  void release() { borders.reset(); }

  template<typename Closure>
  void forEachPatch(size_t face, PatchEvaluator& evaluator, const Closure& closure) const {
    if (!hasSurface(mesh, face)) return;
    isa::forEachPatch(mesh, face, [&](const PatchOfFace& patch) {
      CagePatch cagePatch(mesh, plan.surfaceNumber, face, patch, borders.get(), evaluator);
      closure(cagePatch);
    });
  }

  /*! Invalid quads come from displacement functions and from control vertices. */
  bool isInvalid(size_t, bool hasInvalidQuads) const { return hasInvalidQuads; }

  /*! Quads of a face that has no surface at any step because vertices are not finite. 0 for other faces. */
  size_t quadsWithoutSurface(size_t face) const {
    if (hasSurface(mesh, face) || !hasEdges(mesh, face) || isHole(face)) return 0;
    if (!canBeEvaluated(mesh->getHalfEdge(0, face), mesh->faceVertices[face])) return 0;
    unsigned timeStep;
    if (findInvalidVertex(mesh, face, timeStep) == noVertex) return 0; // RTC_SUBDIVISION_MODE_NO_BOUNDARY
    size_t quads = 0;
    isa::forEachPatch(mesh, face, [&](const PatchOfFace& patch) {
      const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
      quads += size_t(size.x - 1) * size_t(size.y - 1);
    });
    return quads;
  }

  cbvh::InvalidVertex invalidVertex(size_t face) const {
    cbvh::InvalidVertex found;
    if (canBeEvaluated(mesh->getHalfEdge(0, face), mesh->faceVertices[face]))
      found.vertex = findInvalidVertex(mesh, face, found.timeStep);
    return found;
  }

  bool isUnsupported(size_t face) const { return !hasSurface(mesh, face) && isa::isUnsupported(mesh, face, holes); }

  size_t bytesInEmbree(const SurfacePatch& patch) const {
    const Vec2i quads(int(patch.quads[0]), int(patch.quads[1]));
    return bytesOfMovingGrids(GridSOAWriter::bytesOfPatch(quads), plan.numTimeSteps);
  }

  class Writer {
  public:
    Writer(const CageSource& source, BlockStore& store, cbvh::BuildStatistics& statistics)
      : source(source),
        plan(source.plan),
        store(store),
        statistics(statistics),
        framedWriter(plan, source.mesh, store, statistics),
        vertWriter(plan, source.mesh->device, store, statistics),
        gridWriter(source.mesh, store, statistics, plan.compresses()) {} // GRID alone reports no errors, as in Embree

    /*! Returns false if the patch must be written in strips. */
    bool write(size_t face, CagePatch& patch) {
      switch (plan.storage(patch.rate)) {
      case CompressionPlan::GRID:
        store.flush();
        gridWriter.write(patch.embreePatch());
        if (plan.compresses()) statistics.highRateQuads += size_t(patch.quads[0]) * size_t(patch.quads[1]);
        break;
      case CompressionPlan::FRAMED:
        if (!framedWriter.write(patch, source.tilingOf(face, patch.rate)))
          vertWriter.write(patch,
                           [&](unsigned) { return framedWriter.evaluatedVertices(patch.quads[0], patch.quads[1]); });
        break;
      case CompressionPlan::VERT:
        if (patch.quads[1] > VertWriter::rowsOfStrip(patch, plan.numTimeSteps)) return false;
        vertWriter.write(patch, [&](unsigned step) { return patch.cachedVertices(step); });
        break;
      }
      return true;
    }

  private:
    const CageSource& source;
    const CompressionPlan& plan;
    BlockStore& store;
    cbvh::BuildStatistics& statistics;
    FramedWriter framedWriter;
    VertWriter vertWriter;
    const GridSOAWriter gridWriter;
  };

private:
  bool isHole(size_t face) const { return std::binary_search(holes.begin(), holes.end(), unsigned(face)); }

  size_t estimateBlocks(const PatchOfFace& patch) const {
    const CompressionPlan::Storage storage = plan.storage(patch.rate);
    if (storage == CompressionPlan::FRAMED)
      return isa::tilingOf(plan.kind(), patch.rate, plan.frameLevel(levelOf(patch.rate))).size();
    const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
    const unsigned side = storage == CompressionPlan::VERT ? cbvh::vertBlockQuads : GridSOAWriter::gridQuads;
    return size_t(unsigned(size.x - 2) / side + 1) * size_t(unsigned(size.y - 2) / side + 1);
  }

  PatchTiling tilingOf(size_t f, const float rate[4]) const {
    return isa::tilingOf(plan.kind(), rate,
                         plan.maxErrorSetsFrameLevel() ? frameLevel[f] : plan.frameLevel(levelOf(rate)));
  }

  /*! Sets the frame level of each face to the highest level that one of its patches needs to keep max_error.
   *  FramedWriter::boundedFrameLevel() encodes blocks on trial. Call it once per build: a second call could choose
   *  other levels, because displacement functions may return other values. */
  template<typename Progress>
  void chooseFrameLevels(size_t perTask, const Progress& progress) {
    forRanges(frameLevel.size(), perTask, [&](const range<size_t>& faces) {
      PatchEvaluator evaluator(mesh->device);
      BlockStore discarded(mesh->device, nullptr);
      cbvh::BuildStatistics trialStatistics;
      FramedWriter trial(plan, mesh, discarded, trialStatistics);
      size_t quads = 0;
      for (size_t f = faces.begin(); f != faces.end(); f++) {
        unsigned n = 0;
        forEachPatch(f, evaluator, [&](CagePatch& patch) {
          if (plan.storage(patch.rate) != CompressionPlan::FRAMED) return;
          n = max(n, trial.boundedFrameLevel(patch));
          quads += size_t(patch.quads[0]) * size_t(patch.quads[1]);
        });
        frameLevel[f] = (unsigned char)n;
        if (quads >= progressQuads) {
          progress(0.0);
          quads = 0;
        }
      }
    });
  }

  SubdivMesh* mesh;
  const CompressionPlan& plan;
  mvector<unsigned char> frameLevel;    //!< by face; empty unless maxErrorSetsFrameLevel()
  std::unique_ptr<CageBorders> borders; //!< null if faces share no borders, and outside of prepare() to release()
  const std::vector<unsigned> holes;    //!< see isa::isUnsupported
};
} // namespace embree::isa
