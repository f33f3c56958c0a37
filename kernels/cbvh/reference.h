// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Scalar reference decoder and intersector of a block, in double: what the SIMD
 * intersectors must equal. Written for reading, after FORMAT.md: nothing is mirrored,
 * one child at a time, no node is skipped for being behind a hit.
 *
 * The SIMD code widens bounds by the float error of its ray. "widening" says by how
 * many times that the reference widens: 0 is the exact answer, and what SIMD finds
 * lies between the answers for 0 and for 2. */

#include "frame.h"
#include "leaf_codec.h"
#include <limits>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    struct ReferenceRay
    {
      double org[3], dir[3];
      double tnear = 0, tfar = std::numeric_limits<double>::infinity();
    };

    struct ReferenceHit
    {
      bool found = false;
      double t = std::numeric_limits<double>::infinity();
      double u = 0, v = 0;   //!< of the face
      double Ng[3] = {0,0,0};
      uint32_t leaf = 0;     //!< Morton index
    };

    /*! the stored frame, from world points relative to the centre */
    inline FrameMap frameMap(const Block* block)
    {
      auto row = [&](int k, double d) { return Form{ { block->columns[0][k],block->columns[1][k],block->columns[2][k] },d }; };
      return { row(0,0.5),row(1,0.5),row(2,0.5),row(3,1),true };
    }

    /*! what SIMD widens bounds by, axis by axis, times W: local_ray.h */
    inline void rayEpsilon(const Block* block, const ReferenceRay& ray, double epsilon[3])
    {
      const double ulp = std::numeric_limits<float>::epsilon();
      double stretch[4] = { 0,0,0,0 }, distance = 0;
      for (int i=0; i<3; i++) {
        distance = std::fmax(distance,std::fabs(ray.org[i] - double(block->centre[i])));
        for (int k=0; k<4; k++) stretch[k] += std::fabs(double(block->columns[i][k]));
      }
      const double reach = distance + 0.75/std::fmin(std::fmin(stretch[0],stretch[1]),stretch[2]);
      for (int k=0; k<3; k++) epsilon[k] = 4*ulp*reach*(stretch[k]+stretch[3]) + 8*ulp;
    }

    class ReferenceIntersector
    {
    public:
      ReferenceIntersector (const Block* block, double widening = 0)
        : block(block), layout(block->layout()), kind(block->kind()), widening(widening) {}

      ReferenceHit intersect (const ReferenceRay& ray)
      {
        best = ReferenceHit();
        side = 0; pending = fromSurface = false;
        if (!enter(ray)) return best;
        visit(0,0,NodeBox::root());
        return best;
      }

    private:
      /*! clips the ray to the block's box and takes the segment to the frame */
      bool enter (const ReferenceRay& r)
      {
        ray = r;
        double O[4] = { 0.5,0.5,0.5,1 }, D[4] = { 0,0,0,0 };
        for (int i=0; i<3; i++)
        {
          const double o = ray.org[i] - double(block->centre[i]);
          for (int k=0; k<4; k++) {
            O[k] += double(block->columns[i][k])*o;
            D[k] += double(block->columns[i][k])*ray.dir[i];
          }
        }
        rayEpsilon(block,ray,epsilon);
        double t0 = -std::numeric_limits<double>::infinity(), t1 = std::numeric_limits<double>::infinity();
        for (int k=0; k<3; k++) {
          epsilon[k] *= widening;
          clip(O[k]+epsilon[k],D[k],t0,t1);
          clip(O[3]-O[k]+epsilon[k],D[3]-D[k],t0,t1);
        }
        startClipped = ray.tnear > t0;
        endClipped = ray.tfar < t1;
        begin = std::fmax(t0,ray.tnear);
        end = std::fmin(t1,ray.tfar);
        if (!(begin <= end)) return false;
        for (int k=0; k<3; k++) {
          P0[k] = (O[k]+begin*D[k])/(O[3]+begin*D[3]);
          P1[k] = (O[k]+end*D[k])/(O[3]+end*D[3]);
        }
        w0 = O[3]+begin*D[3];
        w1 = O[3]+end*D[3];
        for (int k=0; k<3; k++) epsilon[k] /= std::fmin(w0,w1);
        return w0 > 0 && w1 > 0;
      }

      /*! keeps the part of [t0,t1] where o + t d >= 0 */
      static void clip (double o, double d, double& t0, double& t1)
      {
        if (d > 0) t0 = std::fmax(t0,-o/d);
        else if (d < 0) t1 = std::fmin(t1,-o/d);
        else if (o < 0) t1 = -std::numeric_limits<double>::infinity();
      }

      /*! part of the segment's line in a box, widened */
      bool slab (const NodeBox& box, double& s0, double& s1) const
      {
        s0 = -std::numeric_limits<double>::infinity();
        s1 =  std::numeric_limits<double>::infinity();
        clipAxes(box,3,s0,s1);
        return std::fmax(s0,0.0) <= std::fmin(s1,1.0);
      }

      /*! clips to the first axes of a box, widened */
      void clipAxes (const NodeBox& box, int axes, double& s0, double& s1) const
      {
        for (int k=0; k<axes; k++) {
          clip(P0[k]-double(box.lower[k])+epsilon[k],P1[k]-P0[k],s0,s1);
          clip(double(box.upper(k))-P0[k]+epsilon[k],P0[k]-P1[k],s0,s1);
        }
      }

      /*! Children in the order along the ray: mirror x and y so that it ascends, then 0,
       *  1 and 2 (the one entered first), 3. */
      void visit (uint32_t level, uint32_t m, const NodeBox& box)
      {
        double s0, s1;
        if (!slab(box,s0,s1)) return;
        if (level == layout.nodeLevels) { leaf(m,box,s0,s1); return; }
        const uint32_t node = block->nodes()[nodesOfLevels(level)+m];
        const bool last = kind == Kind::LEAF && level+1 == layout.nodeLevels;
        NodeBox children[4];
        for (int c=0; c<4; c++) {
          if (last) patches[c] = decodeLeaf(node,((const uint64_t*)block->leaves())[m],c,box);
          children[c] = last ? patches[c].box : decodeChild(node,c,box);
        }
        const int flip = (P1[0] < P0[0] ? 1 : 0) | (P1[1] < P0[1] ? 2 : 0);
        int order[4] = { flip, 1^flip, 2^flip, 3^flip };
        const NodeBox middle[2] = { children[order[1]], children[order[2]] };
        if (meets(middle[0]) && meets(middle[1]) && entry(middle[1]) < entry(middle[0])) std::swap(order[1],order[2]);
        for (int c : order)
        {
          const NodeBox child = children[c];
          double c0, c1;
          if (slab(child,c0,c1)) visit(level+1,4*m+uint32_t(c),child);
          else if ((pending || (side == 0 && !best.found)) && meets(child)) passed(isAbove(child));
        }
      }

      /*! whether the segment shares x and y with a box */
      bool meets (const NodeBox& box) const
      {
        double s0 = 0, s1 = 1;
        clipAxes(box,2,s0,s1);
        return s0 <= s1;
      }
      double entry (const NodeBox& box) const
      {
        double s0 = -std::numeric_limits<double>::infinity(), s1 = std::numeric_limits<double>::infinity();
        clipAxes(box,3,s0,s1);
        return s0;
      }
      bool isAbove (const NodeBox& box) const
      {
        double s0 = 0, s1 = 1;
        clipAxes(box,2,s0,s1);
        return P0[2]+0.5*(s0+s1)*(P1[2]-P0[2]) > box.lower[2]+0.5*box.extent[2];
      }

      void leaf (uint32_t m, const NodeBox& box, double s0, double s1)
      {
        switch (kind) {
        case Kind::LEAF : heightLeaf(m,box,s0,s1); break;
        case Kind::VOXEL: if (!(startClipped && s0 < 0)) hit(m,box,std::fmax(s0,0.0),0,0); break;
        case Kind::GRID : gridLeaf(m); break;
        }
      }

      /*! cLEAF's leaves along a side */
      uint32_t cells () const { return 1u << layout.nodeLevels; }

      /*! Whether the ray meets a lip of the leaf between s0 and s1: what is up to half a
       *  thickness below its surface, near a side on the block's border; s is a place. f is
       *  a parabola in s, so its extremes are at the ends of that part or at its vertex. */
      template<typename F>
      bool meetsLip (const F& f, uint32_t m, const NodeBox& box, double reach, double s0, double s1, double& s) const
      {
        const uint32_t cell[2] = { mortonX(m), mortonY(m) }, last = cells()-1;
        for (int axis=0; axis<2; axis++)
          for (int upper=0; upper<2; upper++)
          {
            if (cell[axis] != (upper ? last : 0)) continue;
            const double width = block->borderWidth()*box.extent[axis];
            const double side = upper ? box.upper(axis)-width : box.lower[axis]+width;
            double begin = s0, end = s1;
            if (upper) clip(P0[axis]-side,P1[axis]-P0[axis],begin,end);
            else       clip(side-P0[axis],P0[axis]-P1[axis],begin,end);
            if (!(begin <= end)) continue;
            const double fb = f(begin), fe = f(end), bend = 4*f(0.5*(begin+end)) - 2*(fb+fe); // f = chord + bend k (1-k)
            const double k = 0.5 + 0.5*(fe-fb)/bend;
            double lowest = 1e300, highest = -1e300;
            bool inside = false;
            s = begin;
            auto sample = [&](double at, double value) {
              lowest = std::fmin(lowest,value);
              highest = std::fmax(highest,value);
              if (!inside && value <= epsilon[2] && value >= -(reach+epsilon[2])) { inside = true; s = at; }
            };
            sample(begin,fb);
            sample(end,fe);
            if (k > 0 && k < 1) sample(begin + k*(end-begin),f(begin + k*(end-begin)));
            if (lowest <= epsilon[2] && highest >= -(reach+epsilon[2])) return true;
          }
        return false;
      }

      void passed (bool above)
      {
        const int before = side;
        if (before == (above ? 1 : -1)) return;
        side = above ? 1 : -1;
        if (before == 0) return;
        pending = false;
        hit(exitLeaf,exitBox,exitS,exitSlope[0],exitSlope[1],above ? -1 : 1);
      }

      void heightLeaf (uint32_t m, const NodeBox& box, double sNear, double sFar)
      {
        const LeafPatch& patch = patches[m & 3];
        const bool startsInside = startClipped && sNear < 0, endsInside = endClipped && sFar > 1;
        const double s0 = std::fmax(sNear,0.0), s1 = std::fmin(sFar,1.0);
        if (patch.empty || patch.solid) {
          side = 0; pending = false;
          if (patch.solid && !startsInside) hit(m,box,s0,0,0);
          return;
        }
        const float* z = patch.z;
        const double q[4] = { z[0],z[1],z[2],z[3] };
        auto f = [&](double s) {
          const double u = boxPosition(box,s,0), v = boxPosition(box,s,1);
          return P0[2]+s*(P1[2]-P0[2]) - (q[0] + u*(q[1]-q[0]) + v*(q[2]-q[0]) + u*v*(q[0]-q[1]-q[2]+q[3]));
        };
        auto hitAt = [&](double s, int from) {
          const double u = boxPosition(box,s,0), v = boxPosition(box,s,1);
          hit(m,box,s,(q[1]-q[0] + v*(q[0]-q[1]-q[2]+q[3]))/box.extent[0],
                      (q[2]-q[0] + u*(q[0]-q[1]-q[2]+q[3]))/box.extent[1],from);
        };
        const double f0 = f(s0), f1 = f(s1);
        /* sides: by the patch, unless the ray passes through the upper or lower face */
        const bool up = P1[2] >= P0[2];
        double t0 = -std::numeric_limits<double>::infinity(), t1 = std::numeric_limits<double>::infinity();
        clipAxes(box,2,t0,t1);
        const int enter = sNear > t0 && !startsInside ? (up ? -1 : 1) : f0 >= 0 ? 1 : -1;
        const int leave = sFar  < t1 && !endsInside   ? (up ? 1 : -1) : f1 >= 0 ? 1 : -1;
        const bool crosses = enter != leave || (f0 < 0) != (f1 < 0);
        const double reach = 0.5*double(patch.thickness);
        const double saddle = 4*f(0.5*(s0+s1)) - 2*(f0+f1);
        const bool near0 = std::fabs(f0) <= reach+epsilon[2];
        const bool near = std::fmin(std::fabs(f0),std::fabs(f1)) <= reach+epsilon[2]+0.25*std::fabs(saddle) || (f0 < 0) != (f1 < 0);

        /* f(k) = f0 + k (f1-f0) + saddle k (1-k): bisection, as there is one change of sign */
        auto root = [&]() {
          if ((f0 < 0) == (f1 < 0)) return std::fabs(f0) < std::fabs(f1) ? s0 : s1;
          double lower = s0, upper = s1;
          for (int i=0; i<60; i++) {
            const double middle = 0.5*(lower+upper);
            ((f(middle) < 0) == (f0 < 0) ? lower : upper) = middle;
          }
          return 0.5*(lower+upper);
        };

        /* after a hit only what lies nearer is of interest, where leaves overlap */
        if (best.found) {
          if (crosses) hitAt(root(),0);
          return;
        }
        if (startsInside) fromSurface = near0;
        const bool beyond = fromSurface && !startsInside && side == leave;
        pending = false;
        if (side != 0 && side != enter && !startsInside && !beyond) { hitAt(s0,side); return; }
        if (crosses && !beyond) { hitAt(root(),0); return; }
        double sLip;
        if (!crosses && !startsInside && !endsInside && meetsLip(f,m,box,reach,s0,s1,sLip)) { hitAt(sLip,0); return; }
        side = leave;
        pending = near;
        exitLeaf = m; exitBox = box; exitS = s1;
        const double u = boxPosition(box,s1,0), v = boxPosition(box,s1,1);
        exitSlope[0] = (q[1]-q[0] + v*(q[0]-q[1]-q[2]+q[3]))/box.extent[0];
        exitSlope[1] = (q[2]-q[0] + u*(q[0]-q[1]-q[2]+q[3]))/box.extent[1];
      }

      double boxPosition (const NodeBox& box, double s, int axis) const {
        const double u = (P0[axis]+s*(P1[axis]-P0[axis])-double(box.lower[axis]))/double(box.extent[axis]);
        return u < 0 ? 0 : u > 1 ? 1 : u;
      }

      /*! from: 1 if the ray comes from above, -1 from below, 0 if that is not known; a normal
       *  that faces away from there by less than 30 degrees is mirrored across the ray */
      void hit (uint32_t m, const NodeBox& box, double s, double slopeX, double slopeY, int from = 0)
      {
        const double sw = s*w0, tau = sw/(w1*(1-s)+sw);
        const double t = begin + tau*(end-begin);
        if (!(t < best.t)) return;
        const double P[3] = { P0[0]+s*(P1[0]-P0[0]), P0[1]+s*(P1[1]-P0[1]), P0[2]+s*(P1[2]-P0[2]) };
        setHit(m,t,mortonX(m)+boxPosition(box,s,0),mortonY(m)+boxPosition(box,s,1));
        const double k = P[2] - slopeX*P[0] - slopeY*P[1];
        for (int i=0; i<3; i++) {
          const float* c = block->columns[i];
          best.Ng[i] = -slopeX*c[0] - slopeY*c[1] + c[2] - k*c[3];
        }
        double away = 0, dir2 = 0, Ng2 = 0;
        for (int i=0; i<3; i++) {
          away += best.Ng[i]*ray.dir[i];
          dir2 += ray.dir[i]*ray.dir[i];
          Ng2 += best.Ng[i]*best.Ng[i];
        }
        if (away*from > 0 && away*away < 0.25*Ng2*dir2)
          for (int i=0; i<3; i++) best.Ng[i] -= 2*away/dir2*ray.dir[i];
      }

      void setHit (uint32_t m, double t, double x, double y)
      {
        best.found = true;
        best.t = t;
        best.leaf = m;
        const double size = kind == Kind::LEAF && block->height() == 0 ? 0.5 : 1.0;
        best.u = block->faceU(float(size*x));
        best.v = block->faceV(float(size*y));
      }

      /*! the triangles (00,10,01) and (01,10,11) of every quad of a group */
      void gridLeaf (uint32_t m)
      {
        const uint32_t width = (1u << block->height()) + 1;
        const uint32_t quads = block->height() ? 2 : 1;
        for (uint32_t j=0; j<quads; j++)
          for (uint32_t i=0; i<quads; i++)
          {
            const uint32_t x = quads*mortonX(m)+i, y = quads*mortonY(m)+j;
            double p[4][3];
            for (uint32_t c=0; c<4; c++)
              for (int k=0; k<3; k++)
                p[c][k] = ((const float*)block->leaves())[size_t(k)*width*width + (y+(c>>1))*width + x+(c&1)];
            triangle(m,p[0],p[1],p[2],x,y,1,0,0,1,0,0);
            triangle(m,p[2],p[1],p[3],x,y,1,0,1,1,0,1);
          }
      }

      /*! v0 at (x0,y0) of the quad, v1 at (x1,y1), v2 at (x2,y2), in the argument order
       *  1, 2, 0 of the corners */
      void triangle (uint32_t m, const double v0[3], const double v1[3], const double v2[3], uint32_t x, uint32_t y,
                     double x1, double y1, double x2, double y2, double x0, double y0)
      {
        const Double3 a = { v0[0],v0[1],v0[2] }, b = { v1[0],v1[1],v1[2] }, c = { v2[0],v2[1],v2[2] };
        const Double3 o = { ray.org[0],ray.org[1],ray.org[2] }, d = { ray.dir[0],ray.dir[1],ray.dir[2] };
        const Double3 e1 = b-a, e2 = c-a, n = cross(e1,e2);
        const double den = dot(n,d);
        if (den == 0) return;
        const double t = dot(n,a-o)/den;
        const Double3 p = o + t*d - a;
        const double n2 = dot(n,n);
        const double u = dot(cross(p,e2),n)/n2, v = dot(cross(e1,p),n)/n2;
        const double slack = 1e-9;
        if (u < -slack || v < -slack || u+v > 1+slack || t < ray.tnear || t > ray.tfar || !(t < best.t)) return;
        setHit(m,t,x + x0+u*(x1-x0)+v*(x2-x0),y + y0+u*(y1-y0)+v*(y2-y0));
        best.Ng[0] = n.x; best.Ng[1] = n.y; best.Ng[2] = n.z;
      }

    private:
      const Block* block;
      BlockLayout layout;
      Kind kind;
      double widening;
      ReferenceRay ray;
      ReferenceHit best;
      double P0[3], P1[3], w0, w1;
      double begin, end; //!< world parameter of the segment's ends
      double epsilon[3];
      bool startClipped, endClipped;

      LeafPatch patches[4]; //!< cLEAF: of the group that is being visited

      /* cLEAF: the leaf that the ray left last */
      int side;      //!< 1 above, -1 below, 0 unknown
      bool pending;  //!< within half a thickness of its patch
      bool fromSurface; //!< the ray starts in a leaf, within half a thickness
      uint32_t exitLeaf;
      NodeBox exitBox;
      double exitS, exitSlope[2];
    };
  }}
}
