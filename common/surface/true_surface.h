// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The surface that all representations approximate: OpenSubdiv's limit surface, moved
 * along its normal by the height map as it is, or by a map of vectors. A tessellation of level L reads the map
 * filtered to 2^-L; the true surface has no spacing, so it reads the finest heights,
 * and what the filter takes away counts as error of the tessellation.
 *
 * On a border where the sides read different heights each face keeps its own: the walls
 * between them, into which a tessellation smears the step, are not searched, so that
 * near such seams distances come out too large, never too small. */

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

/* That of one copy. All in the frame of the model's cage; placing copies is the caller's. Thread safety:
 * callable from any number of threads. */
class TrueSurface
{
public:
  /* Displacement is the model's, and shared with it; none: the limit surface itself. */
  explicit TrueSurface(const Model& model, size_t copy = 0);

  bool has(unsigned face) const { return limit.has(face); }
  const PatchWalk& patches() const { return walk; }
  const LimitSurface& limitSurface() const { return limit; }
  TruePoint evaluate(const PatchPoint& p) const;

  /* The nearest point to x that a search from `start` finds: by descent, and then from
   * samples of the window of parameters that can hold a nearer one. So the distance is
   * never less than the true one, and it is the true one unless the nearest point is
   *   - on another sheet of the surface, or more than 8 cells away in parameters, or
   *   - in a dent between samples, which are half a cell apart in windows of up to 4
   *     cells each way and at most one in larger ones; a window of less than 1/16 of a
   *     cell, where the surface is taken to be smooth, has none.
   * cell: spacing of the tessellation in parameters. */
  TruePoint nearest(Vec3d x, const PatchPoint& start, double cell) const;

  /* Where a line meets the surface: what Newton's method reaches from `start`, if
   * anything. tolerance: distance between line and point. */
  std::optional<TruePoint> crossing(Vec3d origin, Vec3d direction, const TruePoint& start, double cell,
                                    double tolerance) const;

private:
  struct Window;

  TrueSurface(const Model& model, const Cage& cage);
  TruePoint evaluateAlongNormal(const PatchPoint& p) const;
  TruePoint evaluateByVectors(const PatchPoint& p) const;
  Vec3d vectorAt(const PatchPoint& p, const LimitSample& s) const;
  TruePoint descend(Vec3d x, const TruePoint& start, double cell) const;
  std::optional<Window> windowOfNearer(const TruePoint& p, double distance, double cell) const;
  std::vector<PatchPoint> dents(const Window& window, Vec3d x) const;
  Vec3d position(const PatchPoint& p) const;

  std::shared_ptr<const Displacement> displacement;
  LimitSurface limit;
  PatchWalk walk;
};

/* Those of all copies: one, or as many as there are shapes. Thread safety: likewise. */
class TrueSurfaces
{
public:
  explicit TrueSurfaces(const Model& model);

  const TrueSurface& operator[](size_t copy) const { return surfaces.size() == 1 ? surfaces.front() : surfaces[copy]; }

private:
  std::deque<TrueSurface> surfaces;
};

} // namespace cbvh
