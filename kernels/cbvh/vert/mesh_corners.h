// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Corners of a group's triangles, sheared for a ray. */

#include "mesh_cache.h"
#include "ray.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Returns the lanes of the triangles that the ray's line passes through, or may pass through. */
      __forceinline uint32_t trianglesHitByLine (const VertRay& ray, const MeshTriangles& triangles)
      {
        const vfloatV orgX(ray.org[ray.kx]), orgY(ray.org[ray.ky]), orgZ(ray.org[ray.kz]), sx(ray.sx), sy(ray.sy);
        uint32_t mask = 0;
        for (uint32_t n=0; n<MeshTriangles::width; n+=vectorWidth)
        {
          vfloatV x[3], y[3];
          for (int c=0; c<3; c++) {
            const vfloatV z = vfloatV::load(triangles.at[ray.kz][c]+n) - orgZ;
            x[c] = nmadd(sx,z,vfloatV::load(triangles.at[ray.kx][c]+n) - orgX);
            y[c] = nmadd(sy,z,vfloatV::load(triangles.at[ray.ky][c]+n) - orgY);
          }
          const vboolV inside = isInside(edgeSide(x[1],y[1],x[2],y[2]),edgeSide(x[2],y[2],x[0],y[0]),
            edgeSide(x[0],y[0],x[1],y[1]));
          mask |= uint32_t(movemask(inside)) << n;
        }
        return mask & triangles.lanes;
      }
    }
  }
}
