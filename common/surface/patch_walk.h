// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moves points in parameter space across the borders of patches: quad faces and corner quads of n-gons. */

#include "surface/face_borders.h"

#include <functional>

namespace cbvh {

class PatchWalk
{
public:
  /* exists(face) is true if the face has a surface; walks do not enter other faces. */
  PatchWalk(const Cage& cage, const std::function<bool(unsigned face)>& exists);

  /* Moves a point by (du,dv), in parameters of its patch. Behaves at a border as if both patches lay side by side in a
   * plane; parameters double or halve between a quad face and a corner quad. Slides along boundaries. */
  PatchPoint go(PatchPoint from, double du, double dv) const;

  /* Converts from and to Embree's parameters. */
  PatchPoint fromEmbree(const FacePoint& p) const;
  FacePoint toEmbree(const PatchPoint& p) const;

private:
  /* A point of a border, in parameters of the patch on the other side. */
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
