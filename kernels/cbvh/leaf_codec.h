// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF: 16 bits a quad, four 4-bit heights at the corners of the
 * leaf's box. A height is the lower end of an interval of one bin; the bilinear
 * patches through the lower and upper ends bound the quad.
 *
 *   z  +-----------+   Bins divide a range that is zScale times as high as the
 *      |   ____..--|   box and centred on it, as a patch that is extrapolated
 *      |.-'' ____..|   from the quad's vertices to the box's corners may leave
 *      | _.-''     |   the box. Hits count only inside the box.
 *      +-----------+ x
 *
 * Two codes are taken out: a solid leaf, whose whole box is the surface, for
 * quads that no four heights bound, and an empty one, for quads with a vertex
 * that is not finite.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing
 * Subdivision Surfaces with Displacement", 2018, section 4.1. */

#include "node_codec.h"
#include <cmath>
#include <utility>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    static constexpr uint16_t solidLeaf = 0xFFFF;
    static constexpr uint16_t emptyLeaf = 0xFFFE;
    static constexpr int heightBins = 16;

    /*! z scale of a block: the range of a leaf's bins is 1 to 3 boxes high */
    static constexpr uint32_t zScaleCodes = 16;
    inline float decodeZScale(uint32_t code) { return 1.0f + float(code)*(2.0f/15.0f); }

    /*! corner = column + 2 row, as for children */
    inline int leafHeight(uint16_t leaf, int corner) { return (leaf >> (4*corner)) & 15; }

    inline float bilinear(const float c[4], float u, float v) {
      return c[0] + u*(c[1]-c[0]) + v*(c[2]-c[0]) + u*v*(c[0]-c[1]-c[2]+c[3]);
    }

    /*! a leaf's bins in z */
    struct LeafBins
    {
      float base; //!< lower end of bin 0
      float size; //!< height of a bin

      LeafBins(const NodeBox& box, float zScale)
        : base(box.lower[2] - 0.5f*(zScale-1.0f)*box.extent[2]), size(zScale*box.extent[2]*(1.0f/heightBins)) {}
    };

    /*! heights of a quad at the corners of its leaf's box */
    struct CornerHeights
    {
      double z[4];
      double u[4], v[4]; //!< position of the quad's vertices in the box, 0 to 1
      bool valid;
    };

    /*! Extrapolates a quad to the corners of its box: the bilinear patch through
     *  the four vertices, or the plane nearest to them where they do not determine
     *  one (a quad that is seen from the side in its frame).
     *  quad: vertices in the frame, corner order. */
    inline CornerHeights extrapolateQuad(const NodeBox& box, const double quad[4][3])
    {
      CornerHeights h;
      double m[4][5];
      for (int i=0; i<4; i++)
      {
        h.u[i] = (quad[i][0]-box.lower[0])/box.extent[0];
        h.v[i] = (quad[i][1]-box.lower[1])/box.extent[1];
        m[i][0] = (1-h.u[i])*(1-h.v[i]);
        m[i][1] = h.u[i]*(1-h.v[i]);
        m[i][2] = (1-h.u[i])*h.v[i];
        m[i][3] = h.u[i]*h.v[i];
        m[i][4] = quad[i][2];
      }

      /* Gauss-Jordan elimination with partial pivoting */
      h.valid = true;
      for (int c=0; c<4 && h.valid; c++)
      {
        int p = c;
        for (int r=c+1; r<4; r++)
          if (std::fabs(m[r][c]) > std::fabs(m[p][c])) p = r;
        if (std::fabs(m[p][c]) < 1e-3) { h.valid = false; break; }
        for (int k=0; k<5; k++) std::swap(m[c][k],m[p][k]);
        for (int r=0; r<4; r++) {
          if (r == c) continue;
          const double f = m[r][c]/m[c][c];
          for (int k=c; k<5; k++) m[r][k] -= f*m[c][k];
        }
      }
      for (int i=0; i<4 && h.valid; i++)
        h.z[i] = m[i][4]/m[i][i];
      if (h.valid) return h;

      /* plane: normal equations around the mean, damped so that a direction
       * without extent gets no slope */
      double mu = 0, mv = 0, mz = 0, suu = 1e-9, suv = 0, svv = 1e-9, suz = 0, svz = 0;
      for (int i=0; i<4; i++) { mu += 0.25*h.u[i]; mv += 0.25*h.v[i]; mz += 0.25*quad[i][2]; }
      for (int i=0; i<4; i++) {
        const double du = h.u[i]-mu, dv = h.v[i]-mv, dz = quad[i][2]-mz;
        suu += du*du; suv += du*dv; svv += dv*dv; suz += du*dz; svz += dv*dz;
      }
      const double det = suu*svv - suv*suv;
      const double a = det > 0 ? (suz*svv - svz*suv)/det : 0;
      const double b = det > 0 ? (svz*suu - suz*suv)/det : 0;
      for (int i=0; i<4; i++)
        h.z[i] = mz + a*((i&1)-mu) + b*((i>>1)-mv);
      h.valid = true;
      return h;
    }

    /*! smallest z scale whose range holds all corner heights */
    inline double requiredZScale(const NodeBox& box, const CornerHeights& h)
    {
      const double centre = box.lower[2] + 0.5*box.extent[2];
      double r = 0;
      for (int i=0; i<4; i++)
        r = std::fabs(h.z[i]-centre) > r ? std::fabs(h.z[i]-centre) : r;
      return 2*r/box.extent[2];
    }

    /*! Quantises corner heights; solidLeaf when the interval of one bin does not
     *  contain the quad's vertices with the slack. */
    inline uint16_t encodeLeaf(const NodeBox& box, float zScale, const double quad[4][3], const CornerHeights& h)
    {
      const LeafBins bins(box,zScale);
      uint16_t leaf = 0;
      float lower[4];
      for (int i=0; i<4; i++)
      {
        double q = std::floor((h.z[i]-bins.base)/bins.size);
        q = q < 0 ? 0 : q > heightBins-1 ? heightBins-1 : q;
        leaf = uint16_t(leaf | (uint16_t(q) << (4*i)));
        lower[i] = bins.base + float(q)*bins.size;
      }
      if (leaf == solidLeaf || leaf == emptyLeaf) return solidLeaf;

      for (int i=0; i<4; i++) {
        const double z = bilinear(lower,float(h.u[i]),float(h.v[i]));
        if (quad[i][2] < z - containmentSlack || quad[i][2] > z + bins.size + containmentSlack) return solidLeaf;
      }
      return leaf;
    }
  }}
}
