// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libFuzzer target: random bytes as a ray and a block, traced by the intersector of one of the three kinds with frames.
 *
 * Preconditions of traversal hold: the kind matches the leaf type of the top level, the height is at most
 * maxFramedLevel, and the block has all bytes of its layout. Everything else is arbitrary: traversal must not read
 * outside of the block, must not have undefined behavior, and must terminate. If frame and ray are also valid input of
 * a builder and of an application (FRAME and RAY below)
 *   - every hit lies between tnear and tfar, and each accepted hit is no farther than the previous one, with finite
 *     parameters, which are inside the block for cLEAF and cVOXEL;
 *   - closest hit and any hit agree on the existence of a hit.
 *
 * --seeds=DIRECTORY writes blocks of the encoder with rays as the initial corpus. */

#include "fuzz_support.h"
#include "kernels/cbvh/paper/block_encoder.h"
#include "kernels/cbvh/paper/block_intersector1.h"

#include <vector>

namespace programs::test {
namespace {

using namespace embree;
using namespace embree::isa;
using namespace embree::cbvh;
using embree::isa::cbvh::BlockIntersector1;
using embree::isa::cbvh::GridVisitor1;
using embree::isa::cbvh::LeafVisitor1;
using embree::isa::cbvh::RayState;
using embree::isa::cbvh::VoxelVisitor1;

// RAY: within Embree's limits, and close enough to the block, relative to its size, that floats do not overflow in
// its frame.
bool isSound(const RayBytes& ray, const Block* block) {
  double length = 0, distance = 0, stretch = 0;
  for (float d : ray.dir) length = std::fmax(length, std::fabs(d));
  for (int k = 0; k < 3; k++) distance = std::fmax(distance, std::fabs(double(ray.org[k]) - double(block->center[k])));
  for (const auto& column : block->columns)
    for (float c : column) stretch = std::fmax(stretch, std::fabs(c));
  return distance * stretch <= 1e36 && isFinite(ray.org) && isFinite(ray.dir) && length >= 1e-18f && ray.tnear >= 0 &&
         ray.tnear <= maxCoordinate && ray.tfar >= ray.tnear;
}

// FRAME: as computed by fitBox (paper/frame_fit.h): the box is a bounded region of the world of at least the
// smallest size, no side is much shorter than another, and W is in its range.
bool isSound(const Block* block) {
  bool ok = isFinite(block->center);
  double least = INFINITY, most = 0; // of 1 over a side
  for (int k = 0; k < 3; k++) {
    double stretch = 0;
    for (const auto& column : block->columns) stretch += std::fabs(column[k]);
    least = std::fmin(least, stretch);
    most = std::fmax(most, stretch);
  }
  ok &= most <= 1e31 && minExtentRatio * most <= 64 * least;
  if (!ok) return false;
  const FrameMap map = frameMap(block);
  for (int i = 0; i < 8; i++) {
    Double3 corner;
    ok &= unproject(map, i & 1, (i >> 1) & 1, i >> 2, corner);
    // a frame is slightly larger than its contents
    ok = ok && std::fmax(std::fmax(std::fabs(corner.x), std::fabs(corner.y)), std::fabs(corner.z)) <=
                   64 * double(maxCoordinate);
    const double W = ok ? map.W(corner) : 0;
    ok &= W > 1 / (2.5 * maxWRatio) && W < 2.5 * maxWRatio; // fitBox requires 2, before rounding
  }
  return ok;
}

// A context whose filter receives every candidate.
struct Trace : RTCIntersectContext {
  const Block* block;
  bool sound, accepts;
  size_t hits = 0;
  float tnear, tfar;

  Trace(const Block* block, const RayBytes& ray, bool sound, bool accepts)
    : block(block),
      sound(sound),
      accepts(accepts),
      tnear(ray.tnear),
      tfar(ray.tfar) {
    rtcInitIntersectContext(this);
    filter = [](const RTCFilterFunctionNArguments* args) { ((Trace*)args->context)->see(args); };
  }

  void see(const RTCFilterFunctionNArguments* args) {
    const size_t quads = size_t(1) << (2 * block->height());
    REQUIRE(++hits <= 4 * quads);
    const float t = ((const RTCRay*)args->ray)->tfar;
    const RTCHit& hit = *(const RTCHit*)args->hit;
    if (sound) {
      REQUIRE(t >= tnear && t <= tfar);
      REQUIRE(std::isfinite(hit.u) && std::isfinite(hit.v));
      if (block->kind() != Kind::CGRID) {
        const float n = float(1u << block->height()), slack = 1e-6f;
        REQUIRE(hit.u >= block->faceU(0.0f) - slack && hit.u <= block->faceU(n) + slack * block->faceU(n));
        REQUIRE(hit.v >= block->faceV(0.0f) - slack && hit.v <= block->faceV(n) + slack * block->faceV(n));
        REQUIRE(std::isfinite(hit.Ng_x) && std::isfinite(hit.Ng_y) && std::isfinite(hit.Ng_z));
      }
    }
    if (accepts) tfar = t;
    else args->valid[0] = 0;
  }
};

template<template<typename> class Leaf>
void trace(RTCScene scene, const RayBytes& bytes, const Block* block) {
  const bool sound = isSound(bytes, block) && isSound(block);
  const Ray ray = bytes.ray();
  bool found[2];
  for (bool accepts : {true, false}) {
    Trace closest(block, bytes, sound, accepts);
    RayHit hit(ray);
    hit.geomID = RTC_INVALID_GEOMETRY_ID;
    IntersectContext context((Scene*)scene, &closest);
    BlockIntersector1<Leaf>::intersect(hit, &context, RayState(ray), block);
    if (sound)
      REQUIRE(hit.tfar == (accepts ? closest.tfar : bytes.tfar) && (hit.geomID == 0) == (accepts && closest.hits));

    Trace any(block, bytes, sound, accepts);
    Ray occluded(ray);
    context.user = &any;
    const bool isOccluded = BlockIntersector1<Leaf>::intersect(occluded, &context, RayState(ray), block);
    if (sound) REQUIRE(isOccluded == (accepts && any.hits));
    if (sound) REQUIRE((closest.hits != 0) == (any.hits != 0));
    found[accepts] = any.hits;
  }
  if (sound) REQUIRE(found[true] == found[false]);
}

// --- seeds -------------------------------------------------------------------------------

enum Surface { WAVES, SPIKES, FOLDED, HOLES, SURFACES };

std::vector<float> sheet(Surface surface, uint32_t n) {
  std::vector<float> vertices;
  for (uint32_t j = 0; j <= n; j++)
    for (uint32_t i = 0; i <= n; i++) {
      const float x = float(i) / float(n), y = float(j) / float(n);
      float p[3] = {x + 0.1f * x * y, y, 0.1f * std::sin(5 * x + 3 * y)};
      if (surface == SPIKES && (5 * i + 3 * j) % 7 == 0) p[2] += 0.5f;
      if (surface == FOLDED) p[0] += 0.3f * std::sin(9 * x);
      if (surface == HOLES && (i + 2 * j) % 5 == 1) p[2] = NAN;
      vertices.insert(vertices.end(), p, p + 3);
    }
  return vertices;
}

} // namespace

void writeSeeds(const std::string& directory) {
  for (Kind kind : {Kind::CGRID, Kind::CVOXEL, Kind::CLEAF})
    for (uint32_t height = 0; height <= 4; height++)
      for (int surface = 0; surface < SURFACES; surface++) {
        const std::vector<float> vertices = sheet(Surface(surface), 1u << height);
        const auto* p = (const float(*)[3])vertices.data();
        const uint32_t w = (1u << height) + 1;
        float corners[4][3];
        for (int c = 0; c < 4; c++)
          memcpy(corners[c], p[(c >> 1) * (w - 1) * w + (c & 1) * (w - 1)], sizeof(corners[c]));
        std::vector<Vec3fa> scratch(BlockEncoder::scratchBytes(height) / sizeof(Vec3fa) + 1),
            memory(blockLayout(uint32_t(kind), height).bytes / sizeof(Vec3fa) + 1);
        Block* block = (Block*)memory.data();
        BlockEncoder encoder(kind, height, p, scratch.data());
        BlockStatistics statistics;
        if (!encoder.fit(corners)) continue;
        encoder.encode(block, 1, 0, statistics);
        block->surface = block->primID = 0;
        block->tiling = blockTiling(3, 3, 0, 0);
        writeSeedsWithRays(directory + "/" + std::to_string(int(kind)) + "-" + std::to_string(height) + "-" +
                               std::to_string(surface),
                           block, block->layout().bytes);
      }
}

} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  static const World world;
  RayBytes ray;
  if (!ray.read(data, size, sizeof(Block))) return 0;

  Block header;
  memcpy(&header, data, sizeof(header));
  const Kind kind = Kind(header.info % 3);
  const uint32_t height = header.height() % (maxFramedLevel + 1);
  header.info = (header.info & ~255u) | uint32_t(kind) | (height << 4);
  header.surface = 0;
  const uint32_t bytes = header.layout().bytes;
  if (size < bytes) return 0;

  const ExactMemory memory(data, bytes, blockAlignment);
  Block* block = (Block*)memory.get();
  memcpy(block, &header, sizeof(header));
  invalidateThreadCaches(); // the previous block may have had the same address
  switch (kind) {
  case Kind::CLEAF: trace<LeafVisitor1>(world.scene, ray, block); break;
  case Kind::CVOXEL: trace<VoxelVisitor1>(world.scene, ray, block); break;
  case Kind::CGRID: trace<GridVisitor1>(world.scene, ray, block); break;
  case Kind::CVERT:
  case Kind::CTILE: break; // vert_traversal.cpp
  }
  return 0;
}
