// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of cLEAF's groups, leaf_codec.h: fits a lattice through the vertices, bounds
 * how far the quads' edges are from it, and falls back to loose leaves where that is
 * too far. */

#include "leaf_codec.h"
#include <algorithm>
#include <cmath>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    /*! 2 x 2 quads in the frame of their block */
    struct QuadGroup
    {
      double vertices[9][3]; //!< row by row
      ExactBox boxes[4];     //!< of the quads and their rounding, empty for those with a vertex that is not finite
      double rounding[3];    //!< how far vertices may be from where a neighbouring face has them
      bool border[2][2];     //!< [axis][upper]: whether that side is on the border of the block

      bool isOnBorder(int quad, int corner) const {
        for (int axis=0; axis<2; axis++) {
          const int upper = childColumn(corner,axis);
          if (childColumn(quad,axis) == upper && border[axis][upper]) return true;
        }
        return false;
      }

      /*! distance in z that a surface of these slopes keeps from what it bounds */
      double slack(const double slope[2]) const {
        return containmentSlack + rounding[2] + slope[0]*rounding[0] + slope[1]*rounding[1];
      }

      const double* vertexOf(int quad, int corner) const {
        return vertices[(quad&1)+(corner&1) + 3*((quad>>1)+(corner>>1))];
      }
    };

    struct EncodedGroup
    {
      uint32_t word;
      uint64_t heights;
      double borderWidth; //!< see Block::borderWidth; 0 without a side on the border
    };

    /*! piecewise bilinear surface over 3 x 3 heights, in double */
    struct Lattice
    {
      double planes[2][3];
      double z[9];

      struct Position { int corner; double u, v; }; //!< lower vertex of the cell, position in it

      Position find(double x, double y) const {
        return in(x >= planes[0][1],y >= planes[1][1],x,y);
      }
      Position in(int column, int row, double x, double y) const {
        return { column + 3*row, (x-planes[0][column])/(planes[0][column+1]-planes[0][column]),
                                 (y-planes[1][row])/(planes[1][row+1]-planes[1][row]) };
      }
      /*! largest slope along an axis: that of a bilinear patch is largest on its sides */
      double steepest(int axis) const
      {
        double slope = 0;
        for (int line=0; line<3; line++)
          for (int i=0; i<2; i++) {
            const int v = axis == 0 ? i+3*line : line+3*i;
            slope = std::max(slope,std::fabs(z[v+(axis == 0 ? 1 : 3)]-z[v])/(planes[axis][i+1]-planes[axis][i]));
          }
        return slope;
      }
      double twist(int corner) const { return z[corner]-z[corner+1]-z[corner+3]+z[corner+4]; }
      double at(const Position& p) const {
        const double* h = z+p.corner;
        return h[0] + p.u*(h[1]-h[0]) + p.v*(h[3]-h[0]) + p.u*p.v*twist(p.corner);
      }

      struct Range {
        double lower, upper;
        void extend(const Range& r) { lower = std::min(lower,r.lower); upper = std::max(upper,r.upper); }
        double largest() const { return std::max(-lower,upper); }
      };

      /*! Distance in z of the surface from the straight edge from a to b, positive where
       *  the surface is above. Between the planes that it crosses the surface is a
       *  parabola over the edge, off its chord by at most a quarter of its quadratic term. */
      Range distance(const double a[3], const double b[3]) const
      {
        double cut[4] = { 0,1,1,1 };
        int pieces = 0;
        for (int axis=0; axis<2; axis++) {
          const double t = (planes[axis][1]-a[axis])/(b[axis]-a[axis]);
          if (t > 0 && t < 1) cut[++pieces] = t;
        }
        if (pieces == 2 && cut[1] > cut[2]) std::swap(cut[1],cut[2]);
        cut[++pieces] = 1;
        Range range = { 1e300,-1e300 };
        for (int i=0; i<pieces; i++)
        {
          auto point = [&](double t, int axis) { return a[axis] + t*(b[axis]-a[axis]); };
          const double middle = 0.5*(cut[i]+cut[i+1]);
          const int column = point(middle,0) >= planes[0][1], row = point(middle,1) >= planes[1][1];
          const Position p = in(column,row,point(cut[i],0),point(cut[i],1)), q = in(column,row,point(cut[i+1],0),point(cut[i+1],1));
          const double d0 = at(p)-point(cut[i],2), d1 = at(q)-point(cut[i+1],2);
          const double sag = -0.25*twist(p.corner)*(q.u-p.u)*(q.v-p.v);
          range.extend({ std::min(d0,d1) + std::min(sag,0.0), std::max(d0,d1) + std::max(sag,0.0) });
        }
        return range;
      }
    };

    /*! the two edges of a row or column of the group: 0 and 2 its sides, 1 the middle */
    struct GroupLine
    {
      int vertex[3];
      GroupLine(int axis, int line) {
        for (int i=0; i<3; i++) vertex[i] = axis == 0 ? line+3*i : 3*line+i;
      }
      Lattice::Range distance(const Lattice& lattice, const QuadGroup& group) const {
        Lattice::Range range = lattice.distance(group.vertices[vertex[0]],group.vertices[vertex[1]]);
        range.extend(lattice.distance(group.vertices[vertex[1]],group.vertices[vertex[2]]));
        return range;
      }
    };

    /*! how far the edges on the border reach into their leaves' boxes */
    inline double borderWidth(const QuadGroup& group, const EncodedGroup& encoded, const NodeBox& parent)
    {
      double width = 0;
      for (int quad=0; quad<4; quad++)
      {
        if (group.boxes[quad].empty()) continue;
        const NodeBox box = decodeLeaf(encoded.word,encoded.heights,quad,parent).box;
        for (int axis=0; axis<2; axis++)
        {
          const int upper = childColumn(quad,axis);
          if (!group.border[axis][upper]) continue;
          for (int c=0; c<4; c++) {
            if (childColumn(c,axis) != upper) continue;
            const double u = (group.vertexOf(quad,c)[axis]-box.lower[axis])/box.extent[axis];
            width = std::max(width,(upper ? 1-u : u) + group.rounding[axis]/box.extent[axis] + 1e-3); // rounding of the ray's u
          }
        }
      }
      return width;
    }

    /*! Planes of the lattice: the outer ones keep the slack to all vertices, the middle
     *  ones are nearest to the mean of the vertices on them. False if the vertices of
     *  an outer side on the block's border are not all in the cells on that side: the
     *  intersector looks for the border there. */
    inline bool encodeLatticePlanes(const NodeBox& parent, const QuadGroup& group, int axis, uint32_t& word, double planes[3])
    {
      const int along = axis == 0 ? 1 : 3, across = axis == 0 ? 3 : 1;
      double lower = group.boxes[0].lower[axis], upper = group.boxes[0].upper[axis];
      for (const ExactBox& box : group.boxes) {
        lower = std::min(lower,box.lower[axis]);
        upper = std::max(upper,box.upper[axis]);
      }
      double mean = 0;
      for (int i=0; i<3; i++) mean += group.vertices[along + i*across][axis]*(1.0/3);

      uint32_t low = 0, high = 0;
      const float l = parent.lower[axis], e = parent.extent[axis];
      for (uint32_t q=1; q<32; q++) {
        if (l + latticeOuter(q)*e <= lower-containmentSlack) low = q;
        if (l + (1.0f-latticeOuter(q))*e >= upper+containmentSlack) high = q;
      }
      const double middle = std::floor(((mean-l)/e*128 - 33)*0.5 + 0.5);
      const uint32_t m = middle < 0 ? 0 : middle > 31 ? 31 : uint32_t(middle);
      word |= (low | (high << 5) | (m << 10)) << latticeShift(axis);

      float decoded[3];
      latticePlanes(word,axis,parent,decoded);
      for (int i=0; i<3; i++) planes[i] = decoded[i];
      const double narrowest = (planes[2]-planes[0])*(1.0/16);
      if (!(planes[1]-planes[0] > narrowest) || !(planes[2]-planes[1] > narrowest)) return false;
      for (int i=0; i<3; i++) {
        if (group.border[axis][0] && group.vertices[i*across][axis] > planes[1]-containmentSlack-group.rounding[axis]) return false;
        if (group.border[axis][1] && group.vertices[2*along + i*across][axis] < planes[1]+containmentSlack+group.rounding[axis]) return false;
      }
      return true;
    }

    /*! Fits heights whose surface passes through the vertices: each vertex moves the
     *  height at its own node by what the surface is off there, in turns. That
     *  converges where its own node has most weight at a vertex; where it does not, the
     *  deviation tells. */
    inline void fitLattice(const QuadGroup& group, Lattice& lattice, double tolerance)
    {
      Lattice::Position at[9];
      for (int v=0; v<9; v++) {
        at[v] = lattice.find(group.vertices[v][0],group.vertices[v][1]);
        lattice.z[v] = group.vertices[v][2];
      }
      for (int turn=0; turn<16; turn++)
      {
        double worst = 0;
        for (int v=0; v<9; v++) {
          const double off = group.vertices[v][2]-lattice.at(at[v]);
          lattice.z[v] += off;
          worst = std::max(worst,std::fabs(off));
        }
        if (!(worst > tolerance)) break;
      }
    }

    /*! false if no lattice is near enough to the group's quads */
    inline bool encodeLattice(const NodeBox& parent, const QuadGroup& group, EncodedGroup& out)
    {
      for (const ExactBox& box : group.boxes)
        if (box.empty()) return false;
      Lattice lattice;
      uint32_t word = 0;
      for (int axis=0; axis<2; axis++)
        if (!encodeLatticePlanes(parent,group,axis,word,lattice.planes[axis])) return false;

      const HeightBins bins(parent,latticeRange,latticeBins);
      fitLattice(group,lattice,0.0625*bins.size);
      int heights[9];
      auto setHeight = [&](int v, double q) {
        heights[v] = !(q > 0) ? 0 : q < latticeBins-1 ? int(q) : latticeBins-1;
        lattice.z[v] = bins.z(float(heights[v]));
      };
      for (int v=0; v<9; v++) setHeight(v,std::floor((lattice.z[v]-bins.lower)/bins.size));

      /* on the border the surface may not be below the edge */
      const double slopes[2] = { lattice.steepest(0),lattice.steepest(1) }, slack = group.slack(slopes);
      for (int axis=0; axis<2; axis++)
        for (int upper=0; upper<2; upper++)
        {
          if (!group.border[axis][upper]) continue;
          const GroupLine side(axis,2*upper);
          auto raise = [&](int v, double below) { if (below > 0) setHeight(v,heights[v]+std::ceil(below/bins.size)); };
          for (int v : side.vertex) {
            const double* p = group.vertices[v];
            raise(v,slack + p[2] - lattice.at(lattice.find(p[0],p[1])));
          }
          for (int turn=0; ; turn++) {
            const double below = slack - side.distance(lattice,group).lower;
            if (below <= 0) break;
            if (!(below < 4*bins.size) || turn == 4) return false;
            for (int v : side.vertex) raise(v,below);
          }
        }

      Lattice::Range range = { 0,0 };
      for (int axis=0; axis<2; axis++)
        for (int line=0; line<3; line++)
          range.extend(GroupLine(axis,line).distance(lattice,group));
      const double deviation = range.largest();
      uint32_t code = 0;
      while (code < 4 && !(0.5*latticeThickness[code]*bins.size >= deviation+slack)) code++;
      if (code == 4) return false;
      out.word = word | (code << latticeThicknessShift);
      out.heights = packLattice(heights);
      return true;
    }

    /*! the plane nearest to the four vertices of a quad, over its leaf's box: heights at
     *  corners (0,0), (1,0), (0,1). Damped, so that a direction without extent gets no slope. */
    inline void fitPlane(const NodeBox& box, const QuadGroup& group, int quad, double z[3])
    {
      double u[4], v[4], mu = 0, mv = 0, mz = 0, suu = 1e-9, suv = 0, svv = 1e-9, suz = 0, svz = 0;
      for (int c=0; c<4; c++) {
        const double* p = group.vertexOf(quad,c);
        u[c] = (p[0]-box.lower[0])/box.extent[0];
        v[c] = (p[1]-box.lower[1])/box.extent[1];
        mu += 0.25*u[c]; mv += 0.25*v[c]; mz += 0.25*p[2];
      }
      for (int c=0; c<4; c++) {
        const double du = u[c]-mu, dv = v[c]-mv, dz = group.vertexOf(quad,c)[2]-mz;
        suu += du*du; suv += du*dv; svv += dv*dv; suz += du*dz; svz += dv*dz;
      }
      const double det = suu*svv - suv*suv;
      const double a = det > 0 ? (suz*svv - svz*suv)/det : 0;
      const double b = det > 0 ? (svz*suu - suz*suv)/det : 0;
      z[0] = mz - a*mu - b*mv;
      z[1] = z[0] + a;
      z[2] = z[0] + b;
    }

    /*! A loose leaf, and the smallest thickness code that bounds its quad: a plane that is
     *  near the vertices is near the edges. Solid if none does. */
    inline uint32_t encodeLooseLeaf(const NodeBox& box, const QuadGroup& group, int quad, uint32_t& thickness)
    {
      thickness = 0;
      if (group.boxes[quad].empty()) return emptyLeaf;
      const HeightBins bins(box,looseRange,looseBins);
      double z[3];
      fitPlane(box,group,quad,z);
      uint32_t leaf = 0;
      for (int c=0; c<3; c++) {
        const double q = std::floor((z[c]-bins.lower)/bins.size);
        const uint32_t height = !(q > 0) ? 0 : q < looseBins-1 ? uint32_t(q) : looseBins-1;
        leaf |= height << (5*c);
        z[c] = bins.z(float(height));
      }
      const double slopes[2] = { std::fabs(z[1]-z[0])/box.extent[0],std::fabs(z[2]-z[0])/box.extent[1] }, slack = group.slack(slopes);
      double lowest = 0, highest = 0; // of the plane over the vertices, and over those on the border
      double lowestBorder = 1e300;
      for (int c=0; c<4; c++) {
        const double* p = group.vertexOf(quad,c);
        const double u = (p[0]-box.lower[0])/box.extent[0], v = (p[1]-box.lower[1])/box.extent[1];
        const double d = z[0] + u*(z[1]-z[0]) + v*(z[2]-z[0]) - p[2];
        lowest = std::min(lowest,d);
        highest = std::max(highest,d);
        if (group.isOnBorder(quad,c)) lowestBorder = std::min(lowestBorder,d);
      }
      /* on the border the surface may not be below the edge */
      if (lowestBorder < slack)
      {
        const double up = std::ceil((slack-lowestBorder)/bins.size);
        if (!(up < looseBins)) return solidLeaf;
        for (int c=0; c<3; c++) {
          if (looseHeight(leaf,c) + int(up) >= looseBins) return solidLeaf;
          leaf += uint32_t(up) << (5*c);
        }
        lowest += up*bins.size;
        highest += up*bins.size;
      }
      if (leaf == solidLeaf || leaf == emptyLeaf) return solidLeaf;
      const double deviation = std::max(-lowest,highest);
      while (thickness < 8 && !(0.5*looseThickness[thickness]*bins.size >= deviation+slack)) thickness++;
      if (thickness < 8) return leaf;
      thickness = 0;
      return solidLeaf;
    }

    inline EncodedGroup encodeLoose(const NodeBox& parent, const QuadGroup& group)
    {
      EncodedGroup out = { encodeNode(parent,group.boxes), uint64_t(1) << 63, 0 };
      uint32_t code = 0;
      for (int c=0; c<4; c++) {
        uint32_t thickness;
        out.heights |= uint64_t(encodeLooseLeaf(decodeChild(out.word,c,parent),group,c,thickness)) << (looseBits*c);
        code = std::max(code,thickness);
      }
      out.heights |= uint64_t(code) << looseThicknessShift;
      return out;
    }

    inline EncodedGroup encodeGroup(const NodeBox& parent, const QuadGroup& group)
    {
      EncodedGroup out;
      if (!encodeLattice(parent,group,out)) out = encodeLoose(parent,group);
      out.borderWidth = borderWidth(group,out,parent);
      return out;
    }
  }}
}
