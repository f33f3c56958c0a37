// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The limit surface, evaluated by OpenSubdiv's Bfr in double precision, independently of Embree. Regular patches are
 * exact. Around extraordinary vertices and creases, Bfr refines ten times and approximates the remaining 2^-10 of a
 * face.
 *
 * Holes are cut out as in Embree: their borders are boundaries of the surface. (OpenSubdiv only does not draw them.)
 * Elsewhere this is OpenSubdiv's surface. Embree's surface differs, and errors against the true surface include the
 * difference,
 *   - where creases of unequal or fractional sharpness meet, see crease_rules.h;
 *   - where creases or corners of a sharpness below 1 touch n-gons;
 *   - on the corner faces of open surfaces under BoundaryRule::EdgeOnly. */

#include "basics/vec.h"
#include "surface/cage.h"
#include "surface/patch_point.h"

#include <memory>

namespace cbvh {

/* Position and derivatives with respect to (u,v) of a patch. */
struct LimitSample
{
  Vec3d p, du, dv, duu, duv, dvv;
};

class LimitSurface
{
public:
  explicit LimitSurface(const Cage& cage);
  ~LimitSurface();
  LimitSurface(const LimitSurface&) = delete;
  LimitSurface& operator=(const LimitSurface&) = delete;

  /* False for holes, and for faces at a boundary under BoundaryRule::None. */
  bool has(unsigned face) const;

  /* Requires has(p.face). Thread-safe; the first call for a face prepares it. */
  LimitSample evaluate(const PatchPoint& p) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace cbvh
