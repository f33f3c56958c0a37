// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The lattice of a face, or of a grid, from lines of its vertices: its borders, and the middles of its patches. */

#include "../base/codec.h"
#include "../../cvert/encoder/lattice.h"
#include "plan.h"

namespace embree
{
  namespace isa
  {
    class LatticeChoice
    {
    public:
      /*! ofEdge: default spacing as a part of the median edge, of vertices of an application; 0 of those that are evaluated */
      explicit LatticeChoice (double ofEdge = 0) : ofEdge(ofEdge) {}

      /*! of so many quads along u and v */
      void addPatch (const unsigned quads[2]) { for (int d=0; d<2; d++) fewest[d] = min(fewest[d],quads[d]); }

      /*! Vertices along u, or v. isCoarse: on a border that has a lower rate than its patch */
      void addLine (bool alongU, const float (*vertices)[3], size_t count, bool isCoarse = false) {
        (isCoarse ? coarse : samples)[alongU ? 0 : 1].add(vertices,count);
      }

      /*! diagonal: of the geometry */
      int exponent (const CompressionPlan& plan, double diagonal)
      {
        if (plan.isLossless()) return cbvh::exactLattice;
        /* quads may be much longer than wide: the shorter side counts */
        double spacing = 0, lower[3], upper[3];
        for (int k=0; k<3; k++)
        {
          lower[k] = min(min(samples[0].lower[k],samples[1].lower[k]),min(coarse[0].lower[k],coarse[1].lower[k]));
          upper[k] = max(max(samples[0].upper[k],samples[1].upper[k]),max(coarse[0].upper[k],coarse[1].upper[k]));
        }
        for (int d=0; d<2; d++) {
          const double median = (samples[d].empty() ? coarse[d] : samples[d]).median();
          const double wanted = ofEdge > 0 ? median*ofEdge : cbvh::defaultSpacing(median,fewest[d],diagonal);
          if (wanted > 0) spacing = spacing > 0 ? min(spacing,wanted) : wanted;
        }
        return cbvh::latticeExponent(spacingAskedFor(plan,lower,upper,spacing));
      }

    private:
      /*! the default where nothing was asked for */
      static double spacingAskedFor (const CompressionPlan& plan, const double lower[3], const double upper[3], double byDefault)
      {
        const CompressionSettings& settings = plan.settings;
        double spacing = settings.maxError > 0 ? double(settings.maxError) : INFINITY;
        if (settings.maxPixelError > 0)
        {
          double distance2 = 0;
          for (int k=0; k<3; k++)
          {
            const double grow = 0.25*(upper[k]-lower[k]), c = settings.cameraPosition[k];
            const double d = max(max(lower[k]-grow-c,c-upper[k]-grow),0.0);
            distance2 += d*d;
          }
          spacing = min(spacing,double(settings.maxPixelError)*settings.pixelSize*std::sqrt(distance2));
        }
        if (plan.kind() != cbvh::Kind::VERT) return min(spacing,byDefault); // a bound of leaves
        return spacing < INFINITY ? spacing : byDefault;
      }

      const double ofEdge;
      cbvh::EdgeSample samples[2], coarse[2]; //!< along u, v
      unsigned fewest[2] = { ~0u,~0u };       //!< quads
    };
  }
}
