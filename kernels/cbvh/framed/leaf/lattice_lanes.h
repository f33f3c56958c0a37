// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* lattice_encoder.h for four groups at a time, one per lane, with the same bits. Supports regular groups: vertices
 * outside of the middle column and row are on their own side of the middle planes.
 *
 *    6 .   7   . 8      6 is in cell 2, 7 in 2 or 3, 4 in any.
 *      .       .        All positions in cells are then from 0 to 1.
 *    3     4     5
 *      .       .
 *    0 .   1   . 2
 *
 * Distances of edges from the surface are computed as two bounds. lattice_encoder.h decides if these lead to different
 * results, and encodes irregular groups. */

#include "group_lanes.h"
#include "lattice_encoder.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class LatticeLanes
    {
    public:
      uint32_t encoded = 15;   //!< mask of lanes with a lattice
      uint32_t undecided = 0;  //!< mask of lanes that lattice_encoder.h must encode

      /*! parents: decoded boxes of the groups. Both arguments must outlive the object. */
      LatticeLanes(const NodeBoxes& parents, const GroupLanes& groups)
        : parents(parents), groups(groups),
          lower(Float4::load(parents.lower[2]) - Float4(0.5f*(latticeRange-1.0f))*Float4::load(parents.extent[2])),
          size(Float4::load(parents.extent[2])*(latticeRange/float(latticeBins))) {}

      void encode()
      {
        for (int axis=0; axis<2; axis++) encodePlanes(axis);
        if (encoded == 0) return;
        findCells();
        if (encoded == 0) return;
        fit();
        for (int v=0; v<9; v++) set(v,(z[v]-lower)/size);
        const Double4 slack = slackOf();
        raise<0,0>(slack);
        raise<0,1>(slack);
        raise<1,0>(slack);
        raise<1,1>(slack);
        if (encoded) encodeThickness(slack);
      }

      /*! Stores words and heights of all lanes, undefined for those that are not encoded. */
      void store(uint32_t words[4], Heights out[4]) const
      {
        const Int4* const h = heights;
        Int4 low  = h[0] | (h[1] << 8) | (h[2] << 16) | (h[3] << 24),
          high = h[5] | (h[6] << 8) | (h[7] << 16) | (h[8] << 24);
        for (int i=0; i<7; i++) {
          Int4& half = i < 4 ? low : high;
          half = half | ((h[4] >> i << 31) >> (24-8*(i%4)));
        }
        word.store(words);
        uint32_t halves[2][4];
        low.store(halves[0]);
        high.store(halves[1]);
        for (int lane=0; lane<4; lane++) out[lane] = { halves[0][lane],halves[1][lane] };
      }

      /* Results of encode(), for leaf_lanes.h: decoded planes, reciprocals of their distances, heights, thickness. */
      Double4 plane(int axis, int i) const { return planes[axis][i]; }
      Double4 reciprocalWidth(int axis, int i) const { return reciprocal[axis][i]; }
      Double4 height(int v) const { return z[v]; }
      Double4 thickness() const { return leafThickness; }

    private:
      /*! Highest code, up to 31, for which closure(latticeOuterOffset(code)) is true, or 0. If it is true for a code,
       *  it must be true for all lower codes. */
      template<typename Closure>
      static Int4 highestCodes(const Closure& closure)
      {
        Int4 codes = 0;
        for (int bit=16; bit; bit/=2) codes = codes | (closure(outerOffsetsOf(codes | Int4(bit))) & Int4(bit));
        return codes;
      }

      /*! latticeOuterOffset() of each lane's code. */
      static Float4 outerOffsetsOf(Int4 codes) { return toFloat((codes << 2) + (square(codes) >> 2))*(1.0f/1024.0f); }

      /*! As encodeLatticePlanes(). */
      void encodePlanes(int axis)
      {
        const int along = axis == 0 ? 1 : 3, across = axis == 0 ? 3 : 1;
        const Float4 l = Float4::load(parents.lower[axis]), e = Float4::load(parents.extent[axis]);
        const Double4 below = groups.lower[axis]-containmentSlack, above = groups.upper[axis]+containmentSlack;
        const Int4 low  = highestCodes([&](Float4 outer) { return Double4(l + outer*e) <= below; });
        const Int4 high = highestCodes([&](Float4 outer) { return above <= Double4(l + (Float4(1.0f)-outer)*e); });
        auto third = [&](int i) { return groups.vertices[along+i*across][axis]*(1.0/3); };
        const Double4 mean = third(0)+third(1)+third(2);
        const Double4 middle = ((mean-l)/e*128.0 - 33.0)*0.5 + 0.5;
        const Int4 m = toInt(min(max(middle,0.0),31.0));
        const Int4 code = low | (high << 5) | (m << 10);
        word = axis == 0 ? code : word | (code << latticeShift(1));

        Double4* const p = planes[axis];
        p[0] = l + outerOffsetsOf(low)*e;
        p[1] = l + toFloat(Int4(33) + (m << 1))*(1.0f/128.0f)*e;
        p[2] = l + (Float4(1.0f)-outerOffsetsOf(high))*e;
        for (int i=0; i<2; i++) { width[axis][i] = p[i+1]-p[i]; reciprocal[axis][i] = Double4(1.0)/width[axis][i]; }
        const Double4 narrowest = (p[2]-p[0])*minCellWidth;
        encoded &= ((narrowest < width[axis][0]) & (narrowest < width[axis][1])).bits();
        for (int i=0; i<3; i++) {
          encoded &= ~(groups.border[axis][0]
            & (p[1]-containmentSlack-groups.rounding[axis] < groups.vertices[i*across][axis]).bits());
          encoded &= ~(groups.border[axis][1]
            & (groups.vertices[2*along+i*across][axis] < p[1]+containmentSlack+groups.rounding[axis]).bits());
        }
      }

      /*! Sets `position`, `upper` and `undecided`. */
      void findCells()
      {
        uint32_t irregular = 0;
        for (int axis=0; axis<2; axis++)
          for (int v=0; v<9; v++)
          {
            const int step = axis == 0 ? v%3 : v/3;
            const Double4 x = groups.vertices[v][axis];
            const Mask4 isUpper = planes[axis][1] <= x;
            if (step == 1) upper[axis][axis == 0 ? v/3 : v%3] = isUpper;
            else irregular |= isUpper.bits() ^ (step == 2 ? 15 : 0);
            position[v][axis] = step == 0 ? (x-planes[axis][0])/width[axis][0]
                        : step == 2 ? (x-planes[axis][1])/width[axis][1]
                        : (x-select(isUpper,planes[axis][1],planes[axis][0]))/select(isUpper,width[axis][1],
                          width[axis][0]);
          }
        undecided = irregular & encoded;
        encoded &= ~irregular;
      }

      /*! Height of the surface at corner (dx,dy) of the cell of vertex v. */
      template<int v, int dx, int dy>
      Double4 corner() const
      {
        auto row = [&](int j) { return v%3 == 1 ? select(upper[0][v/3],z[3*j+dx+1],z[3*j+dx]) : z[3*j+dx+v%3/2]; };
        return v/3 == 1 ? select(upper[1][v%3],row(dy+1),row(dy)) : row(dy+v/3/2);
      }

      /*! Height of the surface at vertex v. */
      template<int v>
      Double4 surface() const
      {
        const Double4 a = corner<v,0,0>(), b = corner<v,1,0>(), c = corner<v,0,1>(), d = corner<v,1,1>();
        return a + position[v][0]*(b-a) + position[v][1]*(c-a) + position[v][0]*position[v][1]*(a-b-c+d);
      }

      /*! Moves the height of vertex v by the distance of the surface from it. Raises `largest` to that distance. */
      template<int v>
      void moveToVertex(Mask4 active, Double4& largest)
      {
        const Double4 change = active & (groups.vertices[v][2]-surface<v>());
        z[v] = z[v]+change;
        largest = max(largest,abs(change));
      }

      /*! As fitLattice(). */
      void fit()
      {
        for (int v=0; v<9; v++) z[v] = groups.vertices[v][2];
        const Double4 tolerance = Double4(size)*fitTolerance;
        uint32_t active = encoded;
        for (int iteration=0; iteration<maxFitIterations && active; iteration++)
        {
          const Mask4 mask = maskFromBits(active);
          Double4 largest = 0.0;
          moveToVertex<0>(mask,largest); moveToVertex<1>(mask,largest); moveToVertex<2>(mask,largest);
          moveToVertex<3>(mask,largest); moveToVertex<4>(mask,largest); moveToVertex<5>(mask,largest);
          moveToVertex<6>(mask,largest); moveToVertex<7>(mask,largest); moveToVertex<8>(mask,largest);
          active &= (tolerance < largest).bits();
        }
      }

      /*! As CodedLattice::set(). */
      void set(int v, Double4 q)
      {
        heights[v] = toInt(min(max(q,0.0),double(latticeBins-1)));
        z[v] = lower + (toFloat(heights[v])+0.5f)*size;
      }

      /*! QuadGroup::slack() with the slopes of the coded heights. */
      Double4 slackOf() const
      {
        Double4 slope[2];
        for (int axis=0; axis<2; axis++)
        {
          Double4 rise[2] = { 0.0,0.0 }; // largest differences of heights in both cells
          for (int line=0; line<3; line++)
            for (int i=0; i<2; i++) {
              const int v = axis == 0 ? i+3*line : line+3*i;
              rise[i] = max(rise[i],abs(z[v+(axis == 0 ? 1 : 3)]-z[v]));
            }
          slope[axis] = max(rise[0]/width[axis][0],rise[1]/width[axis][1]);
        }
        return Double4(containmentSlack + groups.rounding[2]) + slope[0]*groups.rounding[0]
          + slope[1]*groups.rounding[1];
      }

      /*! Where the edge from a to b crosses the middle plane of an axis. */
      struct LineCrossing
      {
        Double4 t, across, z; //!< fraction of the edge, position on the other axis, height of the edge

        LineCrossing(const LatticeLanes& l, int axis, const Double4 a[3], const Double4 b[3])
        {
          t = (l.planes[axis][1]-a[axis])/(b[axis]-a[axis]);
          across = a[1-axis] + t*(b[1-axis]-a[1-axis]);
          z = a[2] + t*(b[2]-a[2]);
        }
      };

      /*! Deviation at a crossing: height of the surface above the edge. isUpper: the crossing is in the upper cells of
       *  the other axis. */
      Double4 deviationAt(const LineCrossing& p, int axis, Mask4 isUpper) const
      {
        const int other = 1-axis, step = axis == 0 ? 3 : 1, first = axis == 0 ? 1 : 3; // indices of heights
        const Double4 from = select(isUpper,z[first+step],z[first]), to = select(isUpper,z[first+2*step],z[first+step]);
        const Double4 u = (p.across-select(isUpper,planes[other][1],planes[other][0]))*select(isUpper,
          reciprocal[other][1],reciprocal[other][0]);
        return from + u*(to-from) - p.z;
      }

      /*! Bounds of a Lattice::Range per lane. The exact range contains lowest[0] to highest[0], and lies within
       *  lowest[1] to highest[1]. They differ only in middle rows and columns. */
      struct RangeBounds4
      {
        Double4 lowest[2] = { 1e300,1e300 }, highest[2] = { -1e300,-1e300 };

        void add(Double4 low, Double4 high, int bound) {
          lowest[bound] = min(lowest[bound],low);
          highest[bound] = max(highest[bound],high);
        }
      };

      /*! Bounds of GroupLine::deviationRange(). The edges of the row (axis 1) or column (axis 0) cross the middle plane
       *  at x, before or after vertex b, which results in three pieces. Each differs from its chord by its sag.
       *
       *    a-----x--b--------c    the plane is at x */
      template<int axis, int line>
      RangeBounds4 deviationRange() const
      {
        constexpr int along = 1-axis, step = axis == 0 ? 3 : 1, v = axis == 0 ? line : 3*line;
        const Double4 *const a = groups.vertices[v], *const b = groups.vertices[v+step],
          *const c = groups.vertices[v+2*step];
        const Double4 da = deviation[v], db = deviation[v+step], dc = deviation[v+2*step];
        RangeBounds4 range;

        const Mask4 first = upper[along][line]; // the edge crosses the plane before b
        Double4 from[3], to[3];
        for (int k=0; k<3; k++) { from[k] = select(first,a[k],b[k]); to[k] = select(first,b[k],c[k]); }
        const LineCrossing x(*this,along,from,to);
        const Double4 dx = deviationAt(x,along,
          line == 0 ? maskFromBits(0) : line == 2 ? maskFromBits(15) : planes[axis][1] <= x.across);

        /* products of the pieces' extents on both axes */
        const Double4 t2 = x.t*x.t, rest2 = (1.0-x.t)*(1.0-x.t);
        const Double4 ab = (b[0]-a[0])*(b[1]-a[1]), bc = (c[0]-b[0])*(c[1]-b[1]);
        const Double4 piece[3] = { ab*select(first,t2,1.0),select(first,ab*rest2,bc*t2),bc*select(first,1.0,rest2) };
        const Double4 ends[4] = { da,select(first,dx,db),select(first,db,dx),dc };
        Double4 largest = 0.0;
        auto cell = [&](int i, int j) { return unitSag[axis == 1 ? i+2*j : j+2*i]; };
        for (int i=0; i<3; i++)
        {
          const Double4 low = min(ends[i],ends[i+1]), high = max(ends[i],ends[i+1]);
          auto factor = [&](int j) {
            return i == 0 ? cell(0,j) : i == 2 ? cell(1,j) : select(first,cell(1,j),cell(0,j));
          };
          if (line != 1) {
            const Double4 sag = piece[i]*factor(line/2);
            for (int bound=0; bound<2; bound++) range.add(low+min(sag,0.0),high+max(sag,0.0),bound);
          }
          else {
            const Double4 sag = abs(piece[i])*max(abs(factor(0)),abs(factor(1)));
            range.add(low,high,0);
            range.add(low-sag,high+sag,1);
            largest = max(largest,sag);
          }
        }
        /* These edges may also cross the other plane. Parts of pieces sag less. */
        if (line == 1)
          for (int i=0; i<2; i++) {
            const LineCrossing y(*this,axis,i == 0 ? a : b,i == 0 ? b : c);
            const Mask4 crosses = maskFromBits(upper[axis][i].bits() ^ upper[axis][i+1].bits());
            const Double4 dy = select(crosses,deviationAt(y,axis,planes[along][1] <= y.across),db);
            range.add(dy,dy,0);
            range.add(dy-largest,dy+largest,1);
          }
        return range;
      }

      template<int v>
      void computeDeviation() { deviation[v] = surface<v>()-groups.vertices[v][2]; }

      void computeUnitSags()
      {
        for (int i=0; i<4; i++) {
          const Double4* const h = z + i%2 + 3*(i/2);
          unitSag[i] = -0.25*(h[0]-h[1]-h[3]+h[4])*reciprocal[0][i%2]*reciprocal[1][i/2];
        }
      }

      /*! Difference above which a comparison is certain: 1/8192 of a bin. Positions in cells, which are at least 2^-23
       *  wide, have errors below 2^-25; heights, up to 128 bins, have errors below this. */
      Double4 margin() const { return Double4(size)*(1.0/8192); }

      /*! As raiseToVertices(), for one vertex. */
      template<int v>
      void raiseToVertex(Mask4 lanes, Double4 slack)
      {
        const Double4 below = slack + groups.vertices[v][2] - surface<v>();
        const Double4 bins = min(below/size,double(latticeBins)), down = toDouble(toInt(bins)),
          up = down + ((down < bins) & Double4(1.0));
        set(v,toDouble(heights[v]) + ((lanes & (Double4(0.0) < below)) & up));
      }

      /*! As raiseToVertices() and raiseToEdges(). */
      template<int axis, int upper>
      void raise(Double4 slack)
      {
        const uint32_t lanes = groups.border[axis][upper] & encoded;
        if (!lanes) return;
        const Mask4 mask = maskFromBits(lanes);
        constexpr int step = axis == 0 ? 3 : 1, v = 2*upper*(axis == 0 ? 1 : 3);
        raiseToVertex<v>(mask,slack);
        raiseToVertex<v+step>(mask,slack);
        raiseToVertex<v+2*step>(mask,slack);
        computeDeviation<v>();
        computeDeviation<v+step>();
        computeDeviation<v+2*step>();
        computeUnitSags();
        const uint32_t certain = (slack+margin() <= deviationRange<axis,2*upper>().lowest[1]).bits();
        double slacks[4];
        slack.store(slacks);
        for (uint32_t rest = lanes & ~certain; rest; rest &= rest-1)
        {
          const int lane = int(lowestBit(rest));
          ScalarLane scalar(*this,lane);
          if (raiseToEdges(scalar.lattice,scalar.group,GroupLine(axis,2*upper),slacks[lane]))
            setLane(scalar.lattice,lane);
          else encoded &= ~(1u << lane);
        }
      }

      /*! As encodeLatticeThickness(). */
      void encodeThickness(Double4 slack)
      {
        computeDeviation<0>(); computeDeviation<1>(); computeDeviation<2>();
        computeDeviation<3>(); computeDeviation<4>(); computeDeviation<5>();
        computeDeviation<6>(); computeDeviation<7>(); computeDeviation<8>();
        computeUnitSags();
        Double4 least = 0.0, most = 0.0;
        auto add = [&](const RangeBounds4& range) {
          least = max(least,max(Double4(0.0)-range.lowest[0],range.highest[0]));
          most = max(most,max(Double4(0.0)-range.lowest[1],range.highest[1]));
        };
        add(deviationRange<0,0>()); add(deviationRange<0,1>()); add(deviationRange<0,2>());
        add(deviationRange<1,0>()); add(deviationRange<1,1>()); add(deviationRange<1,2>());
        least = least+slack-margin();
        most = most+slack+margin();
        Int4 code = 0;
        uint32_t certain = 15;
        for (uint32_t c=0; c<4; c++) {
          const Double4 bound = 0.5*latticeThickness(c)*Double4(size);
          const Mask4 fails = bound < least;
          certain &= (fails | (most <= bound)).bits();
          code = code + (fails & Int4(1));
        }
        uint32_t codes[4];
        code.store(codes);
        double slacks[4];
        slack.store(slacks);
        for (uint32_t rest = encoded & ~certain; rest; rest &= rest-1)
        {
          const int lane = int(lowestBit(rest));
          const ScalarLane scalar(*this,lane);
          codes[lane] = encodeLatticeThickness(scalar.lattice,scalar.group,slacks[lane]);
        }
        for (int lane=0; lane<4; lane++) encoded &= ~(uint32_t(codes[lane] == 4) << lane);
        const Int4 coded = Int4::load(codes);
        word = word | (coded << latticeThicknessShift);
        leafThickness = Float4(latticeThickness(codes[0]&3),latticeThickness(codes[1]&3),latticeThickness(codes[2]&3),
          latticeThickness(codes[3]&3))*size;
      }

      /*! One lane, for lattice_encoder.h. */
      struct ScalarLane
      {
        CodedLattice lattice;
        QuadGroup group; //!< only the vertices

        ScalarLane(const LatticeLanes& l, int lane)
        {
          auto get = [&](Double4 a) { double x[4]; a.store(x); return x[lane]; };
          for (int axis=0; axis<2; axis++)
            for (int i=0; i<3; i++) lattice.surface.planes[axis][i] = get(l.planes[axis][i]);
          float bins[2][4];
          l.lower.store(bins[0]);
          l.size.store(bins[1]);
          lattice.bins = { bins[0][lane],bins[1][lane] };
          for (int v=0; v<9; v++) {
            uint32_t h[4];
            l.heights[v].store(h);
            lattice.heights[v] = int(h[lane]);
            lattice.surface.z[v] = get(l.z[v]);
            for (int k=0; k<3; k++) group.vertices[v][k] = get(l.groups.vertices[v][k]);
          }
        }
      };

      void setLane(const CodedLattice& lattice, int lane)
      {
        for (int v=0; v<9; v++)
        {
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
      Float4 lower, size;      //!< HeightBins of each lane
      Int4 word;
      Double4 planes[2][3], width[2][2], reciprocal[2][2]; //!< width: distances of planes
      Mask4 upper[2][3];       //!< [axis][line]: true if the middle vertex is in the upper cell
      Double4 position[9][2];  //!< of each vertex in its cell
      Int4 heights[9];
      Double4 z[9];
      Double4 deviation[9];    //!< of the surface from vertices: its height above them; set by computeDeviation()
      Double4 unitSag[4];      //!< per cell: sag of a straight line that advances by 1 on both axes
      Double4 leafThickness;
    };
  }}
}
