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
        alignas(64) float u[2][16], v[2][16]; //!< [triangle][quad]: position in the quad
      };

      /*! A triangle of a group in double, where differences and products of its vertices are
       *  exact: weights of a needle are off by more than its plane is. */
      struct VertTriangle
      {
        double normal[3];
        float corner[3];

        /*! h: a bit of GroupHits */
        __forceinline VertTriangle (const CellVertices& vertices, uint32_t h)
        {
          const uint32_t v = 5*(h >> 3) + ((h >> 1) & 3), a = h & 1 ? v+5 : v, b = v+1, c = h & 1 ? v+6 : v+5;
          double e[3], f[3];
          for (int k=0; k<3; k++) {
            corner[k] = vertices.at[k][a];
            e[k] = double(vertices.at[k][b]) - double(corner[k]);
            f[k] = double(vertices.at[k][c]) - double(corner[k]);
          }
          normal[0] = e[1]*f[2] - e[2]*f[1];
          normal[1] = e[2]*f[0] - e[0]*f[2];
          normal[2] = e[0]*f[1] - e[1]*f[0];
        }

        /*! where the ray meets its plane; false beyond tnear and tfar, and for a triangle without
         *  an area */
        __forceinline bool meet (const Ray& ray, float& t) const
        {
          double height = 0, speed = 0;
          for (int k=0; k<3; k++) {
            height += normal[k]*(double(corner[k]) - double(ray.org[k]));
            speed += normal[k]*double(ray.dir[k]);
          }
          const double exact = height/speed;
          t = float(exact);
          return exact >= double(ray.tnear()) && exact <= double(ray.tfar); // not for 0/0
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
          hits.mask = 0;
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
        static __forceinline vboolV isInside (const vfloatV& a, const vfloatV& b, const vfloatV& c) {
          return (min(a,min(b,c)) >= vfloatV(zero)) | (max(a,max(b,c)) <= vfloatV(zero));
        }

        /*! Positions; returns bits of hits. Triangles without an area have a sum of 0. */
        __forceinline uint32_t finish (int triangle, int j, const vboolV& inside, const vfloatV& w0, const vfloatV& w1, const vfloatV& w2,
                                       const vfloatV& z0, const vfloatV& z1, const vfloatV& z2, float tfar, GroupHits& hits) const
        {
          const vfloatV sum = w0 + w1 + w2;
          const vfloatV b1 = w1/sum, b2 = w2/sum;
          const vfloatV t = madd(b1,z1-z0,madd(b2,z2-z0,z0));
          const vfloatV doubt = abs(t)*vfloatV(1.0f/256.0f);
          const size_t mask = movemask(inside & (sum != vfloatV(zero)) & (t+doubt >= vfloatV(tnear)) & (t-doubt <= vfloatV(tfar)));
          if (mask == 0) return 0;
          const int n = vertWidth*j;
          vfloatV::store(hits.u[triangle]+n,triangle ? b1+b2 : b1);
          vfloatV::store(hits.v[triangle]+n,triangle ? vfloatV(1.0f)-b1 : b2);
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
