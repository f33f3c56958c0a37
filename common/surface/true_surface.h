// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The surface that all representations approximate: OpenSubdiv's limit surface, displaced along its normal by the
 * unfiltered height map, or by a map of vectors. A tessellation of level L reads the map filtered to 2^-L. The true
 * surface has no spacing and reads the finest heights, so what the filter removes counts as an error of the
 * tessellation.
 *
 * At a border with different heights on both sides, each face keeps its own. A tessellation fills the step with walls,
 * which this surface does not have, so near such seams distances may be too large, but never too small. */

#include "surface/limit_surface.h"
#include "surface/model.h"
#include "surface/patch_walk.h"

#include <deque>
#include <optional>
#include <vector>

namespace cbvh {

struct TruePoint
{
  PatchPoint at;
  Vec3d position;
  Vec3d du, dv; // of position; their cross product is the geometric normal
};

/* The surface of one copy, in the frame of the model's cage; the caller places copies. Thread-safe. */
class TrueSurface
{
public:
  /* Shares the displacement with the model. */
  explicit TrueSurface(const Model& model, size_t copy = 0);

  bool has(unsigned face) const { return limit.has(face); }
  const PatchWalk& patches() const { return walk; }
  const LimitSurface& limitSurface() const { return limit; }
  TruePoint evaluate(const PatchPoint& p) const;

  /* Returns the nearest point to x that a search from `start` finds: by descent from `start`, then by descent from
   * samples of the window of parameters that can hold a nearer point. `cell` is the spacing of the tessellation in
   * parameters. The distance is never too small. It is exact unless the nearest point is
   *   - on another sheet of the surface, or more than 8 cells away in parameters, or
   *   - in a dent between samples. These are half a cell apart in windows of up to 4 cells each way, and at most one
   *     cell in larger ones. Windows below 1/16 of a cell, where the surface is assumed to be smooth, have none. */
  TruePoint nearest(Vec3d x, const PatchPoint& start, double cell) const;

  /* Returns the intersection of a line with the surface that Newton's method reaches from `start`, if any. `tolerance`
   * is the largest distance between line and point. */
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

/* The surfaces of all copies: one for all, or one per shape. Thread-safe. */
class TrueSurfaces
{
public:
  explicit TrueSurfaces(const Model& model);

  const TrueSurface& operator[](size_t copy) const { return surfaces.size() == 1 ? surfaces.front() : surfaces[copy]; }

private:
  std::deque<TrueSurface> surfaces;
};

} // namespace cbvh
