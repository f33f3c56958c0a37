// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Displacement: how far a point of the limit surface moves along its normal, a pure
 * function of face, (u,v) and tessellation level, so every representation sees the
 * very same surface. Maps are filtered to the spacing of the level's vertices.
 *
 * Texture coordinates are interpolated bilinearly over a face (over the corner
 * quads of an n-gon), not subdivided: on an edge they depend on the edge alone.
 *
 * Closed surfaces stay closed. Where the sides of a border read different heights,
 * on a seam of an atlas or in maps of a face each, all of them take the mean. */

#include "surface/cage.h"
#include "surface/height_texture.h"

#include <cstddef>
#include <memory>
#include <string>

namespace cbvh {

/* Points of a face as Embree hands them to displacement functions. */
struct SurfacePoints
{
  unsigned face;     // of the cage
  int level;         // of the subdivision, 0 and more: spacing is 2^-level
  size_t n;
  const float* u;    // n
  const float* v;    // n
};

/* A level beyond all spacings of texels: heights as they are in the map. */
constexpr int finestLevel = 24;

class Displacement
{
public:
  virtual ~Displacement() = default;

  /* Offsets along the limit normal in world units.
   *
   * offsets: points.n floats, written.
   * Thread safety: callable from any number of threads. */
  virtual void offsets(const SurfacePoints& points, float* offsets) const = 0;
};

/* scale * (height - neutral level) with the neutral level at 0.5. */
constexpr float neutralHeight = 0.5f;

/* Height map through the cage's own texture coordinates, which it must have; OBJ's:
 * (0,0) is the lower left corner of the image, (1,1) the upper right, repeated
 * outside. Throws Error, as HeightTexture does. */
std::unique_ptr<Displacement> displaceByUVs(const Cage& cage, const std::string& path, float scale);

/* In the (u,v) of each face, row 0 of the image at v = 0. A file with one image: all
 * of it on every face and on every corner quad of an n-gon. A file of several, Ptex
 * for one: an image a quad and n an n-gon, in order. Throws Error, also for a file
 * with too few images. warning: set when it uses one image whose borders differ. */
std::unique_ptr<Displacement> displaceByFace(const Cage& cage, const std::string& path, float scale,
                                             std::string& warning);

} // namespace cbvh
