// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes lattices (format.h): fits nine heights whose surface passes through the vertices, raises them at the block's
 * border, and bounds the distance of the quads' edges from the surface. */

#include "quad_group.h"
#include <algorithm>
#include <cmath>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Smallest width of a cell relative to the group: limits extrapolation of its patch. */
static constexpr double minCellWidth = 1.0 / 16;

/*! Distance from vertices, in bins, at which the fit ends: small compared to rounding by half a bin. */
static constexpr double fitTolerance = 0.0625;
static constexpr int maxFitIterations = 16; //!< of fitLattice()

/*! Largest number of times that the surface is raised at the block's border. Raising can make it steeper, so that
 *  it needs more slack and must be raised again. */
static constexpr int maxRaiseAttempts = 4;

/*! A surface that is piecewise bilinear over 3 x 3 heights. */
struct Lattice {
  double planes[2][3]; //!< [axis]: lower, middle and upper plane
  double z[9];         //!< heights where planes cross, row by row

  struct Position {
    int corner;
    double u, v;
  }; //!< the cell's first height; position in the cell, 0 to 1

  Position locate(double x, double y) const { return positionInCell(x >= planes[0][1], y >= planes[1][1], x, y); }
  Position positionInCell(int column, int row, double x, double y) const {
    return {column + 3 * row, (x - planes[0][column]) / (planes[0][column + 1] - planes[0][column]),
            (y - planes[1][row]) / (planes[1][row + 1] - planes[1][row])};
  }
  /*! Largest absolute slope along an axis. A bilinear patch is steepest on its sides. */
  double maxAbsSlope(int axis) const {
    double slope = 0;
    for (int line = 0; line < 3; line++)
      for (int i = 0; i < 2; i++) {
        const int v = axis == 0 ? i + 3 * line : line + 3 * i;
        slope = std::max(slope, std::fabs(z[v + (axis == 0 ? 1 : 3)] - z[v]) / (planes[axis][i + 1] - planes[axis][i]));
      }
    return slope;
  }
  double twist(int corner) const { return z[corner] - z[corner + 1] - z[corner + 3] + z[corner + 4]; }
  double height(const Position& p) const {
    const double* h = z + p.corner;
    return h[0] + p.u * (h[1] - h[0]) + p.v * (h[3] - h[0]) + p.u * p.v * twist(p.corner);
  }

  struct Range {
    double lower, upper;
    void extend(const Range& r) {
      lower = std::min(lower, r.lower);
      upper = std::max(upper, r.upper);
    }
    double maxMagnitude() const { return std::max(-lower, upper); }
  };

  /*! Bounds of the deviation along the straight edge from a to b: the surface's height above the edge, negative if
   *  the surface is below. Between planes, it is a parabola, which differs from its chord by at most a quarter of
   *  its quadratic term. */
  Range deviationRange(const double a[3], const double b[3]) const {
    /* The middle planes cut the edge into up to three pieces. */
    double cut[4] = {0, 1, 1, 1};
    int numPieces = 0;
    for (int axis = 0; axis < 2; axis++) {
      const double t = (planes[axis][1] - a[axis]) / nonZero(b[axis] - a[axis]);
      if (t > 0 && t < 1) cut[++numPieces] = t;
    }
    if (numPieces == 2 && cut[1] > cut[2]) std::swap(cut[1], cut[2]);
    cut[++numPieces] = 1;
    Range range = {1e300, -1e300};
    for (int i = 0; i < numPieces; i++) {
      auto point = [&](double t, int axis) { return a[axis] + t * (b[axis] - a[axis]); };
      const double middle = 0.5 * (cut[i] + cut[i + 1]);
      const int column = point(middle, 0) >= planes[0][1], row = point(middle, 1) >= planes[1][1];
      const Position p = positionInCell(column, row, point(cut[i], 0), point(cut[i], 1)),
                     q = positionInCell(column, row, point(cut[i + 1], 0), point(cut[i + 1], 1));
      const double d0 = height(p) - point(cut[i], 2), d1 = height(q) - point(cut[i + 1], 2);
      const double sag = -0.25 * twist(p.corner) * (q.u - p.u) * (q.v - p.v);
      range.extend({std::min(d0, d1) + std::min(sag, 0.0), std::max(d0, d1) + std::max(sag, 0.0)});
    }
    return range;
  }
};

/*! The two edges of quads along a column (axis 0) or row (axis 1) of vertices: lines 0 and 2 are sides, 1 is the
 *  middle. */
struct GroupLine {
  int vertex[3]; //!< indices in QuadGroup::vertices
  GroupLine(int axis, int line) {
    for (int i = 0; i < 3; i++) vertex[i] = axis == 0 ? line + 3 * i : 3 * line + i;
  }
  /*! See Lattice::deviationRange(). */
  Lattice::Range deviationRange(const Lattice& lattice, const QuadGroup& group) const {
    Lattice::Range range = lattice.deviationRange(group.vertices[vertex[0]], group.vertices[vertex[1]]);
    range.extend(lattice.deviationRange(group.vertices[vertex[1]], group.vertices[vertex[2]]));
    return range;
  }
};

/*! Adds the codes of an axis's planes to `word`, and sets `planes` to the decoded ones. Outer planes keep
 *  containmentSlack from all vertices; the middle plane is nearest to the mean of its vertices. Returns false if a
 *  cell is too narrow, or if a vertex on the block's border is not in the cells of that side, where the intersector
 *  searches for it. */
inline bool encodeLatticePlanes(const NodeBox& parent, const QuadGroup& group, int axis, uint32_t& word,
                                double planes[3]) {
  const int along = axis == 0 ? 1 : 3, across = axis == 0 ? 3 : 1;
  double lower = group.boxes[0].lower[axis], upper = group.boxes[0].upper[axis];
  for (const ExactBox& box : group.boxes) {
    lower = std::min(lower, box.lower[axis]);
    upper = std::max(upper, box.upper[axis]);
  }
  double mean = 0;
  for (int i = 0; i < 3; i++) mean += group.vertices[along + i * across][axis] * (1.0 / 3);

  uint32_t low = 0, high = 0;
  const float l = parent.lower[axis], e = parent.extent[axis];
  for (uint32_t q = 1; q < 32; q++) {
    if (l + latticeOuterOffset(q) * e <= lower - containmentSlack) low = q;
    if (l + (1.0f - latticeOuterOffset(q)) * e >= upper + containmentSlack) high = q;
  }
  const double middle = std::floor(((mean - l) / e * 128 - 33) * 0.5 + 0.5);
  const uint32_t m = middle < 0 ? 0 : middle > 31 ? 31 : uint32_t(middle);
  word |= (low | (high << 5) | (m << 10)) << latticeShift(axis);

  for (int i = 0; i < 3; i++) planes[i] = latticePlane(word, axis, i, parent);
  const double narrowest = (planes[2] - planes[0]) * minCellWidth;
  if (!(planes[1] - planes[0] > narrowest) || !(planes[2] - planes[1] > narrowest)) return false;
  for (int i = 0; i < 3; i++) {
    if (group.border[axis][0] && group.vertices[i * across][axis] > planes[1] - containmentSlack - group.rounding[axis])
      return false;
    if (group.border[axis][1] &&
        group.vertices[2 * along + i * across][axis] < planes[1] + containmentSlack + group.rounding[axis])
      return false;
  }
  return true;
}

/*! Fits the heights so that the surface passes through the vertices. Each iteration moves each vertex's own height
 *  by the distance of the surface from the vertex. This converges if each height has over half of the weight at
 *  its vertex. If the deviation stays large, the caller rejects the lattice. tolerance: largest remaining
 *  distance in z at which the fit ends. */
inline void fitLattice(const QuadGroup& group, Lattice& lattice, double tolerance) {
  Lattice::Position position[9];
  for (int v = 0; v < 9; v++) {
    position[v] = lattice.locate(group.vertices[v][0], group.vertices[v][1]);
    lattice.z[v] = group.vertices[v][2];
  }
  for (int iteration = 0; iteration < maxFitIterations; iteration++) {
    double largest = 0;
    for (int v = 0; v < 9; v++) {
      const double correction = group.vertices[v][2] - lattice.height(position[v]);
      lattice.z[v] += correction;
      largest = std::max(largest, std::fabs(correction));
    }
    if (!(largest > tolerance)) break;
  }
}

/*! A lattice with rounded heights. */
struct CodedLattice {
  Lattice surface;
  HeightBins bins;
  int heights[9];

  /*! Sets a height to q bins, rounded down and clamped. */
  void set(int v, double q) {
    heights[v] = !(q > 0) ? 0 : q < latticeBins - 1 ? int(q) : latticeBins - 1;
    surface.z[v] = zOfHeight(bins, float(heights[v]));
  }
  /*! Raises a height by `below`, rounded up to whole bins, and clamps it. */
  void raise(int v, double below) {
    if (below > 0) set(v, heights[v] + std::ceil(below / bins.size));
  }
};

/*! First step of raising the surface to `slack` above the edges of a side: raises each height by the deficit at its
 *  vertex. */
inline void raiseToVertices(CodedLattice& lattice, const QuadGroup& group, const GroupLine& side, double slack) {
  for (int v : side.vertex) {
    const double* p = group.vertices[v];
    lattice.raise(v, slack + p[2] - lattice.surface.height(lattice.surface.locate(p[0], p[1])));
  }
}

/*! Second step: raises all heights of the side together. Returns false if that moves the surface too far. */
inline bool raiseToEdges(CodedLattice& lattice, const QuadGroup& group, const GroupLine& side, double slack) {
  /* limited, because the rest of the surface rises, too; beyond the limit, separate leaves are better */
  const int maxIterations = 4;
  const double maxRaise = 4 * lattice.bins.size;
  for (int iteration = 0;; iteration++) {
    const double below = slack - side.deviationRange(lattice.surface, group).lower;
    if (below <= 0) return true;
    if (!(below < maxRaise) || iteration == maxIterations) return false;
    for (int v : side.vertex) lattice.raise(v, below);
  }
}

/*! Raises the surface on the block's border to `slack` above the edges. Returns false if that moves it too far. */
inline bool raiseBorder(CodedLattice& lattice, const QuadGroup& group, double slack) {
  for (int axis = 0; axis < 2; axis++)
    for (int upper = 0; upper < 2; upper++) {
      if (!group.border[axis][upper]) continue;
      const GroupLine side(axis, 2 * upper);
      raiseToVertices(lattice, group, side, slack);
      if (!raiseToEdges(lattice, group, side, slack)) return false;
    }
  return true;
}

/*! Returns QuadGroup::slack() for the largest slopes of a surface. */
inline double slackOfSurface(const Lattice& surface, const QuadGroup& group) {
  const double slopes[2] = {surface.maxAbsSlope(0), surface.maxAbsSlope(1)};
  return group.slack(slopes);
}

/*! Smallest code whose half thickness exceeds the distances of all edges from the surface by `slack`, or 4 if there
 *  is none. */
inline uint32_t encodeLatticeThickness(const CodedLattice& lattice, const QuadGroup& group, double slack) {
  Lattice::Range range = {0, 0};
  for (int axis = 0; axis < 2; axis++)
    for (int line = 0; line < 3; line++) range.extend(GroupLine(axis, line).deviationRange(lattice.surface, group));
  const double maxDeviation = range.maxMagnitude();
  uint32_t code = 0;
  while (code < 4 && !(0.5 * latticeThickness(code) * lattice.bins.size >= maxDeviation + slack)) code++;
  return code;
}

/*! heights: 0 to 127, row by row. */
inline Heights packLattice(const int heights[9]) {
  uint64_t bits = 0;
  for (int v = 0; v < 9; v++)
    if (v != 4) bits |= uint64_t(heights[v]) << (8 * latticeByte(v));
  /* Copies of the 7 bits do not overlap; bit i of copy i is bit 8i+7. */
  const uint64_t copies = 0x0002040810204081u << 7;
  bits |= uint64_t(heights[4]) * copies & 0x0080808080808080u;
  return {uint32_t(bits), uint32_t(bits >> 32)};
}

/*! Returns false if no lattice is close enough to the quads. parent: decoded box of the group. Does not set
 *  out.borderWidth. */
inline bool encodeLattice(const NodeBox& parent, const QuadGroup& group, EncodedGroup& out) {
  for (const ExactBox& box : group.boxes)
    if (box.empty()) return false;
  CodedLattice lattice;
  uint32_t word = 0;
  for (int axis = 0; axis < 2; axis++)
    if (!encodeLatticePlanes(parent, group, axis, word, lattice.surface.planes[axis])) return false;

  lattice.bins = heightBins(parent, latticeRange, latticeBins);
  fitLattice(group, lattice.surface, fitTolerance * lattice.bins.size);
  for (int v = 0; v < 9; v++)
    lattice.set(v, std::floor((lattice.surface.z[v] - lattice.bins.lower) / lattice.bins.size));

  /* ends with the slack that the final surface needs, or more */
  double slack = slackOfSurface(lattice.surface, group);
  for (int attempt = 1;; attempt++) {
    if (!raiseBorder(lattice, group, slack)) return false;
    const double finalSlack = slackOfSurface(lattice.surface, group);
    if (finalSlack <= slack) break;
    if (attempt == maxRaiseAttempts) return false;
    slack = finalSlack;
  }

  const uint32_t thickness = encodeLatticeThickness(lattice, group, slack);
  if (thickness == 4) return false;
  out.word = word | (thickness << latticeThicknessShift);
  out.heights = packLattice(lattice.heights);
  return true;
}
}} // namespace embree::cbvh::CBVH_ISA
