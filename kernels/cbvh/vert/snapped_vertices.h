// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a patch before and after they were snapped to a lattice, four at a time: how far they
 * moved, and which triangles that turned over. */

#include "../surface/lattice.h"
#include <limits>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    /*! four vertices that follow each other */
    struct Vertices4
    {
      Float4 x, y, z;

      Vertices4(Float4 x, Float4 y, Float4 z) : x(x), y(y), z(z) {}

      explicit Vertices4(const float (*p)[3]) : Vertices4(Float4::load(&p[0][0]),Float4::load(&p[0][0]+4),Float4::load(&p[0][0]+8),true) {}

      /*! of x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3 */
      Vertices4(Float4 a, Float4 b, Float4 c, bool)
      {
        const __m128 yz = _mm_shuffle_ps(a.v,b.v,_MM_SHUFFLE(1,0,2,1)), xy = _mm_shuffle_ps(b.v,c.v,_MM_SHUFFLE(2,1,3,2)); // of the first two, of the others
        x = _mm_shuffle_ps(a.v,xy,_MM_SHUFFLE(2,0,3,0));
        y = _mm_shuffle_ps(yz,xy,_MM_SHUFFLE(3,1,2,0));
        z = _mm_shuffle_ps(yz,c.v,_MM_SHUFFLE(3,0,3,1));
      }

      friend Vertices4 operator-(const Vertices4& a, const Vertices4& b) { return Vertices4(a.x-b.x,a.y-b.y,a.z-b.z); }
      friend Vertices4 cross(const Vertices4& a, const Vertices4& b) {
        return Vertices4(a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x);
      }
      friend Float4 dot(const Vertices4& a, const Vertices4& b) { return a.x*b.x + a.y*b.y + a.z*b.z; }
    };

    /*! Snaps four vertices; returns the largest square of how far one moved, of those that are finite. */
    inline float snapFour(const WorldLattice& lattice, const float (*own)[3], float (*stored)[3])
    {
      Float4 square[3];
      for (int i=0; i<3; i++)
      {
        const Float4 p = Float4::load(&own[0][0]+4*i), q = lattice.snap(p), d = p-q;
        q.store(&stored[0][0]+4*i);
        square[i] = d*d;
      }
      const Vertices4 s(square[0],square[1],square[2],true);
      const Float4 distance2 = s.x+s.y+s.z;
      return greatest(below(distance2,std::numeric_limits<float>::max()) & distance2);
    }

    /*! Of four quads beside each other, with triangles (00,10,01) and (10,11,01): how many have one that is
     *  turned by more than 90 degrees. width: distance of the rows, in vertices. */
    inline uint32_t countFlippedOfFour(const float (*own)[3], const float (*stored)[3], size_t width)
    {
      struct Normals
      {
        Vertices4 lower, upper;

        Normals(const float (*p)[3], size_t width) : Normals(Vertices4(p),Vertices4(p+1),Vertices4(p+width),Vertices4(p+width+1)) {}
        Normals(const Vertices4& a, const Vertices4& b, const Vertices4& c, const Vertices4& d)
          : lower(cross(b-a,c-a)), upper(cross(d-b,c-b)) {}
      };
      const Normals n(own,width), m(stored,width);
      const uint32_t flipped = lanesBelow(dot(n.lower,m.lower),0.0f) | lanesBelow(dot(n.upper,m.upper),0.0f);
      return uint32_t(uint64_t(0x4332322132212110u) >> (4*flipped)) & 15u; // its bits, counted
    }
  }}
}
