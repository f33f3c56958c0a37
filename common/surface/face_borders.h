// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which faces share a point of a border. Heights that are stored a face, or through
 * texture coordinates with seams, differ there from side to side; the mean over all
 * sides is the same for each of them, and closes the surface. */

#include "surface/cage.h"
#include "surface/patch_point.h"

#include <cstddef>
#include <vector>

namespace cbvh {

class FaceBorders
{
public:
  explicit FaceBorders(const Cage& cage);

  /* Where a face has (u,v) on its border: the edge from corner `edge` to the next,
   * and how far along it, 0 to 1. Inside: edge is -1. */
  struct Place
  {
    int edge = -1;
    float t = 0;
  };
  Place place(const FacePoint& p) const;

  /* The point of an edge, or of a corner for t = 0. */
  FacePoint point(unsigned face, unsigned edge, float t) const;

  /* The other side of an edge, run through the other way; face is ~0u at a boundary. */
  struct Side
  {
    unsigned face = ~0u, edge = 0;
  };
  Side opposite(unsigned face, unsigned edge) const { return across[firstCorner[face] + edge]; }

  /* All corners at the vertex of a corner, the same list in the same order for each. */
  const std::vector<Side>& around(unsigned face, unsigned corner) const
  {
    return corners[vertexOf[firstCorner[face] + corner]];
  }

  /* The mean of height(FacePoint) over all sides of a point whose own side has
   * `own`: to the bit the same from every side, as two numbers are added in either
   * order alike and more in the order of the list. */
  template<typename Height>
  float mean(unsigned face, Place at, float own, const Height& height) const
  {
    const unsigned n = sizes[face];
    if (at.t == 0.0f || at.t == 1.0f)
    {
      const std::vector<Side>& all = around(face, (unsigned(at.edge) + (at.t == 1.0f)) % n);
      float sum = 0.0f;
      for (const Side& s : all)
        sum += height(point(s.face, s.edge, 0.0f));
      return sum / float(all.size());
    }
    const Side other = opposite(face, unsigned(at.edge));
    return other.face == ~0u ? own : 0.5f * (own + height(point(other.face, other.edge, 1.0f - at.t)));
  }

  size_t numFaces() const { return sizes.size(); }
  unsigned size(unsigned face) const { return sizes[face]; }
  size_t corner(unsigned face, unsigned i) const { return firstCorner[face] + i; } // into the cage's faceIndices

private:
  std::vector<unsigned> sizes, vertexOf;
  std::vector<size_t> firstCorner;
  std::vector<Side> across;
  std::vector<std::vector<Side>> corners;
};

} // namespace cbvh
