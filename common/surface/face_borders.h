// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Faces that share a border point. If their heights differ there, the mean over all sides closes the surface. */

#include "surface/cage.h"
#include "surface/patch_point.h"

#include <cstddef>
#include <vector>

namespace programs {

class FaceBorders {
public:
  explicit FaceBorders(const Cage& cage);

  /* Position t in [0,1] on the edge from corner `edge` to the next; `edge` is -1 inside the face. */
  struct BorderPosition {
    int edge = -1;
    float t = 0;
  };
  BorderPosition borderPosition(const FacePoint& p) const;

  /* Inverse. */
  FacePoint point(unsigned face, unsigned edge, float t) const;

  struct Side {
    unsigned face = ~0u, edge = 0;
    bool reversed = false; // runs from the greater to the smaller vertex index
  };

  /* Sides of an edge: one at a boundary, usually two, more if the cage is not manifold. */
  struct Sides {
    const Side *first, *last;
    const Side* begin() const { return first; }
    const Side* end() const { return last; }
    size_t size() const { return size_t(last - first); }
  };
  Sides sidesOfEdge(unsigned face, unsigned edge) const {
    const unsigned e = edgeOf[firstCorner[face] + edge];
    return {&sides[firstSide[e]], &sides[firstSide[e]] + (firstSide[e + 1] - firstSide[e])};
  }

  /* The other side of an edge between two faces of the same orientation; otherwise face is ~0u. */
  Side opposite(unsigned face, unsigned edge) const;

  /* All corners at a vertex. */
  const std::vector<Side>& cornersAtVertex(unsigned face, unsigned corner) const {
    return corners[vertexOf[firstCorner[face] + corner]];
  }

  /* Mean of value(FacePoint) over all sides of a point, equal to the bit on all sides. `own` is the calling side's
   * value. */
  template<typename T, typename Value>
  T mean(unsigned face, BorderPosition at, T own, const Value& value) const {
    const unsigned edge = unsigned(at.edge);
    T sum{};
    if (at.t == 0.0f || at.t == 1.0f) {
      const std::vector<Side>& all = cornersAtVertex(face, (edge + (at.t == 1.0f)) % sizes[face]);
      for (const Side& s : all) sum += value(point(s.face, s.edge, 0.0f));
      return sum * (1.0f / float(all.size()));
    }
    const Sides all = sidesOfEdge(face, edge);
    if (all.size() == 1) return own;
    const bool reversed = isReversed(face, edge);
    for (const Side& s : all)
      if (s.face == face && s.edge == edge) sum += own;
      else sum += value(point(s.face, s.edge, s.reversed == reversed ? at.t : 1.0f - at.t));
    return sum * (1.0f / float(all.size()));
  }

  size_t numFaces() const { return sizes.size(); }
  unsigned size(unsigned face) const { return sizes[face]; }
  size_t corner(unsigned face, unsigned i) const { return firstCorner[face] + i; } // into the cage's faceIndices

private:
  bool isReversed(unsigned face, unsigned edge) const {
    return vertexOf[corner(face, edge)] > vertexOf[corner(face, (edge + 1) % sizes[face])];
  }

  std::vector<unsigned> sizes, vertexOf;
  std::vector<size_t> firstCorner;
  std::vector<unsigned> edgeOf;  // from each corner to the next
  std::vector<size_t> firstSide; // per edge, followed by the end
  std::vector<Side> sides;
  std::vector<std::vector<Side>> corners;
};

} // namespace programs
