// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The 32 triangles of a group of cVERT against one ray; vert_ray.h says why none of them can be
 * missed. A quad has those of GRID, (00,10,01) and (01,10,11), and five edges:
 *
 *     01---top---11      A side is computed once a quad; the diagonal serves both
 *      | \        |      triangles.
 *    left  diag  right
 *      |      \   |
 *     00-bottom--10                                                               */

#include "decoder.h"
#include "ray.h"
#include "plane.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! side of the ray on which an edge lies */
      template<typename Number>
      __forceinline Number edgeSide (const Number& ax, const Number& ay, const Number& bx, const Number& by) {
        return product(ax,by) - product(ay,bx);
      }

      /*! whether the ray is on one side of three edges */
      template<typename Vector>
      __forceinline auto isInside (const Vector& a, const Vector& b, const Vector& c) -> decltype(a <= b) {
        return (min(a,min(b,c)) >= Vector(zero)) | (max(a,max(b,c)) <= Vector(zero));
      }

      /*! corners of the quad that a triangle has: 0 or 1, as bits of GroupTriangles say */
      __forceinline uint32_t cornerOfTriangle (uint32_t h, int vertex) { return vertex == 0 ? (h & 1 ? 2 : 0) : vertex == 1 ? 1 : (h & 1 ? 3 : 2); }

      /*! The side of each edge of a triangle on which the ray is, rounded, and their sum; of one ray or of those of a packet. */
      template<typename Real>
      struct TriangleSides
      {
        Real w0, w1, w2, sum;

        /*! of the sheared vertices */
        __forceinline TriangleSides (const Real* x, const Real* y)
          : w0(edgeSide(x[1],y[1],x[2],y[2])), w1(edgeSide(x[2],y[2],x[0],y[0])), w2(edgeSide(x[0],y[0],x[1],y[1])), sum(w0 + w1 + w2) {}

        /*! No side rounded to 0: the signs are exact. Least and greatest in the same order would become a branch, which a processor
         *  would not foresee. */
        __forceinline auto areCertain () const -> decltype(w0 < w1) {
          return ((Real(0.0f) < min(w0,min(w1,w2))) | (max(max(w0,w1),w2) < Real(0.0f))) & (abs(sum) < Real(float(pos_inf)));
        }

        /*! weights of the second and the third vertex; not numbers where all sides rounded to 0 */
        __forceinline Real b1 () const { return w1/sum; }
        __forceinline Real b2 () const { return w2/sum; }
      };

      /*! A triangle of a group. */
      struct VertTriangle : private TrianglePlane<float,double>
      {
        typedef PlaneNormal<double> Normal;
        using TrianglePlane<float,double>::normal;

        /*! h: a bit of GroupTriangles */
        __forceinline VertTriangle (const QuadCorners& quads, uint32_t h)
        {
          const uint32_t q = h >> 1, a = cornerOfTriangle(h,0), b = cornerOfTriangle(h,1), c = cornerOfTriangle(h,2);
          for (int k=0; k<3; k++) {
            vertices[k][0] = quads.at[a][k][q]; vertices[k][1] = quads.at[b][k][q]; vertices[k][2] = quads.at[c][k][q];
          }
        }

        typedef TriangleSides<float> Sides;

        __forceinline Sides sides (const VertRay& ray) const
        {
          const Sheared s(*this,ray);
          return Sides(s.x,s.y);
        }

        /*! in the quad, h as above */
        static __forceinline Vec2f position (const Sides& sides, uint32_t h)
        {
          const float b1 = sides.b1(), b2 = sides.b2(), u[2] = { b1,b1+b2 }, v[2] = { b2,1.0f-b1 }; // which of them is not foreseen
          return Vec2f(u[h & 1],v[h & 1]);
        }

        /*! Whether the sheared triangle has the ray in it. Sides that rounded to 0 count for both of
         *  their triangles, and slivers have no others: here their signs are exact, as products of
         *  floats are in double. A triangle that is a line there covers nothing that others do not. */
        __forceinline bool contains (const VertRay& ray) const
        {
          const Sheared s(*this,ray);
          double side[3];
          for (int i=0; i<3; i++) {
            const int a = (i+1)%3, b = (i+2)%3;
            side[i] = double(s.x[a])*double(s.y[b]) - double(s.y[a])*double(s.x[b]);
          }
          if (unlikely(!(std::fabs(side[0]+side[1]+side[2]) < double(inf)))) return false; // of a vertex that is not finite
          const double least = min(side[0],min(side[1],side[2])), greatest = max(side[0],max(side[1],side[2]));
          return least >= 0.0 ? greatest > 0.0 : greatest <= 0.0;
        }

        /*! Where a ray that goes through it meets its plane. A plane that
         *  the ray lies in, but for rounding, says nothing, nor does a line: the ray may be inside by
         *  the rounding of vertices alone, and if it were let through, it would leak. */
        __forceinline double meet (const VertRay& ray, const Normal& normal) const
        {
          const PlaneMeeting<double> at = TrianglePlane<float,double>::meet(normal,ray.org,ray.dir);
          return span(ray).clamp(likely(std::fabs(at.speed) > at.least) ? at.t : alongLongestEdge(ray));
        }

        /*! between which t `meet` is */
        __forceinline TriangleSpan<double> span (const VertRay& ray) const { return TrianglePlane<float,double>::span(ray.org,ray.dir,size_t(ray.kz)); }

        /*! where the ray is nearest to the longest edge */
        double alongLongestEdge (const VertRay& ray) const
        {
          double best = -1.0, t = 0.0;
          for (int i=0, j=1; i<3; i++, j=(i+1)%3)
          {
            double ee = 0, dd = 0, de = 0, dw = 0, ew = 0;
            for (int k=0; k<3; k++)
            {
              const double e = double(vertices[k][j]) - double(vertices[k][i]), w = double(vertices[k][i]) - double(ray.org[k]), d = double(ray.dir[k]);
              ee += e*e; dd += d*d; de += d*e; dw += d*w; ew += e*w;
            }
            if (ee <= best) continue;
            best = ee;
            const double det = dd*ee - de*de;
            const double s = det > 0 ? min(max((de*dw - dd*ew)/det,0.0),1.0) : 0.0; // along the edge
            t = (dw + s*de)/dd;
          }
          return t;
        }

        /*! of a line, whichever way the ray comes from */
        static __forceinline Vec3fa Ng (const VertRay& ray, const Normal& normal)
        {
          const float x = float(normal.at[0]), y = float(normal.at[1]), z = float(normal.at[2]);
          return likely(x != 0.0f || y != 0.0f || z != 0.0f) ? Vec3fa(x,y,z) : -Vec3fa(ray.dir[0],ray.dir[1],ray.dir[2]);
        }

      private:
        /*! its vertices, sheared as GroupTriangles does */
        struct Sheared
        {
          alignas(16) float x[4], y[4];

          __forceinline Sheared (const VertTriangle& t, const VertRay& ray)
          {
            auto relative = [&](int k) { return vfloat4(t.vertices[k][0],t.vertices[k][1],t.vertices[k][2],t.vertices[k][2]) - vfloat4(ray.org[k]); };
            const vfloat4 z = relative(ray.kz);
            vfloat4::store(x,nmadd(vfloat4(ray.sx),z,relative(ray.kx)));
            vfloat4::store(y,nmadd(vfloat4(ray.sy),z,relative(ray.ky)));
          }
        };
      };

      /*! The triangles of a group that a ray's line goes through. */
      class GroupTriangles
      {
      public:
        uint32_t mask; //!< bit 2q + 0 or 1 of quad q

        __forceinline GroupTriangles (const VertRay& ray, const QuadCorners& quads) : mask(0)
        {
          uint32_t firsts = 0, seconds = 0;
          for (int n=0; n<16; n+=vectorWidth)
          {
            vfloatV x[4], y[4];
            for (int c=0; c<4; c++) {
              const float (*at)[16] = quads.at[c];
              const vfloatV z = vfloatV::load(at[ray.kz]+n) - vfloatV(ray.org[ray.kz]);
              x[c] = nmadd(vfloatV(ray.sx),z,vfloatV::load(at[ray.kx]+n) - vfloatV(ray.org[ray.kx]));
              y[c] = nmadd(vfloatV(ray.sy),z,vfloatV::load(at[ray.ky]+n) - vfloatV(ray.org[ray.ky]));
            }
            const vfloatV diag   = edgeSide(x[1],y[1],x[2],y[2]);
            const vfloatV left   = edgeSide(x[2],y[2],x[0],y[0]);
            const vfloatV bottom = edgeSide(x[0],y[0],x[1],y[1]);
            const vfloatV right  = edgeSide(x[1],y[1],x[3],y[3]);
            const vfloatV top    = edgeSide(x[3],y[3],x[2],y[2]);
            const vboolV first = isInside(diag,left,bottom), second = isInside(right,top,-diag);
            firsts |= uint32_t(movemask(first)) << n;
            seconds |= uint32_t(movemask(second)) << n;
          }
          if (firsts | seconds) mask = spread(firsts) | (spread(seconds) << 1);
        }

      private:
        /*! bits of quads to every second bit */
        static __forceinline uint32_t spread (uint32_t x)
        {
          x = (x | (x << 8)) & 0x00FF00FFu;
          x = (x | (x << 4)) & 0x0F0F0F0Fu;
          x = (x | (x << 2)) & 0x33333333u;
          return (x | (x << 1)) & 0x55555555u;
        }
      };

      /*! The same of the rays of a packet that have their largest component on the same axis. Vertices, and the edges between
       *  quads, are looked at once; an edge seen from the other side is the exact negative. */
      template<int K>
      class GroupTrianglesK
      {
        const vfloat<K> orgX, orgY, orgZ, sx, sy;
        const size_t kx, ky, kz;
        const QuadCorners& quads;

      public:
        vint<K> mask; //!< of each ray

        __forceinline GroupTrianglesK (const VertRays<K>& rays, size_t kz, const QuadCorners& quads)
          : GroupTrianglesK(rays,size_t(axisAfter(int(kz),1)),size_t(axisAfter(int(kz),2)),kz,quads) {}

      private:
        struct Point { vfloat<K> x, y; };

        GroupTrianglesK (const VertRays<K>& rays, size_t kx, size_t ky, size_t kz, const QuadCorners& quads)
          : orgX(rays.org[kx]), orgY(rays.org[ky]), orgZ(rays.org[kz]), sx(rays.sx), sy(rays.sy), kx(kx), ky(ky), kz(kz), quads(quads), mask(zero)
        {
          Point below[5];
          vfloat<K> bottom[4];
          for (size_t i=0; i<5; i++) below[i] = i < 4 ? corner(0,i) : corner(1,3);
          for (size_t i=0; i<4; i++) bottom[i] = side(below[i],below[i+1]);
          for (size_t q=0; q<16; q+=4)
          {
            Point left = corner(2,q);
            vfloat<K> leftSide = side(left,below[0]);
            for (size_t i=0; i<4; i++)
            {
              const Point right = corner(3,q+i);
              const vfloat<K> diag = side(below[i+1],left), rightSide = side(below[i+1],right), top = side(right,left);
              const vbool<K> first = isInside(diag,leftSide,bottom[i]), second = isInside(rightSide,top,-diag);
              if (unlikely(any(first | second)))
                mask |= select(first,vint<K>(int(1u << (2*(q+i)))),vint<K>(zero)) | select(second,vint<K>(int(2u << (2*(q+i)))),vint<K>(zero));
              bottom[i] = -top;
              leftSide = -rightSide;
              below[i] = left;
              left = right;
            }
            below[4] = left;
          }
        }

        static __forceinline vfloat<K> side (const Point& a, const Point& b) { return edgeSide(a.x,a.y,b.x,b.y); }

        /*! corner c of a quad, sheared as above */
        __forceinline Point corner (size_t c, size_t quad) const
        {
          const float (*at)[16] = quads.at[c];
          const vfloat<K> z = vfloat<K>(at[kz][quad]) - orgZ;
          return Point{ nmadd(sx,z,vfloat<K>(at[kx][quad]) - orgX), nmadd(sy,z,vfloat<K>(at[ky][quad]) - orgY) };
        }
      };
    }
  }
}
