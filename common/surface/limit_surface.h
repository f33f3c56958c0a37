// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The limit surface by OpenSubdiv's Bfr in double precision, independent of Embree. Regular patches are exact;
 * around extraordinary vertices and creases, 2^-10 of a face are approximated.
 *
 * Borders of holes are boundaries, as in Embree. (OpenSubdiv only does not draw holes.) Embree's surface differs
 * from OpenSubdiv's, and errors against the true surface include the difference,
 * - where creases of unequal or fractional sharpness meet, see crease_rules.h;
 * - where creases or corners of a sharpness below 1 touch n-gons;
 * - on the corner faces of open surfaces under BoundaryRule::EdgeOnly. */

#include "basics/vec.h"
#include "surface/cage.h"
#include "surface/patch_point.h"

#include <memory>

namespace programs {

/* Position, and derivatives by (u,v) of a patch. */
struct LimitSample {
  Vec3d p, du, dv, duu, duv, dvv;
};

class LimitSurface {
public:
  explicit LimitSurface(const Cage& cage);
  ~LimitSurface();
  LimitSurface(const LimitSurface&) = delete;
  LimitSurface& operator=(const LimitSurface&) = delete;

  /* False for holes, at boundaries under BoundaryRule::None, and where OpenSubdiv would crash: at creases of two faces
   * that share two adjacent edges. */
  bool has(unsigned face) const;

  /* Requires has(p.face). Thread-safe. */
  LimitSample evaluate(const PatchPoint& p) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace programs
