// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A map on the faces of a cage: what it says at a point, seen from one side of a border. */

#include "surface/displacement.h"
#include "surface/face_borders.h"
#include "surface/height_texture.h"

#include <memory>
#include <string>

namespace cbvh {

class PlacedMap
{
public:
  virtual ~PlacedMap() = default;

  /* As displaceByMap. */
  static std::unique_ptr<PlacedMap> create(const Cage& cage, const DisplacementMap& map, std::string& warnings);

  /* values: one, or three of vectors, written; left alone where there is no map. level: of
   * the tessellation, to whose spacing the map is filtered. */
  virtual void sample(const FacePoint& p, float level, float* values) const = 0;

  /* Texels along an edge of a face, from that corner to the next. */
  virtual float texelsAlong(unsigned face, unsigned edge) const = 0;

  /* Whether sides read different values at a place of a face's border. */
  virtual bool isSeam(unsigned face, FaceBorders::Place at) const = 0;

  const FaceBorders& borders() const { return faceBorders; }

protected:
  explicit PlacedMap(const Cage& cage) : faceBorders(cage) {}

  FaceBorders faceBorders;
};

/* Four values at the corners of a quad. */
template<typename T>
T bilinear(const T q[4], float x, float y)
{
  /* Symmetric in the two ends of an edge: the weights of the far edge are exact
   * zeros there, and 1-x is exact for the multiples of 2^-k that x takes. */
  const T lower = q[0] * (1.0f - x) + q[1] * x;
  const T upper = q[3] * (1.0f - x) + q[2] * x;
  return lower * (1.0f - y) + upper * y;
}

/* A value at a point of a face of n corners, from values at the corners: over the face
 * itself, or over the corner quads of an n-gon. */
template<typename T>
T interpolate(const T* c, unsigned n, const FacePoint& p)
{
  float x = p.u, y = p.v;
  if (n == 4)
    return bilinear(c, x, y);
  /* One linear subdivision step: corner, middle of the edge ahead, centre, middle of the
   * edge behind. */
  const unsigned corner = std::min(decodeSubPatch(x, y), n - 1);
  T centre{};
  for (unsigned i = 0; i < n; i++)
    centre = centre + c[i];
  const T q[4] = {c[corner], (c[corner] + c[(corner + 1) % n]) * 0.5f, centre * (1.0f / float(n)),
                  (c[corner] + c[(corner + n - 1) % n]) * 0.5f};
  return bilinear(q, x, y);
}

} // namespace cbvh
