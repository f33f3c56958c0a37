// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moving in parameter space across the borders of patches: quad faces, and the corner
 * quads of n-gons. */

#include "surface/face_borders.h"

#include <functional>

namespace cbvh {

class PatchWalk
{
public:
  /* exists: whether a face has a surface; a walk does not enter one without. */
  PatchWalk(const Cage& cage, const std::function<bool(unsigned face)>& exists);

  /* Goes by (du,dv), in parameters of the patch it starts in. Over a border it goes on
   * straight, as if both patches lay side by side in a plane, with parameters that
   * double or halve between a quad face and a corner quad; along a boundary it slides. */
  PatchPoint go(PatchPoint from, double du, double dv) const;

  /* As Embree reports a point, and back. */
  PatchPoint fromEmbree(const FacePoint& p) const;
  FacePoint toEmbree(const PatchPoint& p) const;

private:
  /* The same point of a border on the patch beyond it. */
  struct Crossing
  {
    unsigned face, subPatch, edge;
    double t;     // along the edge, counterclockwise
    double scale; // of parameters
  };
  bool cross(unsigned face, unsigned subPatch, unsigned edge, double t, Crossing& crossing) const;

  FaceBorders borders;
  std::vector<char> exists;
};

} // namespace cbvh
