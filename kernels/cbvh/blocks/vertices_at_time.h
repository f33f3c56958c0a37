// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a cVERT block, mesh block or tile at a time, without SIMD. Traversal computes the same floats if
 * TraversalTime::isFused fits the device. */

#include "../base/codec_names.h"
#include "../../cvert/decoder/decoded_block.h"
#include "../../cvert/decoder/decoded_mesh.h"
#include "../../cvert/decoder/mesh_tile_view.h"
#include "stored_triangles.h"
#include <cmath>
#include <memory>

namespace embree::cbvh {
/*! Interpolates between two steps, rounding as exact/moving_block.h does for vectors. f: 0 to 1. */
inline float interpolate(float a, float b, float f, bool isFused) {
  const float last = f * b;
  return isFused ? std::fma(1.0f - f, a, last) : (1.0f - f) * a + last;
}

/*! All vertices of a cVERT block or tile, row by row. The block must exist at that time. */
class VerticesAtTime {
public:
  float vertices[DecodedBlock::maxSide * DecodedBlock::maxSide][3];
  const uint32_t width;

  VerticesAtTime(const VertHeader* block, const TraversalTime& at) : width(vertQuadsX(block->region) + 1) {
    const size_t bytes = sizeof(vertices[0]) * width * (vertQuadsY(block->region) + 1);
    if (!isMoving(block->info)) {
      memcpy(vertices, DecodedBlock(block).vertices, bytes);
      return;
    }
    const TimeInMotion in = timeInMotion(motionOf(block), at.time);
    const DecodedBlock before(block, in.segment);
    const DecodedBlock after(block, in.segment + 1);
    for (size_t i = 0; i < bytes / sizeof(float); i++)
      (&vertices[0][0])[i] =
          interpolate((&before.vertices[0][0])[i], (&after.vertices[0][0])[i], in.fraction, at.isFused);
  }

  const float* vertex(uint32_t x, uint32_t y) const { return vertices[y * width + x]; }

  /*! Also true if the block does not move. */
  static bool isPresent(const VertHeader* block, const TraversalTime& at) {
    return !isMoving(block->info) || cbvh::isPresent(motionOf(block), at.time);
  }
};

/*! Groups of triangles of a mesh block, decoded on request. */
class MeshAtTime {
public:
  const MeshView view;

  /*! The block must exist then, and must outlive this object. */
  MeshAtTime(const MeshHeader* block, const TraversalTime& at) : view(block), isFused(at.isFused), fraction(0) {
    if (!moves()) return;
    const TimeInMotion in = timeInMotion(motionOfMesh(block), at.time);
    fraction = in.fraction;
    if (in.segment > 0) before.reset(new MeshStepView(view, in.segment));
    after.reset(new MeshStepView(view, in.segment + 1));
  }

  bool moves() const { return isMovingMesh(view.block); }

  /*! Also true if the block does not move. */
  static bool isPresent(const MeshHeader* block, const TraversalTime& at) {
    return !isMovingMesh(block) || cbvh::isPresent(motionOfMesh(block), at.time);
  }

  DecodedMeshGroup group(uint32_t g) const {
    return DecodedMeshGroup(view, g, [&](uint32_t v, float out[3]) { vertex(v, out); });
  }

private:
  void vertex(uint32_t v, float out[3]) const {
    if (before) before->vertex(v, out);
    else view.vertex(v, out);
    if (!after) return;
    float end[3];
    after->vertex(v, end);
    for (int k = 0; k < 3; k++) out[k] = interpolate(out[k], end[k], fraction, isFused);
  }

  const bool isFused;
  float fraction;
  std::unique_ptr<const MeshStepView> before, after; //!< null without motion; `before` also in the first segment
};

/*! Vertices of a mesh tile. */
class MeshTileAtTime {
public:
  const MeshTileView first; //!< corners and numbers

  /*! The tile must exist then, and must outlive this object. */
  MeshTileAtTime(const MeshTileHeader* tile, const TraversalTime& at)
    : first(meshTileOfStep(tile, 0)),
      isFused(at.isFused),
      in(isMovingMeshTile(tile) ? timeInMotion(motionOfMeshTile(tile), at.time) : TimeInMotion{0, 0.0f}),
      before(meshTileOfStep(tile, in.segment)),
      after(meshTileOfStep(tile, isMovingMeshTile(tile) ? in.segment + 1 : 0)) {}

  /*! Also true if the tile does not move. */
  static bool isPresent(const MeshTileHeader* tile, const TraversalTime& at) {
    return !isMovingMeshTile(tile) || cbvh::isPresent(motionOfMeshTile(tile), at.time);
  }

  /*! v: index in group g. */
  void vertex(uint32_t g, uint32_t v, float out[3]) const {
    before.vertex(g, v, out);
    if (after.tile == before.tile) return;
    float end[3];
    after.vertex(g, v, end);
    for (int k = 0; k < 3; k++) out[k] = interpolate(out[k], end[k], in.fraction, isFused);
  }

private:
  const bool isFused;
  const TimeInMotion in;
  const MeshTileView before, after;
};
} // namespace embree::cbvh
