// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* One geometry of a scene, before it is built: arrays of NumPy, or a model. */

#include "basics/vec.h"

#include <embree3/cbvh.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace programs {
struct Model;
}

namespace programs::python {

class Geometry {
public:
  virtual ~Geometry() = default;

  virtual size_t numPrimitives() const = 0;
  virtual unsigned steps() const = 0;
  virtual std::string description() const = 0; // "grid of 3 x 4 samples"

  /* Bound on the spacing of the lattice; 0 is lossless, and none is the library's default. */
  std::optional<float> maxError;
};

/* A geometry that is a surface of cbvh.h. */
class SurfaceGeometry : public Geometry {
public:
  /* Sets the input of a surface, which is read until the surface is committed: the geometry's arrays, and `scratch`,
   * which receives vertices that exist only for the commit. Uses no Python. */
  virtual CbvhError setInput(CbvhSurface surface, std::vector<Vec3f>& scratch) const = 0;

  /* Times of the first and the last step. */
  float startTime = 0, endTime = 1;
};

/* Sets the input of a surface to one grid. rowStride: vertices from one row to the next. */
CbvhError setGrid(CbvhSurface surface, size_t rows, size_t columns, size_t rowStride, const CbvhVertices& vertices);

/* A subdivision surface. */
class ModelGeometry : public Geometry {
public:
  ModelGeometry(std::shared_ptr<const Model> model, int level) : model(std::move(model)), level(level) {}

  size_t numPrimitives() const override;
  unsigned steps() const override;
  std::string description() const override;

  std::shared_ptr<const Model> model;
  int level;
};

} // namespace programs::python
