// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writer of the paper's representations: divides patches of a cage into blocks with frames (tiling.h), encodes them,
 * and appends them to a store. Each task owns a writer. */

#include "block_encoder.h"
#include "tiling.h"
#include "../base/grid_soa_writer.h"
#include "../surface/cage_patch.h"
#include "spread_borders.h"

namespace embree::isa {
class FramedWriter {
public:
  /*! If plan.sharesBorders(), faces share the vertices of borders (surface/shared_border.h), and write() may return
   *  false. The arguments must outlive the writer. */
  FramedWriter(const CompressionPlan& plan, SubdivMesh* mesh, BlockStore& store, cbvh::BuildStatistics& statistics)
    : plan(plan),
      sharesBorders(plan.sharesBorders()),
      store(store),
      statistics(statistics),
      gridWriter(mesh, store, statistics, false),
      unsharedVertices(mesh->device, 0),
      vertices(mesh->device, 0),
      scratch(mesh->device, 0),
      encoded(mesh->device, 0) {}

  /*! Returns the smallest frame level at which no leaf is thicker than the setting maxError, or the patch's level.
   *  Encodes blocks to measure this, but writes nothing. */
  unsigned boundedFrameLevel(CagePatch& patch) {
    const unsigned level = levelOf(patch.rate);
    PatchTiling evaluatedTiling;
    for (unsigned n = 0; n < level; n++) {
      const PatchTiling tiling = tilingOf(plan.kind(), patch.rate, n);
      if (tiling.quadsX() != evaluatedTiling.quadsX() || tiling.quadsY() != evaluatedTiling.quadsY())
        evaluate(patch, tiling);
      evaluatedTiling = tiling;
      cbvh::BlockStatistics levelStatistics; // of all blocks
      for (unsigned i = 0; i < tiling.size() && levelStatistics.maxThickness <= plan.settings.maxError; i++) {
        TiledBlock tiled(plan.kind(), tiling, i);
        encoded.resize(tiled.layout.bytes / sizeof(Vec3fa) + 1);
        loadBlock(tiled);
        cbvh::BlockEncoder encoder(tiled.kind, tiled.height, vertexData(), scratch.data());
        if (encoder.fit(tiled.corners)) encoder.encode((cbvh::Block*)encoded.data(), tiled.x, tiled.y, levelStatistics);
      }
      if (levelStatistics.maxThickness <= plan.settings.maxError) return n;
    }
    return level;
  }

  /*! Writes a patch. Returns false, and writes nothing, if the caller should store the patch as cVERT. */
  bool write(CagePatch& patch, const PatchTiling& tiling) {
    evaluate(patch, tiling);
    /* holes: quads with vertices that are not finite */
    float lower[3], upper[3];
    const bool hasHoles = !patchVertices->bounds(lower, upper);
    const bool supportsHoles = cbvh::descriptionOf(plan.kind()).supportsHoles;
    const cbvh::Kind kind = hasHoles && !supportsHoles ? kindForHoles : plan.kind();
    const uint32_t sharpSides = patch.sharpSides();
    const size_t count = tiling.size(), stride = cbvh::blockLayout(uint32_t(kind), tiling.height).stride;
    encoded.resize(count * stride / sizeof(Vec3fa));
    blockBounds.assign(count, BBox3fa(empty));
    cbvh::BuildStatistics patchStatistics;
    cbvh::WorldBounds patchHitBounds;
    if (!hasHoles) { // for speed: nodes inside these bounds need no visit
      patchHitBounds.extend(lower[0], lower[1], lower[2]);
      patchHitBounds.extend(upper[0], upper[1], upper[2]);
    }
    leafFit = cbvh::LeafFit();
    const size_t numQuads = size_t(tiling.quadsX()) * size_t(tiling.quadsY());
    /* up to two per quad on the border: a block of one quad has four leaves */
    const size_t maxEdges = 4 * (size_t(tiling.quadsX()) + size_t(tiling.quadsY()));
    for (size_t k = 0; k < count; k++) {
      /* in diagonal order, so that the first blocks are a sample of the patch */
      const unsigned y = unsigned(k) % tiling.y, x = (y + unsigned(k) / tiling.y) % tiling.x;
      TiledBlock tiled(kind, tiling, y * tiling.x + x);
      tiled.sharpSides = sharpSides & tiled.sidesOfPatch();
      cbvh::Block* const block = (cbvh::Block*)((char*)encoded.data() + tiled.index * stride);
      writeBlock(patch, tiled, block, patchStatistics, patchHitBounds);
      if (sharesBorders && patchStatistics.framelessQuads) return false;
      if (sharesBorders && leafFit.isClearlyPoor(numQuads, maxEdges)) return false;
    }
    if (sharesBorders && leafFit.isPoor()) return false;
    if (kind != plan.kind()) statistics.quadsForHoles += numQuads;
    statistics.merge(patchStatistics);
    store.hitBounds.extend(patchHitBounds);
    for (size_t i = 0; i < count; i++)
      if (!blockBounds[i].empty())
        store.add((char*)encoded.data() + i * stride, stride, blockBounds[i], cbvh::FRAMED_BLOCK);
    store.flush();
    return true;
  }

  /*! Returns the vertices of the last patch before borders were shared, or null if they were evaluated with another
   *  number of quads. Requires plan.sharesBorders(). */
  const float (*evaluatedVertices(unsigned quadsX, unsigned quadsY) const)[3] {
    const bool isEvaluated = patchVertices && patchVertices->width == quadsX + 1 && patchVertices->height == quadsY + 1;
    return isEvaluated ? (const float(*)[3])unsharedVertices.data() : nullptr;
  }

private:
  static const cbvh::Kind kindForHoles = cbvh::Kind::CLEAF;

  struct TiledBlock {
    cbvh::Kind kind;
    PatchTiling tiling;
    unsigned height;
    unsigned index, x, y;    //!< position of the block in the tiling
    uint32_t sharpSides = 0; //!< see BlockEncoder::encode
    cbvh::BlockLayout layout;
    float corners[4][3]; //!< corners to which the frame is aligned

    TiledBlock(cbvh::Kind kind, const PatchTiling& tiling, unsigned index)
      : kind(kind),
        tiling(tiling),
        height(tiling.height),
        index(index),
        x(index % tiling.x),
        y(index / tiling.x),
        layout(cbvh::blockLayout(uint32_t(kind), height)) {}

    size_t width() const { return (size_t(1) << height) + 1; }

    /*! Mask of the patch's sides at which the block is, numbered as in surface/source.h. */
    uint32_t sidesOfPatch() const {
      return uint32_t(y == 0) | uint32_t(x + 1 == tiling.x) << 1 | uint32_t(y + 1 == tiling.y) << 2 |
             uint32_t(x == 0) << 3;
    }
  };

  /*! Evaluates a patch, shares its borders if `sharesBorders`, and spreads them. */
  void evaluate(CagePatch& patch, const PatchTiling& tiling) {
    const PatchPart all = {0, tiling.quadsX(), 0, tiling.quadsY()};
    patchVertices = &patch.evaluate(tiling.quadsX(), tiling.quadsY(), all, 0);
    isStitched = tiling.quadsX() != unsigned(min(patch.rate[0], patch.rate[2])) ||
                 tiling.quadsY() != unsigned(min(patch.rate[1], patch.rate[3]));
    if (!sharesBorders) {
      if (!isStitched) return;
      spreadBorders(patch.rate, *patchVertices, patchVertices->undisplaced());
      spreadBorders(patch.rate, *patchVertices, patchVertices->displaced());
      return;
    }
    const size_t count = 3 * patchVertices->width * patchVertices->height;
    unsharedVertices.resize(count);
    memcpy(unsharedVertices.data(), patchVertices->displaced(), count * sizeof(float));
    shareBorder(patch, 0, tiling.quadsX(), tiling.quadsY(), all, (const float(*)[3])unsharedVertices.data(),
                patchVertices->displaced(), statistics);
    float rate[4];
    for (int s = 0; s < 4; s++) rate[s] = float(patch.side(s, 0).rate);
    spreadBorders(patch.rate, *patchVertices, patchVertices->undisplaced());
    spreadBorders(rate, *patchVertices, patchVertices->displaced());
  }

  const float (*vertexData() const)[3] { return (const float(*)[3])vertices.data(); }

  /*! Sets `vertices` and tiled.corners, and resizes `scratch`. */
  void loadBlock(TiledBlock& tiled) {
    const size_t w = tiled.width();
    const size_t x0 = size_t(tiled.x) << tiled.height, y0 = size_t(tiled.y) << tiled.height;
    vertices.resize(3 * w * w);
    scratch.resize((cbvh::BlockEncoder::scratchBytes(tiled.height) + sizeof(Vec3fa) - 1) / sizeof(Vec3fa));
    for (size_t r = 0; r < w; r++)
      memcpy(&vertices[3 * r * w], patchVertices->displaced()[(y0 + r) * patchVertices->width + x0],
             3 * w * sizeof(float));
    const bool alignsToLimit = cbvh::descriptionOf(tiled.kind).alignsToLimit;
    float(*aligned)[3] = alignsToLimit ? patchVertices->undisplaced() : patchVertices->displaced();
    for (size_t c = 0; c < 4; c++)
      memcpy(tiled.corners[c], aligned[(y0 + (c >> 1) * (w - 1)) * patchVertices->width + x0 + (c & 1) * (w - 1)],
             sizeof(float[3]));
  }

  size_t countFinite(const TiledBlock& tiled) const {
    size_t finite = 0;
    for (size_t i = 0; i < tiled.width() * tiled.width(); i++) finite += cbvh::isFinite(vertexData()[i]);
    return finite;
  }

  /*! Encodes a block to `block`, and sets its blockBounds. If the kind cannot represent the quads, writes
   *  them to the store as GRID or cGRID instead. Writes nothing if they are invalid or the patch becomes cVERT. */
  void writeBlock(const CagePatch& patch, TiledBlock& tiled, cbvh::Block* block, cbvh::BuildStatistics& patchStatistics,
                  cbvh::WorldBounds& patchHitBounds) {
    loadBlock(tiled);
    const size_t count = tiled.width() * tiled.width(), finite = countFinite(tiled);
    if (finite == 0) {
      countAsInvalid(tiled, patchStatistics);
      return;
    }

    cbvh::BlockEncoder encoder(tiled.kind, tiled.height, vertexData(), scratch.data());
    const bool fits = encoder.fit(tiled.corners);
    const bool isFrameless = !fits || encoder.isDegenerate();
    const unsigned quadsPerSide = 1u << tiled.height;
    const size_t numQuads = size_t(quadsPerSide) * size_t(quadsPerSide);
    if (isFrameless && sharesBorders) {
      patchStatistics.framelessQuads += numQuads;
      return; // the patch becomes cVERT
    }
    if (isFrameless && finite == count && !isStitched) {
      patchStatistics.framelessQuads += numQuads;
      patchStatistics.framelessQuadsInGrid += numQuads;
      gridWriter.write(patch.embreePatch(), tiled.x * quadsPerSide, (tiled.x + 1) * quadsPerSide,
                       tiled.y * quadsPerSide, (tiled.y + 1) * quadsPerSide);
      return;
    }
    if (!fits) {
      countAsInvalid(tiled, patchStatistics);
      return;
    }
    if (isFrameless && tiled.kind != cbvh::Kind::CGRID) {
      /* GridSOA supports no holes, and does not spread stitched borders, unlike adjacent blocks. The triangles of
       * cGRID are exact in any frame. */
      patchStatistics.framelessQuads += numQuads;
      TiledBlock cgridBlock(cbvh::Kind::CGRID, tiled.tiling, tiled.index);
      avector<Vec3fa> memory(cgridBlock.layout.stride / sizeof(Vec3fa));
      const BBox3fa before = blockBounds[tiled.index];
      writeBlock(patch, cgridBlock, (cbvh::Block*)memory.data(), patchStatistics, patchHitBounds);
      if (!blockBounds[tiled.index].empty())
        store.add(memory.data(), cgridBlock.layout.stride, blockBounds[tiled.index], cbvh::FRAMED_BLOCK);
      blockBounds[tiled.index] = before;
      return;
    }

    cbvh::BlockStatistics blockStatistics;
    blockStatistics.maxThickness = statistics.sums.maxLeafThickness; // thinner leaves need not be measured
    encoder.encode(block, tiled.x, tiled.y, blockStatistics, tiled.sharpSides);
    block->surface = patch.surfaceNumber;
    block->primID = patch.primID;
    block->tiling = cbvh::blockTiling(tiled.tiling.x - 1, tiled.tiling.y - 1, patch.corner[0], patch.corner[1]);
    addToStatistics(patchStatistics, tiled, blockStatistics);
    leafFit.merge(blockStatistics.leafFit);
    encoder.extendByHits(patchHitBounds, block);
    blockBounds[tiled.index] = toBBox(encoder.surfaceBounds());
  }

  static void addToStatistics(cbvh::BuildStatistics& statistics, const TiledBlock& tiled,
                              const cbvh::BlockStatistics& block) {
    cbvh::CompressionStatistics& sums = statistics.sums;
    sums.headerBytes += cbvh::blockHeaderBytes;
    sums.nodeBytes += tiled.layout.leafOffset - cbvh::blockHeaderBytes;
    sums.leafBytes += tiled.layout.stride - tiled.layout.leafOffset;
    sums.numBlocks++;
    sums.numQuads += size_t(1) << (2 * tiled.height);
    sums.numInvalidQuads += block.invalidQuads;
    sums.numAffineBlocks += block.affine;
    sums.numSolidLeaves += block.solidLeaves;
    sums.numFlippedQuads += block.leafFit.flippedQuads;
    sums.maxLeafThickness = max(sums.maxLeafThickness, block.maxThickness);
  }

  static void countAsInvalid(const TiledBlock& tiled, cbvh::BuildStatistics& patchStatistics) {
    patchStatistics.sums.numInvalidQuads += size_t(1) << (2 * tiled.height);
  }

  const CompressionPlan& plan;
  const bool sharesBorders;
  BlockStore& store;
  cbvh::BuildStatistics& statistics;
  const GridSOAWriter gridWriter;
  cbvh::LeafFit leafFit; //!< of the current patch
  PatchVertices* patchVertices = nullptr;
  bool isStitched = false;          //!< an edge has a lower rate than the patch has quads
  std::vector<BBox3fa> blockBounds; //!< by position in the tiling; empty for blocks that were not encoded
  mvector<float> unsharedVertices;  //!< see evaluatedVertices()
  mvector<float> vertices;          //!< vertices of one block
  mvector<Vec3fa> scratch;
  mvector<Vec3fa> encoded; //!< blocks of a patch, or one block of boundedFrameLevel()
};
} // namespace embree::isa
