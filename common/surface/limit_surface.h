// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The limit surface by OpenSubdiv's Bfr, in double precision: independent of Embree's
 * own evaluation. Regular patches are exact. Around extraordinary vertices and creases
 * Bfr refines ten times and closes what is left, 2^-10 of a face, by approximations.
 *
 * Holes are cut out, as Embree does it: their borders are boundaries of the surface, to
 * OpenSubdiv they are faces that are not drawn. Elsewhere the surface is OpenSubdiv's,
 * and Embree's is known to differ from it
 *   - where creases meet that are not equal, or not whole numbers: see crease_rules.h;
 *   - where creases or corners sharp by less than 1 touch n-gons;
 *   - on the corner faces of open surfaces under BoundaryRule::EdgeOnly.
 * There errors against the true surface contain that of Embree's rule. */

#include "basics/vec.h"
#include "surface/cage.h"
#include "surface/patch_point.h"

#include <memory>

namespace cbvh {

/* Position and derivatives in (u,v) of a patch. */
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

  /* False for holes, and under BoundaryRule::None for faces at a boundary. */
  bool has(unsigned face) const;

  /* p: of a face that has a surface. Thread safety: callable from any number of
   * threads; the first call on a face prepares it. */
  LimitSample evaluate(const PatchPoint& p) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

} // namespace cbvh
