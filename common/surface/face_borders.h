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

  struct Side
  {
    unsigned face = ~0u, edge = 0;
    bool reversed = false; // runs from the greater to the smaller vertex
  };

  /* All sides of an edge, the same list in the same order for each: one at a boundary, two as
   * a rule, more where the cage is not manifold. */
  struct Sides
  {
    const Side *first, *last;
    const Side* begin() const { return first; }
    const Side* end() const { return last; }
    size_t size() const { return size_t(last - first); }
  };
  Sides along(unsigned face, unsigned edge) const
  {
    const unsigned e = edgeOf[firstCorner[face] + edge];
    return {&sides[firstSide[e]], &sides[firstSide[e]] + (firstSide[e + 1] - firstSide[e])};
  }

  /* The other side of an edge of two that run through it both ways; else face is ~0u. */
  Side opposite(unsigned face, unsigned edge) const;

  /* All corners at the vertex of a corner, the same list in the same order for each. */
  const std::vector<Side>& around(unsigned face, unsigned corner) const
  {
    return corners[vertexOf[firstCorner[face] + corner]];
  }

  /* The mean of value(FacePoint) over all sides of a point whose own side has `own`: to
   * the bit the same from every side, as they are added in the order of the list. */
  template<typename T, typename Value>
  T mean(unsigned face, Place at, T own, const Value& value) const
  {
    const unsigned edge = unsigned(at.edge);
    T sum{};
    if (at.t == 0.0f || at.t == 1.0f)
    {
      const std::vector<Side>& all = around(face, (edge + (at.t == 1.0f)) % sizes[face]);
      for (const Side& s : all)
        sum += value(point(s.face, s.edge, 0.0f));
      return sum * (1.0f / float(all.size()));
    }
    const Sides all = along(face, edge);
    if (all.size() == 1)
      return own;
    const bool reversed = isReversed(face, edge);
    for (const Side& s : all)
      if (s.face == face && s.edge == edge)
        sum += own;
      else
        sum += value(point(s.face, s.edge, s.reversed == reversed ? at.t : 1.0f - at.t));
    return sum * (1.0f / float(all.size()));
  }

  size_t numFaces() const { return sizes.size(); }
  unsigned size(unsigned face) const { return sizes[face]; }
  size_t corner(unsigned face, unsigned i) const { return firstCorner[face] + i; } // into the cage's faceIndices

private:
  bool isReversed(unsigned face, unsigned edge) const
  {
    return vertexOf[corner(face, edge)] > vertexOf[corner(face, (edge + 1) % sizes[face])];
  }

  std::vector<unsigned> sizes, vertexOf;
  std::vector<size_t> firstCorner;
  std::vector<unsigned> edgeOf;   // of each corner, that from it to the next
  std::vector<size_t> firstSide;  // of each edge, and the end of the last
  std::vector<Side> sides;
  std::vector<std::vector<Side>> corners;
};

} // namespace cbvh
