// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writer of cVERT: turns the patches of a source (surface/source.h) into blocks, and appends them to a store. Rounds
 * vertices to the patch's lattice, and border vertices to lattices that patches share (surface/shared_border.h);
 * encoding is then lossless. Several tasks can write strips of one patch, each with its own writer and store. A strip
 * is a range of rows of quads, which bounds the memory of a task. The caller must flush the store after the last
 * patch. */

#include "../base/block_bytes.h"
#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../surface/plan.h"
#include "../surface/source.h"
#include "../base/codec_names.h"
#include "../../cvert/encoder/moving_tile_encoder.h"
#include "../../cvert/encoder/prim_id_encoder.h"
#include "../../cvert/encoder/snapped_vertices.h"
#include "../../cvert/encoder/tile_encoder.h"

namespace embree::isa {
class VertWriter {
public:
  /*! The arguments must outlive the writer. */
  VertWriter(const CompressionPlan& plan, Device* device, BlockStore& store, cbvh::BuildStatistics& statistics)
    : plan(plan),
      store(store),
      statistics(statistics),
      evaluatedVertices(device),
      stepVertices(device, 0) {}

  /*! Rows of quads per strip: a multiple of vertBlockQuads, because strips consist of whole rows of blocks. A strip
   *  has at most stripQuads quads, counted once per time step, unless one row of blocks has more. */
  static unsigned rowsOfStrip(const SurfacePatch& patch, unsigned numTimeSteps) {
    return max(stripQuads / (patch.quads[0] * cbvh::vertBlockQuads * numTimeSteps), 1u) * cbvh::vertBlockQuads;
  }

  /*! Writes a patch as a single strip. verticesAt(step): displaced vertices of the patch at a time step, row by
   *  row, or null if the caller has not evaluated them. */
  template<typename Patch, typename VerticesAt>
  void write(Patch& patch, const VerticesAt& verticesAt) {
    const PatchPart strip = {0, patch.quads[0], 0, patch.quads[1]};
    writeStrip(patch, strip, [&](const PatchPart& strip, unsigned step) -> PatchVertices& {
      const float(*vertices)[3] = verticesAt(step);
      if (!vertices) return patch.evaluate(patch.quads[0], patch.quads[1], strip, step);
      evaluatedVertices.set(patch.quads[0], patch.quads[1], vertices);
      return evaluatedVertices;
    });
  }

  /*! Writes a strip, which must begin at a multiple of vertBlockQuads rows. firstRow, lastRow: displaced vertices
   *  of the strip's first and last row, step by step, or null to evaluate them. Strips that share a row must use
   *  the same vertices: pass them unless the source is deterministic. */
  template<typename Patch>
  void write(Patch& patch, const PatchPart& strip, const float (*firstRow)[3], const float (*lastRow)[3]) {
    writeStrip(patch, strip, [&](const PatchPart& strip, unsigned step) -> PatchVertices& {
      PatchVertices& vertices = patch.evaluate(patch.quads[0], patch.quads[1], strip, step);
      const size_t rowBytes = vertices.width * sizeof(float[3]);
      float(*first)[3] = vertices.displaced(), (*last)[3] = first + (vertices.height - 1) * vertices.width;
      if (firstRow) memcpy(first, firstRow + step * vertices.width, rowBytes);
      if (lastRow) memcpy(last, lastRow + step * vertices.width, rowBytes);
      return vertices;
    });
  }

private:
  static const unsigned stripQuads = 256 * 256; //!< see rowsOfStrip

  template<typename Patch, typename Evaluate>
  void writeStrip(const Patch& patch, const PatchPart& strip, const Evaluate& evaluate) {
    for (int s = 0; s < 4; s++) sideRates[s] = patch.side(s, 0).rate;
    if (plan.moves()) writeMovingStrip(patch, strip, evaluate);
    else {
      PatchVertices& vertices = evaluate(strip, 0);
      statistics.sums.numFlippedQuads += snapVertices(patch, 0, strip, vertices);
      forEachBlock(patch, strip, [&](unsigned x, unsigned y, unsigned w, unsigned h) {
        copyBlock(vertices.displaced(), vertices.width, x, y - strip.y0, w, h, encoder.vertices);
        writeBlock(patch, x, y, w, h);
      });
    }
    store.flushIfFull();
  }

  template<typename Patch, typename Evaluate>
  void writeMovingStrip(const Patch& patch, const PatchPart& strip, const Evaluate& evaluate) {
    const size_t width = strip.x1 - strip.x0 + 1, count = width * (strip.y1 - strip.y0 + 1);
    stepVertices.reserve(3 * count * plan.numTimeSteps); // resize alone would grow to a power of two
    stepVertices.resize(3 * count * plan.numTimeSteps);
    auto verticesOfStep = [&](unsigned step) { return (float(*)[3])stepVertices.data() + count * step; };
    size_t flipped = 0; // at the step with the most
    for (unsigned step = 0; step < plan.numTimeSteps; step++) {
      PatchVertices& vertices = evaluate(strip, step);
      flipped = max(flipped, snapVertices(patch, step, strip, vertices));
      memcpy(verticesOfStep(step), vertices.displaced(), count * sizeof(float[3]));
    }
    statistics.sums.numFlippedQuads += flipped;
    forEachBlock(patch, strip, [&](unsigned x, unsigned y, unsigned w, unsigned h) {
      writeMovingBlock(patch, x, y, w, h, [&](unsigned step, float(*out)[3]) {
        copyBlock(verticesOfStep(step), width, x, y - strip.y0, w, h, out);
      });
    });
  }

  template<typename Closure>
  static void forEachBlock(const SurfacePatch& patch, const PatchPart& strip, const Closure& closure) {
    for (unsigned y = strip.y0; y < strip.y1; y += cbvh::vertBlockQuads)
      for (unsigned x = 0; x < patch.quads[0]; x += cbvh::vertBlockQuads)
        closure(x, y, min(cbvh::vertBlockQuads, patch.quads[0] - x), min(cbvh::vertBlockQuads, patch.quads[1] - y));
  }

  /*! Copies the vertices of a block of w x h quads. width: row length of `vertices`. x, y: column and row of the
   *  block's first vertex there. */
  static void copyBlock(const float (*vertices)[3], size_t width, unsigned x, unsigned y, unsigned w, unsigned h,
                        float (*out)[3]) {
    for (unsigned r = 0; r <= h; r++)
      memcpy(out[r * (w + 1)], vertices[(y + r) * width + x], (w + 1) * sizeof(float[3]));
  }

  void writeBlock(const SurfacePatch& patch, unsigned x, unsigned y, unsigned w, unsigned h) {
    const cbvh::VertPlacement placement = choosePlacement(patch, x, y, w, h);
    cbvh::VertStatistics blockStatistics;
    static const size_t maxBytes = max(cbvh::VertEncoder::maxBytes, cbvh::TileEncoder::maxBytes);
    uint8_t* const bytes = store.reserve(maxBytes + cbvh::NumbersEncoder::maxBytes);
    size_t size = plan.makesTiles() ? encodeTile(placement, bytes, blockStatistics) : 0;
    if (size == 0) size = encoder.encode(placement, bytes, blockStatistics);
    if (size == 0) {
      statistics.sums.numInvalidQuads += size_t(w) * h;
      return;
    }
    cbvh::WorldBounds bounds;
    extend(bounds, encoder);
    commitBlock(patch, (cbvh::VertHeader*)bytes, size, blockStatistics, bounds);
  }

  /*! Returns 0 if the vertices remain a block. */
  size_t encodeTile(const cbvh::VertPlacement& placement, uint8_t* bytes, cbvh::VertStatistics& blockStatistics) {
    encoder.setSize(placement.region);
    encoder.computeBounds();
    if (!encoder.anyFinite()) return 0;
    const size_t size = tileEncoder.encode(encoder, placement, bytes);
    if (size && !encoder.allFinite) blockStatistics.invalidQuads += encoder.countInvalidQuads();
    return size;
  }

  /*! copy(step,out) must store the block's vertices at a time step. */
  template<typename Copy>
  void writeMovingBlock(const SurfacePatch& patch, unsigned x, unsigned y, unsigned w, unsigned h, const Copy& copy) {
    const cbvh::VertPlacement placement = choosePlacement(patch, x, y, w, h);
    cbvh::WorldBounds bounds;
    cbvh::MotionStatistics blockStatistics;
    size_t size = 0;
    if (plan.makesTiles() && w * h >= cbvh::minTileQuads)
      size = encodeSteps(movingTileEncoder, placement, copy, bounds, blockStatistics);
    if (size == 0) size = encodeSteps(movingEncoder, placement, copy, bounds, blockStatistics);
    if (size == 0) {
      statistics.sums.numInvalidQuads += size_t(w) * h;
      return;
    }
    uint8_t* const bytes = store.reserve(0);
    statistics.sums.numMovingQuads += size_t(w) * h;
    statistics.sums.motionBytes += blockStatistics.stepBytes;
    commitBlock(patch, (cbvh::VertHeader*)bytes, size, blockStatistics, bounds);
  }

  /*! Encodes the steps at the end of the store, and adds their boxes. Returns 0, without boxes, if the encoder does. */
  template<typename Encoder, typename Copy>
  size_t encodeSteps(std::unique_ptr<Encoder>& encoder, const cbvh::VertPlacement& placement, const Copy& copy,
                     cbvh::WorldBounds& bounds, cbvh::MotionStatistics& blockStatistics) {
    if (!encoder) encoder.reset(new Encoder);
    bounds = cbvh::WorldBounds();
    const size_t firstBox = store.boxes.size();
    encoder->begin(placement, plan.timeRange.lower, plan.timeRange.upper, plan.numTimeSteps,
                   store.reserve(Encoder::maxBytes(plan.numTimeSteps) + cbvh::NumbersEncoder::maxBytes));
    for (unsigned step = 0; step < plan.numTimeSteps; step++) {
      copy(step, encoder->vertices());
      encoder->addStep();
      const cbvh::BlockVertices& vertices = encoder->last();
      extend(bounds, vertices);
      cbvh::StepBox box;
      for (int k = 0; k < 3; k++) {
        box.lower[k] = vertices.lower[k];
        box.upper[k] = vertices.upper[k];
      }
      store.boxes.push_back(box);
    }
    const size_t size = encoder->finish(blockStatistics);
    if (size == 0) store.boxes.resize(firstBox);
    return size;
  }

  static void extend(cbvh::WorldBounds& bounds, const cbvh::BlockVertices& vertices) {
    if (!vertices.anyFinite()) return;
    bounds.extend(vertices.lower[0], vertices.lower[1], vertices.lower[2]);
    bounds.extend(vertices.upper[0], vertices.upper[1], vertices.upper[2]);
  }

  /*! Placement of a block in its patch. Also sets `numbers` if the patch has them. */
  cbvh::VertPlacement choosePlacement(const SurfacePatch& patch, unsigned x, unsigned y, unsigned w, unsigned h) {
    if (!patch.numbers) return patchPlacement(patch, x, y, w, h);
    numbers.choosePattern(*patch.numbers, x, y, w, h);
    return cbvh::VertPlacement(cbvh::packRegion(w, h, x, y), numbers.numbering, numbers.pattern);
  }

  /*! Completes an encoded block at the end of the store, and commits it. size: of the encoder's output. */
  void commitBlock(const SurfacePatch& patch, cbvh::VertHeader* header, size_t size,
                   const cbvh::VertStatistics& blockStatistics, const cbvh::WorldBounds& bounds) {
    header->surface = patch.surfaceNumber;
    header->primID = patch.primID;
    if (patch.numbers) size = numbers.finish(header, size);
    addToStatistics(header, size, blockStatistics);
    if (patch.numbers) addMeshQuads(patch, size_t(cbvh::vertQuadsX(header->region)) * cbvh::vertQuadsY(header->region));
    store.hitBounds.extend(bounds);
    store.commit(size, toBBox(bounds), cbvh::isTile(header->info) ? cbvh::TILE_BLOCK : cbvh::VERT_BLOCK,
                 cbvh::vertReadPadding);
  }

  /*! bytes: size of the block without padding. */
  void addToStatistics(const cbvh::VertHeader* header, size_t bytes, const cbvh::VertStatistics& blockStatistics) {
    const size_t quads = size_t(cbvh::vertQuadsX(header->region)) * size_t(cbvh::vertQuadsY(header->region));
    cbvh::CompressionStatistics& sums = statistics.sums;
    cbvh::BlockBytes(header, bytes).addTo(sums);
    sums.numBlocks++;
    sums.numRawBlocks += blockStatistics.raw;
    sums.numQuads += quads;
    sums.numInvalidQuads += blockStatistics.invalidQuads;
    if (plan.kind() != cbvh::Kind::CVERT) sums.numFallbackQuads += quads;
  }

  void addMeshQuads(const SurfacePatch& patch, size_t quads) {
    statistics.sums.numMeshQuads += quads;
    if (min(patch.quads[0], patch.quads[1]) < minGridSide) statistics.sums.numIrregularQuads += quads;
  }

  /*! Placement of a block whose quads belong to one primitive. Edges are stored only if (u,v) depend on them. */
  cbvh::VertPlacement patchPlacement(const SurfacePatch& patch, unsigned x, unsigned y, unsigned w, unsigned h) const {
    const uint32_t region = cbvh::packRegion(w, h, x, y), quads = cbvh::packPatchQuads(patch.quads[0], patch.quads[1]);
    const bool isAtBorder[4] = {y == 0, x + w == patch.quads[0], y + h == patch.quads[1], x == 0};
    bool needsEdges = patch.corner[0] != 0 || patch.corner[1] != 0;
    for (int s = 0; s < 4; s++) needsEdges |= isAtBorder[s] && sideRates[s] != patch.quads[s & 1];
    if (!needsEdges) return cbvh::VertPlacement(region, quads);
    return cbvh::VertPlacement(
        region, quads,
        cbvh::packEdges(sideRates[0], sideRates[1], sideRates[2], sideRates[3], patch.corner[0], patch.corner[1]));
  }

  /*! Rounds the vertices of a strip to their lattices. Updates the largest spacing and distance in the statistics.
   *  Returns the number of quads with a triangle that rounding flips. */
  template<typename Patch>
  size_t snapVertices(const Patch& patch, unsigned step, const PatchPart& strip, PatchVertices& vertices) {
    const cbvh::WorldLattice lattice(patch.latticeExponent(step));
    statistics.sums.maxVertexSpacing = max(statistics.sums.maxVertexSpacing, lattice.spacing);
    float(*snapped)[3] = vertices.displaced();
    // the memory of undisplaced vertices, which cVERT does not use, stores the vertices before rounding
    memcpy(vertices.undisplaced(), snapped, vertices.width * vertices.height * sizeof(*snapped));
    const float(*original)[3] = vertices.undisplaced();
    // shareBorder rounds the vertices on the patch's border
    for (size_t y = strip.y0 == 0; y < vertices.height - (strip.y1 == patch.quads[1]); y++) {
      size_t i = y * vertices.width + 1;
      const size_t end = i + vertices.width - 2;
      for (; i + 4 <= end; i += 4)
        statistics.addDeviation(cbvh::snapFour(lattice, original + i, snapped + i) * double(lattice.spacing) *
                                double(lattice.spacing));
      for (; i < end; i++) {
        for (int k = 0; k < 3; k++) snapped[i][k] = lattice.snap(original[i][k]);
        statistics.addVertex(original[i], snapped[i]);
      }
    }
    shareBorder(patch, step, patch.quads[0], patch.quads[1], strip, original, snapped, statistics);
    return countFlipped(vertices, original, snapped);
  }

  /*! Number of quads with a triangle whose normal turns by more than 90 degrees. */
  static size_t countFlipped(const PatchVertices& vertices, const float (*original)[3], const float (*snapped)[3]) {
    size_t n = 0;
    const size_t width = vertices.width;
    for (size_t y = 0; y + 1 < vertices.height; y++) {
      size_t x = 0;
      for (; x + 4 < width; x += 4)
        n += cbvh::countFlippedOfFour(original + y * width + x, snapped + y * width + x, width);
      for (; x + 1 < width; x++) {
        const size_t a = y * width + x, b = a + 1, c = a + width, d = c + 1;
        n += isFlipped(original, snapped, a, b, c) || isFlipped(original, snapped, b, d, c);
      }
    }
    return n;
  }

  static bool isFlipped(const float (*original)[3], const float (*snapped)[3], size_t a, size_t b, size_t c) {
    auto normal = [&](const float(*p)[3]) {
      auto edge = [&](size_t i) { return Vec3fa(p[i][0], p[i][1], p[i][2]) - Vec3fa(p[a][0], p[a][1], p[a][2]); };
      return cross(edge(b), edge(c));
    };
    const float normalDot = dot(normal(original), normal(snapped));
    if (abs(normalDot) > cbvh::minNormalDot && abs(normalDot) < float(inf)) return normalDot < 0.0f;
    return cbvh::isTurned(original, snapped, a, b, c);
  }

  const CompressionPlan& plan;
  BlockStore& store;
  cbvh::BuildStatistics& statistics;
  PatchVertices evaluatedVertices; //!< copy of vertices that the caller evaluated
  mvector<float> stepVertices;     //!< rounded vertices of a strip, step by step
  unsigned sideRates[4];           //!< edge rates of the patch's sides, equal in adjacent faces
  cbvh::VertEncoder encoder;
  cbvh::TileEncoder tileEncoder;
  std::unique_ptr<cbvh::MotionEncoder> movingEncoder; //!< null before the first moving block, as the next
  std::unique_ptr<cbvh::MovingTileEncoder> movingTileEncoder;
  cbvh::NumbersEncoder numbers;
};
} // namespace embree::isa
