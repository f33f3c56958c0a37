// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The lattices of the primitives of a geometry, and of the vertices that they share, at each time step: the third part
 * of the rule in shared_border.h. Which vertices these are is the topology's; it has
 *
 *   typedef Scratch
 *       Memory of a task, made of a Device*.
 *   size_t size ()
 *       Number of primitives.
 *   double spacingOfEdge ()
 *       Of LatticeChoice.
 *   void extendBounds (size_t primitive, unsigned step, BBox3fa& bounds)
 *       Extends bounds by the primitive. The diagonal of the geometry's bounds limits default spacings.
 *   bool addLines (size_t primitive, unsigned step, Scratch& scratch, LatticeChoice& choice)
 *       Adds the borders and the middles of the primitive's patches. False if it has no vertices at that step. It may
 *       keep vertices for later: it is called once per primitive and step, the steps of a primitive in order.
 *   void forEachShared (size_t primitive, closure(size_t element, bool isTracedByGrid))
 *       Calls closure for each element that the primitive shares with others, or may share. An element is a number for
 *       vertices with one lattice: a corner, the interior of an edge, or one vertex.
 *
 * All are called by several threads at once, for different primitives. */

#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include "../base/codec.h"
#include "../base/tasks.h"
#include "../../cvert/encoder/lattice.h"
#include "coarse_lattice.h"
#include "plan.h"
#include <algorithm>

namespace embree
{
  namespace isa
  {
    /*! The lattice of a primitive, from lines of its vertices: its borders, and the middles of its patches. */
    class LatticeChoice
    {
    public:
      /*! ofEdge: default spacing as a part of the median edge, for an application's vertices; 0 for evaluated ones */
      explicit LatticeChoice (double ofEdge = 0) : ofEdge(ofEdge) {}

      /*! Adds the number of quads along u and v. */
      void addPatch (const unsigned quads[2]) { for (int d=0; d<2; d++) fewest[d] = min(fewest[d],quads[d]); }

      /*! Adds vertices along u or v. isCoarse: on a border that has a lower rate than its patch */
      void addLine (bool alongU, const float (*vertices)[3], size_t count, bool isCoarse = false) {
        samples[alongU ? 0 : 1][isCoarse].add(vertices,count);
      }

      /*! diagonal: of the geometry */
      int exponent (const CompressionPlan& plan, double diagonal)
      {
        if (plan.isLossless()) return cbvh::exactLattice;
        double spacing = 0; // quads may be much longer than wide: the shorter side counts
        for (int d=0; d<2; d++) {
          const double median = samples[d][samples[d][0].empty()].median();
          if (median > 0) medianEdge = medianEdge > 0 ? min(medianEdge,median) : median;
          const double wanted = ofEdge > 0 ? median*ofEdge : cbvh::defaultSpacing(median,fewest[d],diagonal);
          if (wanted > 0) spacing = spacing > 0 ? min(spacing,wanted) : wanted;
        }
        return cbvh::latticeExponent(spacingAskedFor(plan,spacing));
      }

      /*! median edge along u or v, whichever is shorter, once exponent() was called; 0 if there is none */
      double edge () const { return medianEdge; }

    private:
      /*! Returns the default if the application did not ask for a bound. */
      double spacingAskedFor (const CompressionPlan& plan, double byDefault) const
      {
        const CompressionSettings& settings = plan.settings;
        double spacing = settings.maxError > 0 ? double(settings.maxError) : INFINITY;
        if (settings.maxPixelError > 0)
        {
          double distance2 = 0;
          for (int k=0; k<3; k++)
          {
            double lower = INFINITY, upper = -INFINITY;
            for (const auto& along : samples)
              for (const cbvh::EdgeSample& s : along) { lower = min(lower,s.lower[k]); upper = max(upper,s.upper[k]); }
            const double grow = 0.25*(upper-lower), c = settings.cameraPosition[k];
            const double d = max(max(lower-grow-c,c-upper-grow),0.0);
            distance2 += d*d;
          }
          spacing = min(spacing,double(settings.maxPixelError)*settings.pixelSize*std::sqrt(distance2));
        }
        if (plan.kind() != cbvh::Kind::VERT) return min(spacing,byDefault); // a bound of leaves
        return spacing < INFINITY ? spacing : byDefault;
      }

      const double ofEdge;
      double medianEdge = 0;
      cbvh::EdgeSample samples[2][2];   //!< along u, v; of the patch's rate, of coarse borders
      unsigned fewest[2] = { ~0u,~0u }; //!< quads
    };

    class BorderLattices
    {
    public:
      BorderLattices (Device* device, const CompressionPlan& plan)
        : device(device), plan(plan), own(device,0), shared(device,0) {}

      /*! Chooses the lattices of all primitives. Calls progress() now and then, which may cancel by an exception. */
      template<typename Topology, typename Progress>
      void choose (Topology& topology, size_t perTask, const Progress& progress)
      {
        const size_t size = topology.size();
        fill(own,size,int8_t(cbvh::exactLattice));
        std::vector<double> diagonals;
        for (unsigned step=0; step<plan.numTimeSteps; step++) diagonals.push_back(diagonal(topology,step,perTask));
        MutexSys mutex;
        double sumOfSpacings = 0, sumOfEdges = 0;
        size_t numEdges = 0;
        forRanges(size,perTask,[&](const range<size_t>& r) {
            typename Topology::Scratch scratch(device);
            double spacings = 0, edges = 0;
            size_t n = 0;
            for (size_t i=r.begin(); i!=r.end(); i++)
              for (unsigned step=0; step<plan.numTimeSteps; step++) {
                LatticeChoice choice(topology.spacingOfEdge());
                if (!topology.addLines(i,step,scratch,choice)) continue;
                const int exponent = choice.exponent(plan,diagonals[step]);
                own[i*plan.numTimeSteps + step] = int8_t(exponent);
                if (choice.edge() > 0) { spacings += std::ldexp(1.0,exponent); edges += choice.edge(); n++; }
              }
            progress();
            Lock<MutexSys> lock(mutex);
            sumOfSpacings += spacings;
            sumOfEdges += edges;
            numEdges += n;
          });
        if (plan.settings.maxError > 0 && plan.kind() == cbvh::Kind::VERT && sumOfEdges > 0)
          warnIfCoarse(device,sumOfSpacings/double(numEdges),sumOfEdges/double(numEdges));
      }

      /*! Chooses the lattices of shared elements, whose numbers are below numElements. All begin with the finest of all
       *  primitives, which leaves few to be raised, and an element of no primitive with an arbitrary one. */
      template<typename Topology, typename Progress>
      void share (Topology& topology, size_t numElements, size_t perTask, const Progress& progress)
      {
        fill(shared,numElements,own.empty() ? int8_t(cbvh::exactLattice) : *std::min_element(own.begin(),own.end()));
        forRanges(topology.size(),perTask,[&](const range<size_t>& r) {
            for (size_t i=r.begin(); i!=r.end(); i++)
              topology.forEachShared(i,[&](size_t element, bool isTracedByGrid) {
                  int8_t* const at = &shared[element*plan.numTimeSteps];
                  for (unsigned step=0; step<plan.numTimeSteps; step++)
                    raise(at[step],isTracedByGrid ? int8_t(ofGrid) : own[i*plan.numTimeSteps + step]);
                });
            progress();
          });
      }

      void clear () { own.clear(); shared.clear(); }

      /*! Exponent of the lattice of a primitive's own vertices; exactLattice if it has none. */
      int ofPrimitive (size_t primitive, unsigned step) const { return own[primitive*plan.numTimeSteps + step]; }

      /*! Exponent of the lattice of a shared element; exactLattice if it has none. */
      int ofShared (size_t element, unsigned step) const
      {
        const int exponent = shared[element*plan.numTimeSteps + step];
        return exponent == ofGrid ? cbvh::exactLattice : exponent;
      }

    private:
      enum { ofGrid = 127 }; //!< stands for no lattice, and is above all others

      void fill (mvector<int8_t>& exponents, size_t count, int8_t value) const
      {
        cbvh::resizeToFit(exponents,count*plan.numTimeSteps);
        std::fill(exponents.begin(),exponents.end(),value);
      }

      template<typename Topology>
      static double diagonal (Topology& topology, unsigned step, size_t perTask)
      {
        const BBox3fa bounds = reduceRanges(topology.size(),perTask,BBox3fa(empty),[&](const range<size_t>& r) {
            BBox3fa b(empty);
            for (size_t i=r.begin(); i!=r.end(); i++) topology.extendBounds(i,step,b);
            return b;
          },[](const BBox3fa& a, const BBox3fa& b) { return merge(a,b); });
        return bounds.empty() ? 0.0 : length(bounds.size());
      }

      static void raise (int8_t& exponent, int8_t value)
      {
        const cbvh::AtomicRef<int8_t> at(exponent);
        int8_t found = at.load(std::memory_order_relaxed);
        while (found < value && !at.exchangeWeak(found,value,std::memory_order_relaxed)) {}
      }

      Device* const device;
      const CompressionPlan& plan;
      mvector<int8_t> own, shared; //!< exponents at each step, by primitive and by element
    };
  }
}
