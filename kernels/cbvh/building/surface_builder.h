// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds the blocks of a geometry, whose primitives a source enumerates (surface/source.h), and a BVH4 over them. A
 * task encodes several primitives, or a strip of a large patch. A scene builds its tree over subtrees of these BVHs
 * (blocks/tree.h). */

#include "../base/grid_soa_writer.h"
#include "../base/tasks.h"
#include "../exact/writer.h"
#include "build_results.h"
#include "irregular_blocks.h"
#include "../blocks/surface_blocks.h"
#include "../blocks/tree.h"
#include "../surface/invalid_input.h"
#include <functional>

namespace embree::isa {
class SurfaceBuilder {
public:
  virtual ~SurfaceBuilder() {}

  /*! True if building takes little time and memory. */
  virtual bool isSmall() const = 0;

  /*! True if building uses all threads and much temporary memory. */
  virtual bool isLarge() const = 0;

  /*! Builds the blocks. Call it once. Threads call progress(primitives) concurrently, with the number of primitives
   *  completed since their last call, or 0. It may throw to cancel the build. */
  virtual std::shared_ptr<const SurfaceBlocks> build(const std::function<void(double)>& progress) = 0;
};

/*! Bytes reserved per block: a cLEAF block of 16 x 16 quads has a header of 76 bytes, 85 nodes of 4 and 64 groups
 *  of 8 bytes. Most cVERT blocks are smaller. */
static const size_t expectedBlockBytes = 928;

/*! Bytes reserved per mesh block, about the size of one with 256 triangles. */
static const size_t expectedMeshBlockBytes = 1664, expectedMeshTileBytes = 2240;

/*! Builds the primitives of a source, and the irregular primitives of a mesh, those that are in no grid. */
template<typename Source>
class SourceBuilder final : public SurfaceBuilder {
  static_assert(isSource<Source>(), "see surface/source.h");
  typedef typename Source::Patch Patch;
  typedef std::function<void(double)> Progress;
  typedef std::function<bool(InvalidInput&)> FindInvalid;

public:
  /*! mesh and plan must outlive this object. irregular: blocks of primitives that are in no grid, or null.
   *  numInvalidQuads: quads that are in neither, for the statistics. findInvalid: finds the first primitive with a
   *  vertex that is not finite, if the source does not report it. */
  template<typename Mesh>
  SourceBuilder(Mesh* mesh, const std::shared_ptr<const cbvh::SurfaceNumber>& number, const CompressionPlan& plan,
                std::unique_ptr<IrregularBlocks> irregular = nullptr, size_t numInvalidQuads = 0,
                FindInvalid findInvalid = nullptr)
    : device(mesh->device),
      number(number),
      plan(plan),
      source(mesh, plan),
      irregular(std::move(irregular)),
      numInvalidQuads(numInvalidQuads),
      findInvalid(std::move(findInvalid)),
      progressPerPrimitive(double(mesh->size() - irregularSize()) / double(max(source.size(), size_t(1)))),
      estimatedBlocks(source.estimateBlocks() + (this->irregular ? this->irregular->estimateBlocks() : 0)),
      perTask(source.perTask(isSmall())) {}

  bool isSmall() const override { return estimatedBlocks <= isa::maxPartBlocks; }
  bool isLarge() const override { return estimatedBlocks > 4096; }

  std::shared_ptr<const SurfaceBlocks> build(const Progress& progress) override {
    std::shared_ptr<SurfaceBlocks> blocks = std::make_shared<SurfaceBlocks>(device, number);
    const size_t meshBlocks = irregular ? irregular->estimateBlocks() : 0, steps = plan.numTimeSteps;
    const size_t bytes =
        (estimatedBlocks - meshBlocks) * (plan.makesTiles() ? cbvh::expectedTileBytes * steps : expectedBlockBytes) +
        meshBlocks * (plan.makesTiles() ? expectedMeshTileBytes * steps : expectedMeshBlockBytes);
    if (!isSmall()) blocks->memory.reserve(bytes, estimatedBlocks * sizeof(BVH4::AABBNode) / 2);
    source.prepare(perTask, progress);
    if (irregular) irregular->prepare(bordersOf(source, 0), progress);
    mvector<PrimRef> prims(device, 0);
    {
      BuildResults results;
      buildPrimitives(*blocks, results, progress);
      source.release();
      if (irregular) irregular->release();
      std::shared_ptr<mvector<cbvh::StepBox>> boxes = std::make_shared<mvector<cbvh::StepBox>>(device, 0);
      results.collect(prims, *boxes);
      if (plan.moves()) blocks->boxes = boxes;
    }
    buildTree(*blocks, prims, progress);
    blocks->finish();
    return blocks;
  }

private:
  void buildPrimitives(SurfaceBlocks& blocks, BuildResults& results, const Progress& progress) {
    forRanges(source.size(), perTask,
              [&](const range<size_t>& primitives) { buildPrimitives(primitives, blocks.memory, results, progress); });
    if (irregular) irregular->build(blocks.memory, results, source.size(), progress);
    blocks.statistics = results.statistics;
    blocks.statistics.sums.numInvalidQuads += numInvalidQuads;
    InvalidInput invalid;
    if (blocks.statistics.sums.numInvalidQuads && !blocks.statistics.invalidFaces && findInvalid &&
        findInvalid(invalid)) {
      blocks.statistics.firstInvalidFace = invalid.primitive;
      blocks.statistics.firstInvalidVertex = invalid.vertex;
    }
    blocks.bounds = results.hitBounds.isEmpty() ? BBox3fa(empty) : toBBox(results.hitBounds);
  }

  void buildPrimitives(const range<size_t>& primitives, cbvh::BlockMemory& memory, BuildResults& results,
                       const Progress& progress) {
    typename Source::Scratch scratch(device);
    BlockStore store(device, &memory);
    cbvh::BuildStatistics statistics;
    typename Source::Writer writer(source, store, statistics);
    size_t reported = primitives.begin(), quads = 0, first = primitives.begin();
    unsigned firstPatch = 0; // of primitive `first`
    for (size_t i = primitives.begin(); i != primitives.end(); i++) {
      const size_t invalid = statistics.sums.numInvalidQuads;
      unsigned patchIndex = 0;
      source.forEachPatch(i, scratch, [&](Patch& patch) {
        if (!writer.write(i, patch)) {
          results.add(first, firstPatch, 0, store);
          buildStrips(i, patchIndex, patch, memory, results, statistics, progress);
          first = i;
          firstPatch = patchIndex + 1;
        }
        statistics.bytesInEmbree += source.bytesInEmbree(patch);
        quads += size_t(patch.quads[0]) * size_t(patch.quads[1]);
        patchIndex++;
      });
      if (const size_t missing = plan.compresses() ? source.quadsWithoutSurface(i) : 0) {
        statistics.sums.numInvalidQuads += missing;
        statistics.facesWithoutSurface++;
      }
      if (source.isInvalid(i, statistics.sums.numInvalidQuads != invalid))
        statistics.addInvalidFace(i, [&] { return source.invalidVertex(i); });
      if (plan.compresses() && source.isUnsupported(i)) statistics.addUnsupportedFace(i);
      if (quads >= progressQuads || i + 1 == primitives.end()) {
        progress(progressPerPrimitive * double(i + 1 - reported));
        reported = i + 1;
        quads = 0;
      }
    }
    results.add(first, firstPatch, 0, store);
    results.add(statistics);
  }

  /*! Builds a patch with many rows in strips, as separate tasks. Rows that two strips share are evaluated first if
   *  a second evaluation could differ. patchIndex: in the primitive. */
  void buildStrips(size_t primitive, unsigned patchIndex, const Patch& patch, cbvh::BlockMemory& memory,
                   BuildResults& results, cbvh::BuildStatistics& statistics, const Progress& progress) {
    const unsigned rows = VertWriter::rowsOfStrip(patch, plan.numTimeSteps), quadsX = patch.quads[0],
                   quadsY = patch.quads[1], strips = (quadsY + rows - 1) / rows;
    const size_t width = quadsX + 1, seamVertices = width * plan.numTimeSteps;
    // rows between strips, per time step
    mvector<float> seams(device, Source::isDeterministic ? 0 : 3 * seamVertices * (strips - 1));
    auto seam = [&](unsigned s) {
      return Source::isDeterministic ? nullptr : (float(*)[3])(seams.data() + 3 * seamVertices * s);
    };
    if (!Source::isDeterministic)
      parallel_for(1u, strips, 1u, [&](const range<unsigned>& r) {
        typename Source::Scratch scratch(device);
        Patch own(patch, scratch);
        for (unsigned s = r.begin(); s != r.end(); s++)
          for (unsigned step = 0; step < plan.numTimeSteps; step++)
            memcpy(seam(s - 1) + width * step,
                   own.evaluate(quadsX, quadsY, PatchPart{0, quadsX, s * rows, s * rows}, step).displaced(),
                   width * sizeof(float[3]));
      });
    MutexSys mutex;
    parallel_for(0u, strips, 1u, [&](const range<unsigned>& r) {
      typename Source::Scratch scratch(device);
      Patch own(patch, scratch);
      cbvh::BuildStatistics stripStatistics;
      for (unsigned s = r.begin(); s != r.end(); s++) {
        BlockStore store(device, &memory);
        const PatchPart strip = {0, quadsX, s * rows, min((s + 1) * rows, quadsY)};
        VertWriter(plan, device, store, stripStatistics)
            .write(own, strip, s == 0 ? nullptr : seam(s - 1), s + 1 == strips ? nullptr : seam(s));
        results.add(primitive, patchIndex, s + 1, store);
        progress(0.0);
      }
      Lock<MutexSys> lock(mutex);
      statistics.merge(stripStatistics);
    });
  }

  /*! Builds the tree over the blocks and divides it into parts for the trees of scenes. Moving blocks have no tree.
   *  If there are few blocks, each is a part, without a tree. */
  void buildTree(SurfaceBlocks& blocks, mvector<PrimRef>& prims, const Progress& progress) {
    blocks.numPrimRefs = prims.size();
    for (const PrimRef& prim : prims) {
      blocks.bounds.extend(prim.bounds());
      size_t type;
      BVH4::NodeRef(prim.ID()).leaf(type);
      blocks.types |= 1u << type;
    }
    if (plan.moves()) {
      cbvh::resizeToFit(blocks.moving, prims.size());
      for (size_t i = 0; i < prims.size(); i++) blocks.moving[i] = prims[i].ID();
      return;
    }
    if (!blocks.memory.pool() || prims.size() <= isa::maxPartBlocks) {
      blocks.parts = std::move(prims);
      return;
    }
    size_t nodes = 0;
    FastAllocator& memory = *blocks.memory.pool();
    blocks.root = isa::moveLargestNodes(isa::buildTree(memory, prims, [&] { progress(0.0); }, nodes), nodes, memory);
    blocks.statistics.sums.topLevelBytes = nodes * sizeof(BVH4::AABBNode);
    isa::TreeCutter(blocks.parts).cut(blocks.root, blocks.bounds);
  }

  /*! Returns null if the source has no storedBorders(). Call it with 0: overload resolution prefers int to long. */
  template<typename S>
  static auto bordersOf(const S& source, int) -> decltype(&source.storedBorders()) {
    return &source.storedBorders();
  }
  template<typename S>
  static const StoredBorders* bordersOf(const S&, long) {
    return nullptr;
  }

  size_t irregularSize() const { return irregular ? irregular->numPrimitives() : 0; }

  Device* device;
  const std::shared_ptr<const cbvh::SurfaceNumber> number;
  const CompressionPlan& plan;
  Source source;
  const std::unique_ptr<IrregularBlocks> irregular;
  const size_t numInvalidQuads;
  const FindInvalid findInvalid;
  const double progressPerPrimitive; //!< primitives of the geometry per primitive of the source
  const size_t estimatedBlocks;
  const size_t perTask;
};
} // namespace embree::isa
