// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moves points over borders of patches, and converts parameters. */

#include "surface/face_borders.h"

#include <functional>

namespace programs {

class PatchWalk {
public:
  /* Walks do not enter faces for which exists() is false. */
  PatchWalk(const Cage& cage, const std::function<bool(unsigned face)>& exists);

  /* Moves a point by (du,dv) in parameters of its patch. At a border both patches lie side by side in a plane;
   * parameters double or halve between a quad face and a corner quad. Slides along boundaries. */
  PatchPoint advance(PatchPoint from, double du, double dv) const;

  PatchPoint fromEmbree(const FacePoint& p) const;
  FacePoint toEmbree(const PatchPoint& p) const;

private:
  struct Crossing {
    unsigned face, subPatch, edge;
    double t;     // along the edge, counterclockwise
    double scale; // of parameters
  };
  bool crossEdge(unsigned face, unsigned subPatch, unsigned edge, double t, Crossing& crossing) const;

  FaceBorders borders;
  std::vector<char> exists;
};

} // namespace programs
