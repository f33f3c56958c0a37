// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes four lattices at a time, one per lane, with the same results to the bit as lattice_encoder.h. Supports only
 * regular groups: on both axes, vertices of a side of the group are on that side of the middle plane. With the vertices
 * below and the cells of format.h, vertex 6 is in cell 2, vertex 7 in cell 2 or 3, and vertex 4 in any cell. All
 * positions in cells are then from 0 to 1.
 *
 *    6   7   8
 *    3   4   5
 *    0   1   2
 *
 * The distances of edges from the surface are bounded from below and from above. If the two bounds lead to different
 * results, LatticeLanes calls lattice_encoder.h for the lane. Irregular groups are left to the caller. */

#include "group_lanes.h"
#include "lattice_encoder.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class LatticeLanes {
public:
  uint32_t encoded = 15;  //!< after encode(): mask of lanes with a lattice
  uint32_t undecided = 0; //!< after encode(): mask of lanes for which the caller must call encodeLattice()

  /*! parents: decoded boxes of the groups. Both arguments must outlive the object. */
  LatticeLanes(const NodeBoxes& parents, const GroupLanes& groups)
    : parents(parents),
      groups(groups),
      binsLower(Float4::load(parents.lower[2]) -
                Float4(0.5f * (latticeRange - 1.0f)) * Float4::load(parents.extent[2])),
      binSize(Float4::load(parents.extent[2]) * (latticeRange / float(latticeBins))) {}

  void encode() {
    for (int axis = 0; axis < 2; axis++) encodePlanes(axis);
    if (encoded == 0) return;
    findCells();
    if (encoded == 0) return;
    fitHeights();
    for (int v = 0; v < 9; v++) setHeight(v, (z[v] - binsLower) / nonZero(Double4(binSize)));
    const Double4 slack = raiseBorder();
    if (encoded) encodeThickness(slack);
  }

  /*! Stores the words and heights of all lanes. They are undefined for lanes that are not in `encoded`. */
  void store(uint32_t words[4], Heights out[4]) const {
    const Int4* const h = heights;
    Int4 low = h[0] | (h[1] << 8) | (h[2] << 16) | (h[3] << 24),
         high = h[5] | (h[6] << 8) | (h[7] << 16) | (h[8] << 24);
    for (int i = 0; i < 7; i++) {
      Int4& half = i < 4 ? low : high;
      half = half | ((h[4] >> i << 31) >> (24 - 8 * (i % 4)));
    }
    word.store(words);
    uint32_t halves[2][4];
    low.store(halves[0]);
    high.store(halves[1]);
    for (int lane = 0; lane < 4; lane++) out[lane] = {halves[0][lane], halves[1][lane]};
  }

  /* Results of encode(), for leaf_lanes.h: decoded planes, reciprocals of their distances, heights, thickness. */
  Double4 plane(int axis, int i) const { return planes[axis][i]; }
  Double4 reciprocalWidth(int axis, int i) const { return rcpWidths[axis][i]; }
  Double4 height(int v) const { return z[v]; }
  Double4 thickness() const { return leafThickness; }

private:
  /*! Returns the highest code from 1 to 31 for which predicate(latticeOuterOffset(code)) is true, or 0 if there is
   *  none. If the predicate is true for a code, it must be true for all lower codes. */
  template<typename Predicate>
  static Int4 highestCodes(const Predicate& predicate) {
    Int4 codes = 0;
    for (int bit = 16; bit; bit /= 2) { codes = codes | (predicate(outerOffsetsOf(codes | Int4(bit))) & Int4(bit)); }
    return codes;
  }

  /*! latticeOuterOffset() of each lane's code. */
  static Float4 outerOffsetsOf(Int4 codes) { return toFloat((codes << 2) + (square(codes) >> 2)) * (1.0f / 1024.0f); }

  /*! As encodeLatticePlanes(), but clears the bits of `encoded` where that function returns false. */
  void encodePlanes(int axis) {
    const int along = axis == 0 ? 1 : 3, across = axis == 0 ? 3 : 1;
    const Float4 l = Float4::load(parents.lower[axis]), e = Float4::load(parents.extent[axis]);
    const Double4 below = groups.lower[axis] - containmentSlack, above = groups.upper[axis] + containmentSlack;
    const Int4 low = highestCodes([&](Float4 outer) { return Double4(l + outer * e) <= below; });
    const Int4 high = highestCodes([&](Float4 outer) { return above <= Double4(l + (Float4(1.0f) - outer) * e); });
    auto third = [&](int i) { return groups.vertices[along + i * across][axis] * (1.0 / 3); };
    const Double4 mean = third(0) + third(1) + third(2);
    const Double4 middle = ((mean - l) / nonZero(Double4(e)) * 128.0 - 33.0) * 0.5 + 0.5;
    const Int4 m = toInt(min(max(middle, 0.0), 31.0));
    const Int4 code = low | (high << 5) | (m << 10);
    word = axis == 0 ? code : word | (code << latticeShift(1));

    Double4* const p = planes[axis];
    p[0] = l + outerOffsetsOf(low) * e;
    p[1] = l + toFloat(Int4(33) + (m << 1)) * (1.0f / 128.0f) * e;
    p[2] = l + (Float4(1.0f) - outerOffsetsOf(high)) * e;
    // widths are 0 in lanes without a group
    for (int i = 0; i < 2; i++) {
      widths[axis][i] = nonZero(p[i + 1] - p[i]);
      rcpWidths[axis][i] = 1.0 / widths[axis][i];
    }
    const Double4 minWidth = (p[2] - p[0]) * minCellWidth;
    encoded &= ((minWidth < widths[axis][0]) & (minWidth < widths[axis][1])).bits();
    for (int i = 0; i < 3; i++) {
      encoded &= ~(groups.border[axis][0] &
                   (p[1] - containmentSlack - groups.rounding[axis] < groups.vertices[i * across][axis]).bits());
      encoded &=
          ~(groups.border[axis][1] &
            (groups.vertices[2 * along + i * across][axis] < p[1] + containmentSlack + groups.rounding[axis]).bits());
    }
  }

  /*! Sets `position` and `isMiddleUpper`. Moves lanes of irregular groups from `encoded` to `undecided`. */
  void findCells() {
    uint32_t irregular = 0;
    for (int axis = 0; axis < 2; axis++)
      for (int v = 0; v < 9; v++) {
        const int line = axis == 0 ? v % 3 : v / 3; // column or row of the vertex
        const Double4 x = groups.vertices[v][axis];
        const Mask4 isUpper = planes[axis][1] <= x;
        if (line == 1) isMiddleUpper[axis][axis == 0 ? v / 3 : v % 3] = isUpper;
        else irregular |= isUpper.bits() ^ (line == 2 ? 15 : 0);
        position[v][axis] = line == 0   ? (x - planes[axis][0]) / widths[axis][0]
                            : line == 2 ? (x - planes[axis][1]) / widths[axis][1]
                                        : (x - select(isUpper, planes[axis][1], planes[axis][0])) /
                                              select(isUpper, widths[axis][1], widths[axis][0]);
      }
    undecided = irregular & encoded;
    encoded &= ~irregular;
  }

  /*! Height of the surface at corner (dx,dy) of the cell of vertex v. */
  template<int v, int dx, int dy>
  Double4 cornerHeight() const {
    auto row = [&](int j) {
      return v % 3 == 1 ? select(isMiddleUpper[0][v / 3], z[3 * j + dx + 1], z[3 * j + dx]) : z[3 * j + dx + v % 3 / 2];
    };
    return v / 3 == 1 ? select(isMiddleUpper[1][v % 3], row(dy + 1), row(dy)) : row(dy + v / 3 / 2);
  }

  /*! Height of the surface at vertex v. */
  template<int v>
  Double4 surfaceHeight() const {
    const Double4 a = cornerHeight<v, 0, 0>(), b = cornerHeight<v, 1, 0>(), c = cornerHeight<v, 0, 1>(),
                  d = cornerHeight<v, 1, 1>();
    return a + position[v][0] * (b - a) + position[v][1] * (c - a) + position[v][0] * position[v][1] * (a - b - c + d);
  }

  /*! Corrects z[v] in active lanes by the height of vertex v above the surface. maxCorrection: set to the magnitude
   *  of the correction if that is larger. */
  template<int v>
  void correctHeight(Mask4 active, Double4& maxCorrection) {
    const Double4 correction = active & (groups.vertices[v][2] - surfaceHeight<v>());
    z[v] = z[v] + correction;
    maxCorrection = max(maxCorrection, abs(correction));
  }

  /*! As fitLattice(). */
  void fitHeights() {
    for (int v = 0; v < 9; v++) z[v] = groups.vertices[v][2];
    const Double4 tolerance = Double4(binSize) * fitTolerance;
    uint32_t active = encoded;
    for (int iteration = 0; iteration < maxFitIterations && active; iteration++) {
      const Mask4 mask = maskFromBits(active);
      Double4 largest = 0.0;
      correctHeight<0>(mask, largest);
      correctHeight<1>(mask, largest);
      correctHeight<2>(mask, largest);
      correctHeight<3>(mask, largest);
      correctHeight<4>(mask, largest);
      correctHeight<5>(mask, largest);
      correctHeight<6>(mask, largest);
      correctHeight<7>(mask, largest);
      correctHeight<8>(mask, largest);
      active &= (tolerance < largest).bits();
    }
  }

  /*! As CodedLattice::set(). */
  void setHeight(int v, Double4 q) {
    heights[v] = toInt(min(max(q, 0.0), double(latticeBins - 1)));
    z[v] = binsLower + (toFloat(heights[v]) + 0.5f) * binSize;
  }

  /*! Returns QuadGroup::slack() for the largest slopes of the surface. */
  Double4 computeSlack() const {
    Double4 slope[2];
    for (int axis = 0; axis < 2; axis++) {
      Double4 rise[2] = {0.0, 0.0}; // largest differences of heights in the lower and the upper cells of the axis
      for (int line = 0; line < 3; line++)
        for (int i = 0; i < 2; i++) {
          const int v = axis == 0 ? i + 3 * line : line + 3 * i;
          rise[i] = max(rise[i], abs(z[v + (axis == 0 ? 1 : 3)] - z[v]));
        }
      slope[axis] = max(rise[0] / widths[axis][0], rise[1] / widths[axis][1]);
    }
    return Double4(containmentSlack + groups.rounding[2]) + slope[0] * groups.rounding[0] +
           slope[1] * groups.rounding[1];
  }

  /*! The point at which the edge from a to b crosses the middle plane of an axis. */
  struct LineCrossing {
    Double4 t;      //!< position on the edge, 0 at a and 1 at b
    Double4 across; //!< coordinate on the other axis
    Double4 z;      //!< height of the edge

    LineCrossing(const LatticeLanes& l, int axis, const Double4 a[3], const Double4 b[3]) {
      t = (l.planes[axis][1] - a[axis]) / nonZero(b[axis] - a[axis]);
      across = a[1 - axis] + t * (b[1 - axis] - a[1 - axis]);
      z = a[2] + t * (b[2] - a[2]);
    }
  };

  /*! Deviation at a crossing: height of the surface above the edge. isUpper: the crossing is in the upper cells of
   *  the other axis. */
  Double4 deviationAt(const LineCrossing& p, int axis, Mask4 isUpper) const {
    const int other = 1 - axis, step = axis == 0 ? 3 : 1, first = axis == 0 ? 1 : 3; // indices of heights
    const Double4 from = select(isUpper, z[first + step], z[first]),
                  to = select(isUpper, z[first + 2 * step], z[first + step]);
    const Double4 u = (p.across - select(isUpper, planes[other][1], planes[other][0])) *
                      select(isUpper, rcpWidths[other][1], rcpWidths[other][0]);
    return from + u * (to - from) - p.z;
  }

  /*! Bounds of the Lattice::Range that lattice_encoder.h computes, per lane. That range contains lowest[0] to
   *  highest[0], and is contained in lowest[1] to highest[1]. The bounds differ only for the middle row and column.
   *  Neither accounts for rounding, see margin(). */
  struct RangeBounds4 {
    Double4 lowest[2] = {1e300, 1e300}, highest[2] = {-1e300, -1e300};

    void add(Double4 low, Double4 high, int bound) {
      lowest[bound] = min(lowest[bound], low);
      highest[bound] = max(highest[bound], high);
    }
  };

  /*! Bounds of GroupLine::deviationRange() for a column (axis 0) or row (axis 1). One of its two edges crosses the
   *  middle plane of the other axis, at x: before or after vertex b. This results in three pieces. In each piece,
   *  the deviation is a parabola, which differs from its chord by at most a quarter of its quadratic term: the sag.
   *
   *    a-----x--b--------c    here, x is before b */
  template<int axis, int line>
  RangeBounds4 deviationRange() const {
    constexpr int other = 1 - axis, step = axis == 0 ? 3 : 1, v = axis == 0 ? line : 3 * line;
    const Double4 *const a = groups.vertices[v], *const b = groups.vertices[v + step],
                         *const c = groups.vertices[v + 2 * step];
    const Double4 da = deviation[v], db = deviation[v + step], dc = deviation[v + 2 * step];
    RangeBounds4 range;

    const Mask4 isXBeforeB = isMiddleUpper[other][line];
    Double4 from[3], to[3];
    for (int k = 0; k < 3; k++) {
      from[k] = select(isXBeforeB, a[k], b[k]);
      to[k] = select(isXBeforeB, b[k], c[k]);
    }
    const LineCrossing x(*this, other, from, to);
    const Double4 dx = deviationAt(x, other,
                                   line == 0   ? maskFromBits(0)
                                   : line == 2 ? maskFromBits(15)
                                               : planes[axis][1] <= x.across);

    /* per piece: product of its extents on both axes, to which the sag is proportional */
    const Double4 t2 = x.t * x.t, rest2 = (1.0 - x.t) * (1.0 - x.t);
    const Double4 ab = (b[0] - a[0]) * (b[1] - a[1]), bc = (c[0] - b[0]) * (c[1] - b[1]);
    const Double4 areas[3] = {ab * select(isXBeforeB, t2, 1.0), select(isXBeforeB, ab * rest2, bc * t2),
                              bc * select(isXBeforeB, 1.0, rest2)};
    /* deviations at the ends of the pieces */
    const Double4 ends[4] = {da, select(isXBeforeB, dx, db), select(isXBeforeB, db, dx), dc};
    Double4 maxSag = 0.0;
    /* i: index of the cell along the line; j: across it */
    auto unitSagOfCell = [&](int i, int j) { return unitSag[axis == 1 ? i + 2 * j : j + 2 * i]; };
    for (int i = 0; i < 3; i++) {
      const Double4 low = min(ends[i], ends[i + 1]), high = max(ends[i], ends[i + 1]);
      auto unitSagOfPiece = [&](int j) {
        return i == 0   ? unitSagOfCell(0, j)
               : i == 2 ? unitSagOfCell(1, j)
                        : select(isXBeforeB, unitSagOfCell(1, j), unitSagOfCell(0, j));
      };
      if (line != 1) {
        const Double4 sag = areas[i] * unitSagOfPiece(line / 2);
        for (int bound = 0; bound < 2; bound++) range.add(low + min(sag, 0.0), high + max(sag, 0.0), bound);
      } else { // the piece may be in cells on both sides of the middle plane of `axis`
        const Double4 sag = abs(areas[i]) * max(abs(unitSagOfPiece(0)), abs(unitSagOfPiece(1)));
        range.add(low, high, 0);
        range.add(low - sag, high + sag, 1);
        maxSag = max(maxSag, sag);
      }
    }
    /* Edges of the middle line may also cross the middle plane of `axis`, which divides a piece. The sag of each
     * part is at most the sag of the piece. */
    if (line == 1)
      for (int i = 0; i < 2; i++) {
        const LineCrossing y(*this, axis, i == 0 ? a : b, i == 0 ? b : c);
        const Mask4 crosses = maskFromBits(isMiddleUpper[axis][i].bits() ^ isMiddleUpper[axis][i + 1].bits());
        const Double4 dy = select(crosses, deviationAt(y, axis, planes[other][1] <= y.across), db);
        range.add(dy, dy, 0);
        range.add(dy - maxSag, dy + maxSag, 1);
      }
    return range;
  }

  template<int v>
  void computeDeviation() {
    deviation[v] = surfaceHeight<v>() - groups.vertices[v][2];
  }

  void computeUnitSags() {
    for (int i = 0; i < 4; i++) {
      const Double4* const h = z + i % 2 + 3 * (i / 2);
      unitSag[i] = -0.25 * (h[0] - h[1] - h[3] + h[4]) * rcpWidths[0][i % 2] * rcpWidths[1][i / 2];
    }
  }

  /*! Bound on the rounding errors of deviations: 2^-13 bins. Outer planes are at least 2 containmentSlack, 2^-19,
   *  apart, so a cell is at least 2^-23 wide (minCellWidth), and positions in cells have errors below 2^-25. The
   *  heights of a cell differ by at most 128 bins, so errors of positions change heights by a few 2^-18 bins. */
  Double4 margin() const { return Double4(binSize) * (1.0 / 8192); }

  /*! As raiseToVertices(), for one vertex. */
  template<int v>
  void raiseToVertex(Mask4 lanes, Double4 slack) {
    const Double4 deficit = slack + groups.vertices[v][2] - surfaceHeight<v>();
    const Double4 bins = min(deficit / nonZero(Double4(binSize)), double(latticeBins)),
                  roundedDown = toDouble(toInt(bins)), roundedUp = roundedDown + ((roundedDown < bins) & Double4(1.0));
    setHeight(v, toDouble(heights[v]) + ((lanes & (Double4(0.0) < deficit)) & roundedUp));
  }

  /*! Raises the surface in lanes on the block's border, as encodeLattice() does. Returns the slack of each lane. */
  Double4 raiseBorder() {
    Double4 slack = computeSlack();
    uint32_t lanes = encoded & (groups.border[0][0] | groups.border[0][1] | groups.border[1][0] | groups.border[1][1]);
    for (int attempt = 1; lanes; attempt++) {
      raiseSide<0, 0>(lanes, slack);
      raiseSide<0, 1>(lanes, slack);
      raiseSide<1, 0>(lanes, slack);
      raiseSide<1, 1>(lanes, slack);
      const Double4 finalSlack = computeSlack();
      lanes &= encoded & (slack < finalSlack).bits();
      if (attempt == maxRaiseAttempts) {
        encoded &= ~lanes;
        break;
      }
      slack = select(maskFromBits(lanes), finalSlack, slack);
    }
    return slack;
  }

  /*! As raiseToVertices() and raiseToEdges(), for the lower (0) or upper (1) side of an axis, in the given lanes in
   *  which the side is on the block's border. */
  template<int axis, int side>
  void raiseSide(uint32_t lanesToRaise, Double4 slack) {
    const uint32_t lanes = groups.border[axis][side] & lanesToRaise & encoded;
    if (!lanes) return;
    const Mask4 mask = maskFromBits(lanes);
    constexpr int step = axis == 0 ? 3 : 1, v = 2 * side * (axis == 0 ? 1 : 3);
    raiseToVertex<v>(mask, slack);
    raiseToVertex<v + step>(mask, slack);
    raiseToVertex<v + 2 * step>(mask, slack);
    computeDeviation<v>();
    computeDeviation<v + step>();
    computeDeviation<v + 2 * step>();
    computeUnitSags();
    const uint32_t isHighEnough = (slack + margin() <= deviationRange<axis, 2 * side>().lowest[1]).bits();
    double slacks[4];
    slack.store(slacks);
    for (uint32_t rest = lanes & ~isHighEnough; rest; rest &= rest - 1) {
      const int lane = int(lowestBit(rest));
      ScalarLane scalar(*this, lane);
      if (raiseToEdges(scalar.lattice, scalar.group, GroupLine(axis, 2 * side), slacks[lane]))
        setHeightsOfLane(scalar.lattice, lane);
      else encoded &= ~(1u << lane);
    }
  }

  /*! As encodeLatticeThickness(). */
  void encodeThickness(Double4 slack) {
    computeDeviation<0>();
    computeDeviation<1>();
    computeDeviation<2>();
    computeDeviation<3>();
    computeDeviation<4>();
    computeDeviation<5>();
    computeDeviation<6>();
    computeDeviation<7>();
    computeDeviation<8>();
    computeUnitSags();
    Double4 lowerBound = 0.0, upperBound = 0.0; // of the largest distance of an edge from the surface
    auto add = [&](const RangeBounds4& range) {
      lowerBound = max(lowerBound, max(Double4(0.0) - range.lowest[0], range.highest[0]));
      upperBound = max(upperBound, max(Double4(0.0) - range.lowest[1], range.highest[1]));
    };
    add(deviationRange<0, 0>());
    add(deviationRange<0, 1>());
    add(deviationRange<0, 2>());
    add(deviationRange<1, 0>());
    add(deviationRange<1, 1>());
    add(deviationRange<1, 2>());
    lowerBound = lowerBound + slack - margin();
    upperBound = upperBound + slack + margin();
    Int4 code = 0;
    uint32_t certain = 15;
    for (uint32_t c = 0; c < 4; c++) {
      const Double4 halfThickness = 0.5 * latticeThickness(c) * Double4(binSize);
      const Mask4 isTooThin = halfThickness < lowerBound;
      certain &= (isTooThin | (upperBound <= halfThickness)).bits();
      code = code + (isTooThin & Int4(1));
    }
    uint32_t codes[4];
    code.store(codes);
    double slacks[4];
    slack.store(slacks);
    for (uint32_t rest = encoded & ~certain; rest; rest &= rest - 1) {
      const int lane = int(lowestBit(rest));
      const ScalarLane scalar(*this, lane);
      codes[lane] = encodeLatticeThickness(scalar.lattice, scalar.group, slacks[lane]);
    }
    for (int lane = 0; lane < 4; lane++) encoded &= ~(uint32_t(codes[lane] == 4) << lane);
    const Int4 coded = Int4::load(codes);
    word = word | (coded << latticeThicknessShift);
    leafThickness = Float4(latticeThickness(codes[0] & 3), latticeThickness(codes[1] & 3),
                           latticeThickness(codes[2] & 3), latticeThickness(codes[3] & 3)) *
                    binSize;
  }

  /*! Copy of one lane, for functions of lattice_encoder.h. */
  struct ScalarLane {
    CodedLattice lattice;
    QuadGroup group; //!< only the vertices

    ScalarLane(const LatticeLanes& l, int lane) {
      auto get = [&](Double4 a) {
        double x[4];
        a.store(x);
        return x[lane];
      };
      for (int axis = 0; axis < 2; axis++)
        for (int i = 0; i < 3; i++) lattice.surface.planes[axis][i] = get(l.planes[axis][i]);
      float bins[2][4];
      l.binsLower.store(bins[0]);
      l.binSize.store(bins[1]);
      lattice.bins = {bins[0][lane], bins[1][lane]};
      for (int v = 0; v < 9; v++) {
        uint32_t h[4];
        l.heights[v].store(h);
        lattice.heights[v] = int(h[lane]);
        lattice.surface.z[v] = get(l.z[v]);
        for (int k = 0; k < 3; k++) group.vertices[v][k] = get(l.groups.vertices[v][k]);
      }
    }
  };

  /*! Replaces the heights of a lane. */
  void setHeightsOfLane(const CodedLattice& lattice, int lane) {
    for (int v = 0; v < 9; v++) {
      uint32_t h[4];
      heights[v].store(h);
      h[lane] = uint32_t(lattice.heights[v]);
      heights[v] = Int4::load(h);
      double all[4];
      z[v].store(all);
      all[lane] = lattice.surface.z[v];
      z[v] = Double4::load(all);
    }
  }

private:
  const NodeBoxes& parents;
  const GroupLanes& groups;
  Float4 binsLower, binSize; //!< HeightBins
  Int4 word;                 //!< the encoded word, see format.h
  Double4 planes[2][3];      //!< decoded, see Lattice
  Double4 widths[2][2];      //!< distances between planes
  Double4 rcpWidths[2][2];   //!< reciprocals of widths
  /*! [axis][line]: true if the middle vertex of a row (axis 0) or column (axis 1) is in the upper cells of the
   *  axis. */
  Mask4 isMiddleUpper[2][3];
  Double4 position[9][2]; //!< of each vertex in its cell
  Int4 heights[9];        //!< codes of heights, in bins
  Double4 z[9];           //!< heights: fitted, then decoded from `heights`
  Double4 deviation[9];   //!< height of the surface above each vertex; set by computeDeviation()
  Double4 unitSag[4];     //!< per cell: sag of a line that advances by 1 on both axes, see deviationRange()
  Double4 leafThickness;
};
}} // namespace embree::cbvh::CBVH_ISA
