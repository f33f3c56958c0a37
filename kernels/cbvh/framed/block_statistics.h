// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Statistics of one or more blocks, which encoders of all kinds collect. */

#include "leaf/leaf_fit.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    struct BlockStatistics
    {
      uint32_t invalidQuads = 0;
      uint32_t solidLeaves = 0;
      bool affine = false;         //!< of the last block's frame
      float maxThickness = 0;      //!< largest thickness, in world space
      LeafFit leafFit;

      /*! Adds a leaf, and returns its thickness in world space: the distance between the plane z = slope (x,y) through
       *  the middle of a box and the same plane moved up by `thickness`. The length of the plane's world-space normal
       *  (normal.h), divided by W, is the distance in the frame per world-space unit. */
      float addThickness(const BlockGeometry& geometry, const NodeBox& box, const double slope[2], double thickness)
      {
        const double c[3] =
          { box.lower[0]+0.5*box.extent[0], box.lower[1]+0.5*box.extent[1], box.lower[2]+0.5*box.extent[2] };
        const double k = c[2] - slope[0]*c[0] - slope[1]*c[1];
        double n2 = 0;
        for (int i=0; i<3; i++) {
          const float* col = geometry.frame.columns[i];
          const double n = -slope[0]*col[0] - slope[1]*col[1] + col[2] - k*col[3];
          n2 += n*n;
        }
        const float t = float(thickness/(geometry.inverse.rcpW({ c[0],c[1],c[2] })*std::sqrt(n2)));
        if (t > maxThickness) maxThickness = t;
        return t;
      }

      /*! Adds a leaf whose box is its surface. */
      void addBoxThickness(const BlockGeometry& geometry, const NodeBox& box)
      {
        const double flat[2] = { 0,0 };
        addThickness(geometry,box,flat,box.extent[2]);
      }
    };
  }}
}
