// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The surface that all representations approximate: OpenSubdiv's limit surface with the unfiltered displacement. A
 * tessellation of level L reads maps filtered to 2^-L; what the filter removes is an error of the tessellation.
 *
 * At a border with different heights, each face keeps its own. A tessellation closes the step with walls, so near
 * such seams distances may be too large, but never too small. */

#include "surface/limit_surface.h"
#include "surface/model.h"
#include "surface/patch_walk.h"

#include <deque>
#include <optional>
#include <vector>

namespace programs {

struct TruePoint {
  PatchPoint at;
  Vec3d position;
  Vec3d du, dv; // du x dv is the geometric normal
};

/* One copy, in the frame of the model's cage. Thread-safe. */
class TrueSurface {
public:
  explicit TrueSurface(const Model& model, size_t copy = 0);

  bool has(unsigned face) const { return limit.has(face); }
  const PatchWalk& patches() const { return walk; }
  TruePoint evaluate(const PatchPoint& p) const;

  /* Returns the nearest point to x that a search finds: by descent from `start`, then from samples of the parameters
   * that can hold a nearer point. `cell` is the tessellation's spacing in parameters. The distance is never too
   * small, and exact unless the nearest point is
   * - on another sheet of the surface, or more than 8 cells away in parameters, or
   * - in a dent between samples. These are half a cell apart in windows of up to 4 cells each way, and at most one
   *   cell in larger ones. Windows below 1/16 of a cell, where the surface is assumed to be smooth, have none. */
  TruePoint nearest(Vec3d x, const PatchPoint& start, double cell) const;

  /* Returns the intersection of a line and the surface that Newton's method reaches from `start`, if any.
   * `tolerance` is the largest distance between line and point. */
  std::optional<TruePoint> crossing(Vec3d origin, Vec3d direction, const TruePoint& start, double cell,
                                    double tolerance) const;

private:
  struct Window;

  TrueSurface(const Model& model, const Cage& cage);
  TruePoint evaluateAlongNormal(const PatchPoint& p) const;
  TruePoint evaluateByVectors(const PatchPoint& p) const;
  Vec3d vectorAt(const PatchPoint& p, const LimitSample& s) const;
  TruePoint descend(Vec3d x, const TruePoint& start, double cell) const;
  std::optional<Window> nearerWindow(const TruePoint& p, double distance, double cell) const;
  std::vector<PatchPoint> localMinima(const Window& window, Vec3d x) const;
  Vec3d position(const PatchPoint& p) const;

  std::shared_ptr<const Displacement> displacement;
  LimitSurface limit;
  PatchWalk walk;
};

/* One for all copies, or one per shape. Thread-safe. */
class TrueSurfaces {
public:
  explicit TrueSurfaces(const Model& model);

  const TrueSurface& operator[](size_t copy) const { return surfaces.size() == 1 ? surfaces.front() : surfaces[copy]; }

private:
  std::deque<TrueSurface> surfaces;
};

} // namespace programs
