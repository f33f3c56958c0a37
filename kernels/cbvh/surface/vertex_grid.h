// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The vertices of a patch, or of a part of it, row by row, before and after displacement: what a source of
 * surfaces fills and what writers of blocks read.
 *
 * An edge whose rate is lower than the patch's has the vertices of that rate, whatever
 * the face behind it has: where Embree stitches, it evaluates a border at the
 * parameters of the lower rate and gives each of its vertices to several of the grid,
 * the quads between which collapse. Blocks with frames keep only the nearest one of these, and
 * spread the others over the straight line to the next:
 *
 *     x---x---x---x---x---x      x: vertices of the grid
 *     |   |   |   |   |   |      o: those of an edge of rate 2 among them
 *     o---x---x-o-x---x---o
 *
 * The border is the same polyline but for a lip of 2^-20, no quad collapses or leans over
 * to another block, and parameters are those of the regular grid but for half a quad
 * along the border. */

#include "../base/codec.h"
#include "../../cvert/basics/vertices4.h"
#include "../embree/scene.h"
#include <cmath>

namespace embree
{
  namespace isa
  {
    /*! vertices x0 to x1 along u and y0 to y1 along v of a patch */
    struct PatchPart { unsigned x0, x1, y0, y1; };

    /*! first vertex of `fine` quads that Embree's stitch() gives to vertex k of an edge of a lower rate, which is the nearest to it */
    inline unsigned firstStitched (unsigned k, unsigned fine, unsigned coarse) { return (2*k*fine + coarse-1)/(2*coarse); }

    class VertexGrid
    {
    public:
      explicit VertexGrid (Device* device) : interleaved(device,0) {}

      /*! Spreads vertices of lower edges, which are stitched: of those rates, not above the patch's own. */
      void spreadBorders (const float rate[4], float (*p)[3]) const
      {
        const unsigned quadsX = unsigned(width)-1, quadsY = unsigned(height)-1;
        const ssize_t row = ssize_t(width);
        spreadBorder(p,1,row,quadsX,unsigned(rate[0]));
        spreadBorder(p+quadsX,row,-1,quadsY,unsigned(rate[1]));
        spreadBorder(p+quadsY*row,1,-row,quadsX,unsigned(rate[2]));
        spreadBorder(p,row,1,quadsY,unsigned(rate[3]));
      }

      /*! displaced vertices of quadsX x quadsY quads that were evaluated before; undisplaced ones are not known then */
      void set (unsigned quadsX, unsigned quadsY, const float (*vertices)[3])
      {
        width = quadsX+1; height = quadsY+1;
        resize();
        memcpy(displaced(),vertices,count*sizeof(*vertices));
      }

      /*! a part of which nothing is known */
      void setInvalid (const PatchPart& part)
      {
        width = part.x1-part.x0+1; height = part.y1-part.y0+1;
        resize();
        std::fill(interleaved.begin(),interleaved.end(),std::numeric_limits<float>::quiet_NaN());
      }

      /*! vertices row by row */
      float (*undisplaced ())[3] { return (float(*)[3])interleaved.data(); }
      float (*displaced ())[3] { return (float(*)[3])(interleaved.data() + 3*count); }

      /*! bounds of the displaced vertices; false if one is not finite */
      bool bound (float lower[3], float upper[3]) { return cbvh::boundVertices(displaced(),count,lower,upper); }

      size_t width = 0, height = 0; //!< in vertices

    protected:
      /*! makes room for width x height vertices */
      void resize ()
      {
        count = width*height;
        interleaved.reserve(6*count); // no more than that: vectors grow to a power of two
        interleaved.resize(6*count);
      }

      size_t count = 0;

    private:
      /*! border: fine+1 vertices, along apart, stitched to the vertices of a lower rate;
       *  inward: to the next row of the grid */
      static void spreadBorder (float (*border)[3], ssize_t along, ssize_t inward, unsigned fine, unsigned coarse)
      {
        if (fine == coarse) return;
        for (unsigned k=0; k<coarse; k++)
        {
          const ssize_t begin = firstStitched(k,fine,coarse), end = firstStitched(k+1,fine,coarse);
          const cbvh::Double3 a = load(border[begin*along]), b = load(border[end*along]);
          for (ssize_t i=begin+1; i<end; i++) {
            const cbvh::Double3 p = a + (double(i-begin)/double(end-begin))*(b-a);
            store(overlap(p,load(border[i*along+inward])),border[i*along]);
          }
        }
      }

      /*! Moves a point of a border outward by what rounding may leave open beside a
       *  neighbour that has no vertex there: its own and that of the tests of triangles. */
      static cbvh::Double3 overlap (const cbvh::Double3& p, const cbvh::Double3& inner)
      {
        const cbvh::Double3 outward = p - inner;
        const double distance = cbvh::length(outward);
        const double size = cbvh::maximum(std::fabs(p.x),cbvh::maximum(std::fabs(p.y),std::fabs(p.z)));
        const double lip = cbvh::minimum(size/(1 << 20),distance/16);
        return distance > 0 ? p + (lip/distance)*outward : p; // not where it is NaN
      }

      static cbvh::Double3 load (const float p[3]) { return { p[0],p[1],p[2] }; }
      static void store (const cbvh::Double3& p, float out[3]) { out[0] = float(p.x); out[1] = float(p.y); out[2] = float(p.z); }

      mvector<float> interleaved; //!< undisplaced and displaced vertices
    };
  }
}
