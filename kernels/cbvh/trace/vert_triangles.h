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

#include "vert_group.h"
#include "vert_ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Triangles of a group that a ray's line goes through: bit 2q + 0 or 1 of quad q. Where on
       *  the ray they are is known roughly, see VertTriangle. */
      struct GroupHits
      {
        uint32_t mask;
        uint32_t certain;  //!< those whose sides did not round to 0
        alignas(64) float u[2][16], v[2][16]; //!< [triangle][quad]: position in the quad
      };

      /*! A triangle of a group in double, where differences of its vertices are exact: weights of a
       *  needle are off by more than its plane is. */
      struct VertTriangle
      {
        /*! below this the ray lies in the plane, as far as vertices of 24 bits can tell */
        static constexpr double minCosine = 1e-6;

        double normal[3];      //!< 0 of a line
        float vertices[3][3];  //!< by axis

        /*! h: a bit of GroupHits */
        __forceinline VertTriangle (const CellVertices& cell, uint32_t h)
        {
          const uint32_t v = 5*(h >> 3) + ((h >> 1) & 3), a = h & 1 ? v+5 : v, b = v+1, c = h & 1 ? v+6 : v+5;
          double e[3], f[3];
          for (int k=0; k<3; k++) {
            vertices[k][0] = cell.at[k][a]; vertices[k][1] = cell.at[k][b]; vertices[k][2] = cell.at[k][c];
            e[k] = double(vertices[k][1]) - double(vertices[k][0]);
            f[k] = double(vertices[k][2]) - double(vertices[k][0]);
          }
          normal[0] = e[1]*f[2] - e[2]*f[1];
          normal[1] = e[2]*f[0] - e[0]*f[2];
          normal[2] = e[0]*f[1] - e[1]*f[0];
        }

        /*! Whether the sheared triangle has the ray in it. Sides that rounded to 0 count for both of
         *  their triangles, and slivers have no others: here their signs are exact, as products of
         *  floats are in double. A triangle that is a line there covers nothing that others do not. */
        __forceinline bool contains (const VertRay& ray) const
        {
          auto relative = [&](int k) { return vfloat4(vertices[k][0],vertices[k][1],vertices[k][2],vertices[k][2]) - vfloat4(ray.org[k]); };
          const vfloat4 z = relative(ray.kz);
          const vfloat4 x = nmadd(vfloat4(ray.sx),z,relative(ray.kx)), y = nmadd(vfloat4(ray.sy),z,relative(ray.ky));
          double side[3];
          for (int i=0; i<3; i++) {
            const int a = (i+1)%3, b = (i+2)%3;
            side[i] = double(x[a])*double(y[b]) - double(y[a])*double(x[b]);
          }
          if (unlikely(!(std::fabs(side[0]+side[1]+side[2]) < double(inf)))) return false; // of a vertex that is not finite
          const double least = min(side[0],min(side[1],side[2])), greatest = max(side[0],max(side[1],side[2]));
          return least >= 0.0 ? greatest > 0.0 : greatest <= 0.0;
        }

        /*! Where a ray that goes through it meets its plane; false beyond tnear and tfar. A plane that
         *  the ray lies in, but for rounding, says nothing, nor does a line: the ray may be inside by
         *  the rounding of vertices alone, and if it were let through, it would leak. */
        __forceinline bool meet (const Ray& ray, int kz, float& t) const
        {
          double height = 0, speed = 0, size = 0;
          for (int k=0; k<3; k++) {
            size += std::fabs(normal[k]*double(ray.dir[k]));
            height += normal[k]*(double(vertices[k][0]) - double(ray.org[k]));
            speed += normal[k]*double(ray.dir[k]);
          }
          double z[3];
          for (int i=0; i<3; i++) z[i] = (double(vertices[kz][i]) - double(ray.org[kz]))/double(ray.dir[kz]);
          const double nearest = min(z[0],min(z[1],z[2])), farthest = max(z[0],max(z[1],z[2]));
          double exact = height/speed;
          if (unlikely(!(std::fabs(speed) > minCosine*size))) exact = alongLongestEdge(ray);
          exact = min(max(exact,nearest),farthest);
          t = float(exact);
          return exact >= double(ray.tnear()) && exact <= double(ray.tfar);
        }

        /*! where the ray is nearest to the longest edge */
        double alongLongestEdge (const Ray& ray) const
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
        __forceinline Vec3fa Ng (const Ray& ray) const
        {
          const float x = float(normal[0]), y = float(normal[1]), z = float(normal[2]);
          return likely(x != 0.0f || y != 0.0f || z != 0.0f) ? Vec3fa(x,y,z) : -Vec3fa(ray.dir);
        }
      };

      /*! side of the ray on which an edge lies */
      __forceinline vfloatV edgeSide (const vfloatV& ax, const vfloatV& ay, const vfloatV& bx, const vfloatV& by) {
        return product(ax,by) - product(ay,bx);
      }

      class GroupTriangles
      {
      public:
        __forceinline GroupTriangles (const VertRay& ray, float tnear) : ray(ray), tnear(tnear) {}

        /*! false if no triangle is met up to tfar */
        __forceinline bool intersect (const CellVertices& vertices, float tfar, GroupHits& hits) const
        {
          CellVertices sheared;
          for (int c=0; c<cellVectors; c++)
          {
            const int n = vertWidth*c;
            const vfloatV x = vfloatV::load(vertices.at[ray.kx]+n) - vfloatV(ray.org[ray.kx]);
            const vfloatV y = vfloatV::load(vertices.at[ray.ky]+n) - vfloatV(ray.org[ray.ky]);
            const vfloatV z = vfloatV::load(vertices.at[ray.kz]+n) - vfloatV(ray.org[ray.kz]);
            vfloatV::store(sheared.at[0]+n,nmadd(vfloatV(ray.sx),z,x));
            vfloatV::store(sheared.at[1]+n,nmadd(vfloatV(ray.sy),z,y));
            vfloatV::store(sheared.at[2]+n,vfloatV(ray.sz)*z);
          }
          const CellCornersV X(sheared.at[0]), Y(sheared.at[1]), Z(sheared.at[2]);
          hits.mask = hits.certain = 0;
          for (int j=0; j<CellCornersV::vectors; j++)
          {
            const vfloatV* x = X.at[j];
            const vfloatV* y = Y.at[j];
            const vfloatV* z = Z.at[j];
            const vfloatV diag   = edgeSide(x[1],y[1],x[2],y[2]);
            const vfloatV left   = edgeSide(x[2],y[2],x[0],y[0]);
            const vfloatV bottom = edgeSide(x[0],y[0],x[1],y[1]);
            const vfloatV right  = edgeSide(x[1],y[1],x[3],y[3]);
            const vfloatV top    = edgeSide(x[3],y[3],x[2],y[2]);
            const vboolV first = isInside(diag,left,bottom), second = isInside(right,top,-diag);
            if (likely(none(first | second))) continue;
            /* weights: of 00, 10, 01; of 01, 10, 11 */
            hits.mask |= finish(0,j,first ,diag ,left,bottom,z[0],z[1],z[2],tfar,hits);
            hits.mask |= finish(1,j,second,right,top ,-diag ,z[2],z[1],z[3],tfar,hits);
          }
          return hits.mask != 0;
        }

      private:
        /*! of numbers */
        static __forceinline vboolV isWithin (const vfloatV& a, const vfloatV& b, const vfloatV& c) {
          return (vfloatV(zero) < min(a,min(b,c))) | (max(a,max(b,c)) < vfloatV(zero));
        }

        static __forceinline vboolV isInside (const vfloatV& a, const vfloatV& b, const vfloatV& c) {
          return (min(a,min(b,c)) >= vfloatV(zero)) | (max(a,max(b,c)) <= vfloatV(zero));
        }

        /*! Positions; returns bits of hits. What is not a number, where all sides rounded to 0, is left
         *  to VertTriangle. */
        __forceinline uint32_t finish (int triangle, int j, const vboolV& inside, const vfloatV& w0, const vfloatV& w1, const vfloatV& w2,
                                       const vfloatV& z0, const vfloatV& z1, const vfloatV& z2, float tfar, GroupHits& hits) const
        {
          const vfloatV sum = w0 + w1 + w2;
          const vfloatV b1 = w1/sum, b2 = w2/sum;
          const vfloatV t = madd(b1,z1-z0,madd(b2,z2-z0,z0));
          const vfloatV doubt = abs(t)*vfloatV(1.0f/256.0f);
          /* by "less" alone, which is false of what is not a number: Embree's "greater" is true of it */
          const size_t mask = movemask(andn(inside,(t+doubt < vfloatV(tnear)) | (vfloatV(tfar) < t-doubt)));
          if (mask == 0) return 0;
          const int n = vertWidth*j;
          vfloatV::store(hits.u[triangle]+n,triangle ? b1+b2 : b1);
          vfloatV::store(hits.v[triangle]+n,triangle ? vfloatV(1.0f)-b1 : b2);
          hits.certain |= spread(uint32_t(movemask(isWithin(w0,w1,w2) & (abs(sum) < vfloatV(inf)))) << n) << triangle;
          return spread(uint32_t(mask) << n) << triangle;
        }

        /*! bits of quads to every second bit */
        static __forceinline uint32_t spread (uint32_t x)
        {
          x = (x | (x << 8)) & 0x00FF00FFu;
          x = (x | (x << 4)) & 0x0F0F0F0Fu;
          x = (x | (x << 2)) & 0x33333333u;
          return (x | (x << 1)) & 0x55555555u;
        }

        const VertRay& ray;
        float tnear;
      };
    }
  }
}
