// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a ray needs for blocks of cVERT: the shear that takes it to the z axis, for triangles,
 * and its reciprocal direction, for boxes.
 *
 * Triangles are tested in the sheared space, where the ray is the origin of the x-y plane: it
 * goes through a triangle if the origin is on the same side of all three edges. A side is
 * the sign of ax by - ay bx, which for an edge seen from its other triangle is the exact
 * negative, as products of floats commute. Rounding is monotonic, so that sign may be lost,
 * to 0, but is never the wrong one; 0 counts for both triangles, and is told exactly for the few
 * that are left (VertTriangle::contains). A vertex is sheared to the
 * same numbers wherever it is used. So every origin that the sheared surface covers is in
 * one of its triangles: no ray slips through an edge or past a vertex.
 *
 * Based on: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. */

#include "product.h"
#include "../../common/ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      struct VertRay
      {
        bool isSet;
        int kx, ky, kz;        //!< axes; kz that of the largest component
        float sx, sy, sz;      //!< shear
        float org[3], dir[3], rcp[3];

        __forceinline VertRay () : isSet(false) {}

        __forceinline void set (const Ray& ray)
        {
          if (likely(isSet)) return;
          isSet = true;
          const Vec3fa dir = ray.dir;
          const Vec3fa a = abs(dir);
          kz = a.x >= a.y ? (a.x >= a.z ? 0 : 2) : (a.y >= a.z ? 1 : 2);
          kx = kz == 2 ? 0 : kz+1;
          ky = kx == 2 ? 0 : kx+1;
          sz = 1.0f/dir[kz];
          sx = dir[kx]*sz;
          sy = dir[ky]*sz;
          for (int k=0; k<3; k++) {
            org[k] = ray.org[k];
            this->dir[k] = dir[k];
            rcp[k] = reciprocal(dir[k],dir[kz]);
          }
        }

        /*! of a component of the direction, whose largest is given; finite */
        static __forceinline float reciprocal (float d, float largest)
        {
          const float least = 1e-18f*std::fabs(largest);
          return 1.0f/(std::fabs(d) < least ? std::copysign(least,d) : d);
        }
      };
    }
  }
}
