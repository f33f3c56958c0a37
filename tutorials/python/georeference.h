// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Between the coordinates of a raster, in 64 bits, and those of the scene that stores it, in 32 bits.
 *
 * As in tutorials/terrain, the scene counts columns and rows in multiples of a power of two, so that x and y of
 * vertices never move, and keeps the unit of heights. It counts from the middle of the raster, where floats are finest.
 */

#include "arrays.h"

#include "tracing/ray.h"

namespace programs::python {

/* Steps of x per column and of y per row. A number c means (c, -c), because the first row of a raster is the northern
 * one. Throws ValueError or TypeError. */
std::pair<double, double> readCell(const py::object& value);

class Georeference {
public:
  Georeference() = default;

  /* cellX, cellY: from a column, or a row, to the next one. maxError: bound of heights; 0 keeps them. */
  Georeference(size_t rows, size_t columns, double cellX, double cellY, Vec3d origin, double maxError);

  /* Largest power of two that is at most the bound of heights; 0 if they are not rounded. */
  float spacing() const { return heightSpacing; }

  /* A vertex of the scene. Rounds the height to a multiple of the spacing. */
  Vec3f vertex(size_t row, size_t column, double height) const;

  /* Row and column of a position, with fractions. */
  std::pair<double, double> place(Vec3d position) const;

  Vec3d position(double row, double column, double height) const;

  /* Of unit length, and not downward. */
  Vec3f normal(Vec3f inScene) const;

  /* A ray of the scene, which starts where the ray of the raster enters `box`, with distance t = start + scale * t of
   * the scene's ray. Rays that miss the box have tfar < 0. */
  struct SceneRay {
    Ray ray;
    double start = 0, scale = 1;
  };
  SceneRay ray(Vec3d origin, Vec3d direction, double tnear, double tfar, const Box3f& box) const;

  size_t rows = 0, columns = 0;
  double cellX = 1, cellY = 1;
  Vec3d origin; // position of sample [0, 0] of height 0
  double maxError = 0;

private:
  double middleRow = 0, middleColumn = 0;
  double step = 1; // between stored columns and rows
  float heightSpacing = 0;
};

} // namespace programs::python
