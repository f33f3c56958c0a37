// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A displacement map and its mapping to the faces of a cage, by texture coordinates or per face. At a seam, each face
 * samples its own side of the map, and reads no texels of other charts. */

#include "surface/chart_filter.h"
#include "surface/displacement.h"
#include "surface/face_borders.h"
#include "surface/height_texture.h"

#include <memory>
#include <string>
#include <vector>

namespace programs {

class MappedTexture {
public:
  virtual ~MappedTexture() = default;

  /* Parameters and errors as displaceByMap. */
  static std::unique_ptr<MappedTexture> create(const Cage& cage, const DisplacementMap& map, std::string& warnings);

  /* Writes one value, or three for vectors, filtered to the spacing of `level`; nothing where there is no map.
   * Thread-safe. */
  virtual void sample(const FacePoint& p, float level, float* values) const = 0;

  /* Along the edge from corner `edge` to the next. */
  virtual float texelsAlongEdge(unsigned face, unsigned edge) const = 0;

  /* True if faces may read different values at this point. */
  virtual bool isSeam(unsigned face, FaceBorders::BorderPosition at) const = 0;

  const FaceBorders& borders() const { return faceBorders; }

  /* Length of the cage's edge at a point of a border; of the longest one at a vertex. */
  float edgeLength(unsigned face, FaceBorders::BorderPosition at) const;

protected:
  explicit MappedTexture(const Cage& cage);

  FaceBorders faceBorders;

private:
  std::vector<float> edgeLengths; // from each corner to the next
};

template<typename T>
T bilinear(const T q[4], float x, float y) {
  /* Exactly symmetric in the ends of an edge: the opposite edge's weights are zero, and 1-x is exact for multiples
   * of 2^-k. */
  const T lower = q[0] * (1.0f - x) + q[1] * x;
  const T upper = q[3] * (1.0f - x) + q[2] * x;
  return lower * (1.0f - y) + upper * y;
}

/* Interpolates values at the n corners of a face, or over the corner quads of an n-gon. */
template<typename T>
T interpolate(const T* c, unsigned n, const FacePoint& p) {
  float x = p.u, y = p.v;
  if (n == 4) return bilinear(c, x, y);
  /* Corner, middle of the next edge, center, middle of the previous edge. */
  const unsigned corner = std::min(decodeSubPatch(x, y), n - 1);
  T center{};
  for (unsigned i = 0; i < n; i++) center = center + c[i];
  const T q[4] = {c[corner], (c[corner] + c[(corner + 1) % n]) * 0.5f, center * (1.0f / float(n)),
                  (c[corner] + c[(corner + n - 1) % n]) * 0.5f};
  return bilinear(q, x, y);
}

} // namespace programs
