// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The plane of a triangle of cVERT in double, where differences of its vertices are exact: weights of a needle are off
 * by more than its plane is. Numbers are float and double, of one ray, or four of them, of rays of a packet; no
 * product is fused, so both give the same bits. */

#include "../base/product.h"
#include "../base/lanes.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /* what Float4 and Double4 have */
      __forceinline double toDouble (float x) { return double(x); }
      __forceinline Double4 toDouble (const Float4& x) { return Double4(x); }
      __forceinline double magnitudeOf (double x) { return std::fabs(x); }
      __forceinline Double4 magnitudeOf (const Double4& x) { return abs(x); }

      __forceinline Double4 product (const Double4& a, const Double4& b)
      {
        Double4 p = a*b;
#if defined(__GNUC__) && defined(__AVX__)
        asm("" : "+x"(p.v));
#endif
        return p;
      }

      /*! t of a triangle: a ray meets it between these, whatever its plane says */
      template<typename Double>
      struct TriangleSpan
      {
        Double nearest, farthest;

        __forceinline Double clamp (const Double& t) const { return min(max(t,nearest),farthest); }
      };

      /*! where a ray meets a plane */
      template<typename Double>
      struct PlaneMeeting
      {
        Double t;            //!< not a number where the ray lies in the plane
        Double speed, least; //!< a ray that comes nearer to the plane no faster than `least` lies in it
      };

      template<typename Double>
      struct PlaneNormal { Double at[3]; }; //!< 0 of a line

      template<typename Float, typename Double>
      struct TrianglePlane
      {
        /*! below this the ray lies in the plane, as far as vertices of 24 bits can tell */
        static constexpr double minCosine = 1e-6;

        Float vertices[3][3];  //!< by axis

        __forceinline PlaneNormal<Double> normal () const
        {
          Double e[3], f[3];
          for (int k=0; k<3; k++) {
            e[k] = toDouble(vertices[k][1]) - toDouble(vertices[k][0]);
            f[k] = toDouble(vertices[k][2]) - toDouble(vertices[k][0]);
          }
          return PlaneNormal<Double>{ { product(e[1],f[2]) - product(e[2],f[1]),product(e[2],f[0]) - product(e[0],f[2]),product(e[0],f[1]) - product(e[1],f[0]) } };
        }

        __forceinline PlaneMeeting<Double> meet (const PlaneNormal<Double>& normal, const Float org[3], const Float dir[3]) const
        {
          Double height(0.0), speed(0.0), size(0.0);
          for (int k=0; k<3; k++) {
            const Double along = product(normal.at[k],toDouble(dir[k]));
            speed = speed + along;
            size = size + magnitudeOf(along);
            height = height + product(normal.at[k],toDouble(vertices[k][0]) - toDouble(org[k]));
          }
          return PlaneMeeting<Double>{ height/speed,speed,Double(minCosine)*size };
        }

        /*! Of the vertices along the ray: division is monotonic, so of the lowest and the highest. kz: axis of the largest component of
         *  the direction. Least and greatest of the same two in the same order would become a branch, which a processor would not
         *  foresee. */
        __forceinline TriangleSpan<Double> span (const Float org[3], const Float dir[3], size_t kz) const
        {
          const Double start = toDouble(org[kz]), along = toDouble(dir[kz]);
          const Double z0 = toDouble(vertices[kz][0]) - start, z1 = toDouble(vertices[kz][1]) - start, z2 = toDouble(vertices[kz][2]) - start;
          const Double a = min(z0,min(z1,z2))/along, b = max(max(z0,z1),z2)/along;
          return TriangleSpan<Double>{ min(a,b),max(b,a) };
        }
      };
    }
  }
}
