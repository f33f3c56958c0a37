// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libFuzzer target: random bytes as a ray and a cVERT block.
 *
 * Preconditions of traversal hold: the block has all bytes that place, words and the raw bit imply, and the padding
 * that decoders may read after it; moving blocks, and blocks with remainders or numbers of triangles, pass validation.
 * Everything else is arbitrary: traversal must not read outside, must not have undefined behavior, and must terminate.
 * Each hit that a filter receives has, for any block,
 *   - if the ray is sound (fuzz_traversal.h), a distance between tnear and tfar, and each accepted hit is no farther
 *     than the previous one,
 *   - finite parameters, not below the lowest of the block's quads;
 * and closest hit and any hit agree on the existence of a hit.
 *
 * --seeds=DIRECTORY writes blocks of the encoder with rays as the initial corpus. */

#include "fuzz_traversal.h"
#include "kernels/cvert/encoder/motion_encoder.h"
#include "kernels/cvert/decoder/validate.h"
#include "kernels/cbvh/exact/moving_intersector1.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace programs::test {
namespace {

using namespace embree;
using namespace embree::isa;
using namespace embree::cbvh;
using namespace cvert;
using embree::isa::cbvh::intersectMovingVert;
using embree::isa::cbvh::intersectVert;
using embree::isa::cbvh::VertRay;

constexpr size_t alignment = 16;
constexpr size_t readPadding = 16; // equals vertReadPadding

// Returns the bytes of the block, including its table of numbers, wherever it is stored. Returns 0 if there are
// fewer, or if such a block would not be traced.
size_t blockBytes(const uint8_t* data, size_t size) {
  VertHeader header;
  memcpy(&header, data, sizeof(header));
  const bool hasOffsets = hasPrimIDs(header.info) && (haveTrianglePairs(header.patchQuads) ||
                                                      patternOfPrimIDs(header.patchQuads) == primIDsInTriangleTable);
  if (isMoving(header.info) || hasRemainders(header.info) || hasOffsets) { // validated before traversal
    const ExactMemory aligned(data, size, alignment);
    return validateVert(aligned.get(), size) ? 0 : vertBytes((const VertHeader*)aligned.get());
  }
  const VertLayout layout = vertLayout(header.region, header.info);
  if (size < layout.margins || (hasEdges(header.info) && hasPrimIDs(header.info))) return 0;
  size_t tableEnd = 0;
  if (hasPrimIDs(header.info)) {
    if (firstCornerOfTriangle(header.patchQuads, false) > 2 || firstCornerOfTriangle(header.patchQuads, true) > 2)
      return 0;
    const VertPrimIDs numbers = numbersOf((const VertHeader*)data);
    if (patternOfPrimIDs(header.patchQuads) == primIDsInTable) {
      if (numbers.y > 32) return 0;
      tableEnd =
          size_t(numbers.x) + bytesOfNumberTable(vertQuadsX(header.region) * vertQuadsY(header.region), numbers.y);
    }
  }
  if (tableEnd > size) return 0;
  if (isTile(header.info)) return 0;
  if (isRaw(header.info)) return layout.rawBytes <= size ? std::max(size_t(layout.rawBytes), tableEnd) : 0;
  size_t bytes = layout.cell + cellBytes(header.word);
  if (bytes > size) return 0;
  for (uint32_t g = 0; g < layout.groups; g++) {
    uint16_t low;
    memcpy(&low, data + layout.words + 2 * g, sizeof(low));
    bytes += cellBytes(low);
  }
  return bytes <= size ? std::max(bytes, tableEnd) : 0;
}

template<typename RayType>
bool intersect(RayType& ray, IntersectContext* context, const VertHeader* block) {
  VertRay pre;
  return isMoving(block->info) ? intersectMovingVert(ray, context, pre, block)
                               : intersectVert(ray, context, pre, block);
}

void trace(RTCScene scene, const RayBytes& bytes, const VertHeader* block) {
  invalidateThreadCaches();
  // each triangle of a group once, including degenerate ones in blocks of the encoder
  const HitLimits limits = {32 * vertLayout(block->region, block->info).groups,
                            0.5f * float(vertCornerU(edgesOf(block))), 0.5f * float(vertCornerV(edgesOf(block)))};
  traceAndCompare(scene, bytes, limits,
                  [&](auto& ray, IntersectContext* context) { return intersect(ray, context, block); });
}

enum Surface { WAVES, SPIKES, FLAT, HOLES, SURFACES };

// The vertices of an encoder, flipped over three steps. The last step is on a finer lattice.
void writeMovingSeeds(const std::string& name, const VertEncoder& still, uint32_t region, float spacing) {
  static const auto encoder = std::make_unique<MotionEncoder>();
  std::vector<Vec3fa> memory(MotionEncoder::maxBytes(3) / sizeof(Vec3fa) + 2);
  encoder->begin({region, packPatchQuads(vertQuadsX(region), vertQuadsY(region))}, 0, 1, 3, (uint8_t*)memory.data());
  for (int step = 0; step < 3; step++) {
    const float unit = step == 2 ? spacing / 2 : spacing;
    for (uint32_t v = 0; v < still.numVertices(); v++) {
      const float* p = still.vertices[v];
      const float q[3] = {p[0], p[1] + 0.1f * float(step) * p[2], p[2] - 0.1f * float(step) * p[1]};
      for (int k = 0; k < 3; k++) encoder->vertices()[v][k] = std::round(q[k] / unit) * unit;
    }
    encoder->addStep();
  }
  MotionStatistics statistics;
  const size_t bytes = encoder->finish(statistics);
  VertHeader* block = (VertHeader*)memory.data();
  block->surface = block->primID = 0;
  writeSeedsWithRays(name, block, bytes);
}

// The vertices of an encoder in a block that numbers its quads by a table, which is stored after its other bytes and
// a gap.
void writeNumberedSeeds(const std::string& name, VertEncoder& encoder, float spacing, uint32_t quadsX,
                        uint32_t quadsY) {
  constexpr uint32_t bits = 9, gap = 256;
  const uint32_t table = bytesOfNumberTable(quadsX * quadsY, bits);
  std::vector<Vec3fa> memory((VertEncoder::maxBytes + gap + table) / sizeof(Vec3fa) + 2);
  uint8_t* const data = (uint8_t*)memory.data();
  VertStatistics statistics;
  const size_t bytes = encoder.encode(
      VertPlacement(packRegion(quadsX, quadsY, 0, 0), primIDsInTable, VertPrimIDs{0, bits}), data, statistics);
  if (bytes == 0) return;
  VertHeader* block = (VertHeader*)data;
  block->surface = block->primID = 0;
  const VertPrimIDs numbers = {uint32_t(bytes) + gap, bits};
  memcpy(block + 1, &numbers, sizeof(numbers));
  for (uint32_t i = 0; i < table; i++) data[numbers.x + i] = uint8_t(37 * i);
  writeSeedsWithRays(name, block, numbers.x + table);
}

} // namespace

void writeSeeds(const std::string& directory) {
  const float spacing = 1.0f / 4096;
  auto encoder = std::make_unique<VertEncoder>();
  std::vector<Vec3fa> memory(VertEncoder::maxBytes / sizeof(Vec3fa) + 2);
  for (uint32_t quadsX : {1, 4, 7, 16})
    for (uint32_t quadsY : {1, 5, 16})
      for (int surface = 0; surface < SURFACES; surface++) {
        for (uint32_t j = 0, i = 0; j <= quadsY; i == quadsX ? (j++, i = 0) : i++) {
          const float x = float(i) / float(quadsX), y = float(j) / float(quadsY);
          float z = surface == FLAT ? 0.25f * x : 0.1f * std::sin(5 * x + 3 * y);
          if (surface == SPIKES && (5 * i + 3 * j) % 7 == 0) z += 0.5f;
          const float p[3] = {x + 0.1f * x * y, y, z};
          for (int k = 0; k < 3; k++) encoder->vertices[j * (quadsX + 1) + i][k] = std::round(p[k] / spacing) * spacing;
          if (surface == HOLES && (i + 2 * j) % 5 == 1) encoder->vertices[j * (quadsX + 1) + i][2] = NAN;
        }
        VertStatistics statistics;
        const VertPlacement place(packRegion(quadsX, quadsY, 0, 0), packPatchQuads(quadsX, quadsY),
                                  packEdges(quadsX, quadsY, quadsX / 2 + 1, quadsY, 1, 5));
        const size_t bytes = encoder->encode(place, (uint8_t*)memory.data(), statistics);
        if (bytes == 0) continue;
        VertHeader* block = (VertHeader*)memory.data();
        block->surface = block->primID = 0;
        const std::string name = std::to_string(quadsX) + "-" + std::to_string(quadsY) + "-" + std::to_string(surface);
        writeMovingSeeds(directory + "/moving-" + name, *encoder, block->region, spacing);
        writeNumberedSeeds(directory + "/numbers-" + name, *encoder, spacing, quadsX, quadsY);
        writeSeedsWithRays(directory + "/" + name, block, bytes);
      }
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  static const World world;
  RayBytes ray;
  if (!ray.read(data, size, sizeof(VertHeader))) return 0;
  const size_t bytes = blockBytes(data, size);
  if (bytes == 0) return 0;
  std::vector<uint8_t> padded(data, data + bytes);
  padded.resize(bytes + readPadding);
  const ExactMemory memory(padded.data(), padded.size(), alignment);
  VertHeader* block = (VertHeader*)memory.get();
  block->surface = 0;
  trace(world.scene, ray, block);
  return 0;
}
