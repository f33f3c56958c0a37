// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lattices of primitives and shared vertices per time step: part 3 of the rule in shared_border.h. A Topology has these
 * members, which threads call concurrently for different primitives:
 *
 *   typedef Scratch
 *       Memory of a task, constructed from a Device*.
 *   size_t size ()
 *       Number of primitives.
 *   double spacingPerEdge ()
 *       Argument of LatticeChoice.
 *   void extendBounds (size_t primitive, unsigned step, BBox3fa& bounds)
 *       Extends bounds by points of the primitive. The diagonal of the geometry's bounds limits default spacings.
 *   bool addLines (size_t primitive, unsigned step, Scratch& scratch, LatticeChoice& choice)
 *       Adds the borders and middles of the primitive's patches, and for maxPixelError the bounds of all vertices.
 *       Returns false if it has no vertices at that step. Called once per primitive and step, in the order of steps, so
 *       that it may store vertices.
 *   void forEachShared (size_t primitive, closure(size_t element))
 *       Calls closure for each element that the primitive may share with others. An element is the index of a corner,
 *       of the interior of an edge, or of a vertex. Its vertices have one lattice. */

#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include "../base/codec_names.h"
#include "../base/tasks.h"
#include "../../cvert/encoder/lattice.h"
#include "coarse_lattice.h"
#include "plan.h"
#include <algorithm>
#include <limits>

namespace embree::isa {
/*! Chooses a lattice from samples of vertices. */
class LatticeChoice {
public:
  /*! spacingPerEdge: default spacing of an application's vertices, as a fraction of the median edge; 0 for vertices
   *  that were evaluated. */
  explicit LatticeChoice(double spacingPerEdge) : spacingPerEdge(spacingPerEdge) {}

  /*! Must be called for each patch if spacingPerEdge is 0. quads: along u and v. */
  void addPatch(const unsigned quads[2]) {
    for (int d = 0; d < 2; d++) minQuads[d] = min(minQuads[d], quads[d]);
  }

  /*! Adds a row or column of vertices. isCoarse: a border with a lower rate, and so longer edges, than its patch;
   *  these edges count only if there are no others. */
  void addLine(bool alongU, const float (*vertices)[3], size_t count, bool isCoarse = false) {
    samples[alongU ? 0 : 1][isCoarse].add(vertices, count);
    for (size_t i = 0; i < count; i++)
      for (int k = 0; k < 3; k++) lowestBit = min(lowestBit, exponentOfLowestBit(vertices[i][k]));
  }

  /*! Extends the bounds to which maxPixelError applies. Lines of addLine() are included anyway. */
  void extendBounds(const cbvh::WorldBounds& other) { bounds.extend(other); }
  void extendBounds(const float p[3]) {
    if (cbvh::isFinite(p)) bounds.extend(p[0], p[1], p[2]);
  }

  /*! Returns the exponent of the lattice's spacing, or losslessExponent. diagonal: of the geometry's bounds. */
  int exponent(const CompressionPlan& plan, double diagonal) {
    if (plan.isLossless()) return cbvh::losslessExponent;
    double spacing = 0; // of the shorter sides, because quads can be much longer than wide
    for (int d = 0; d < 2; d++) {
      const double median = samples[d][samples[d][0].empty()].median();
      if (median > 0) lowerMedian = lowerMedian > 0 ? min(lowerMedian, median) : median;
      const double spacingOfLines =
          spacingPerEdge > 0 ? median * spacingPerEdge : cbvh::defaultSpacing(median, minQuads[d], diagonal);
      if (spacingOfLines > 0) spacing = spacing > 0 ? min(spacing, spacingOfLines) : spacingOfLines;
    }
    return cbvh::latticeExponent(requestedSpacing(plan, spacing));
  }

  /*! Shorter median edge of u and v, or 0. Call exponent() first. */
  double medianEdge() const { return lowerMedian; }

  /*! True if all vertices of the lines are on a lattice, so that it moves none of them. */
  bool areOnLattice(int exponent) const { return exponent <= lowestBit; }

private:
  /*! Returns the smaller spacing that max_error and maxPixelError request, or the default. maxPixelError
   *  applies at the distance from the camera to the bounds, enlarged by a quarter per side for other vertices. */
  double requestedSpacing(const CompressionPlan& plan, double defaultSpacing) const {
    const CompressionSettings& settings = plan.settings;
    double spacing = settings.maxError > 0 ? double(settings.maxError) : INFINITY;
    if (settings.maxPixelError > 0) {
      double distance2 = 0;
      for (int k = 0; k < 3; k++) {
        double lower = bounds.lower[k], upper = bounds.upper[k];
        for (const auto& along : samples)
          for (const cbvh::EdgeSample& s : along) {
            lower = min(lower, s.lower[k]);
            upper = max(upper, s.upper[k]);
          }
        const double margin = 0.25 * (upper - lower), c = settings.cameraPosition[k];
        const double d = max(max(lower - margin - c, c - upper - margin), 0.0);
        distance2 += d * d;
      }
      spacing = min(spacing, double(settings.maxPixelError) * settings.pixelSize * std::sqrt(distance2));
    }
    // cLEAF: max_error is for leaves; here it only refines
    if (plan.kind() != cbvh::Kind::CVERT) return min(spacing, defaultSpacing);
    return spacing < INFINITY ? spacing : defaultSpacing;
  }

  const double spacingPerEdge;
  double lowerMedian = 0;
  int lowestBit = std::numeric_limits<int>::max(); //!< lowest exponent of a bit that is set in a coordinate
  cbvh::EdgeSample samples[2][2];                  //!< [along u, v][at the patch's rate, on coarse borders]
  cbvh::WorldBounds bounds;
  unsigned minQuads[2] = {~0u, ~0u};
};

class BorderLattices {
public:
  BorderLattices(Device* device, const CompressionPlan& plan)
    : device(device),
      plan(plan),
      own(device, 0),
      shared(device, 0) {}

  /*! Chooses the lattices of all primitives. Call this before chooseForShared(). */
  template<typename Topology, typename Progress>
  void chooseForPrimitives(Topology& topology, size_t perTask, const Progress& progress) {
    const size_t size = topology.size();
    fill(own, size, int8_t(cbvh::losslessExponent));
    std::vector<double> diagonals;
    for (unsigned step = 0; step < plan.numTimeSteps; step++) diagonals.push_back(diagonal(topology, step, perTask));
    MutexSys mutex;
    double sumOfSpacings = 0, sumOfEdges = 0;
    size_t numEdges = 0;
    forRanges(size, perTask, [&](const range<size_t>& r) {
      typename Topology::Scratch scratch(device);
      double spacings = 0, edges = 0;
      size_t n = 0;
      for (size_t i = r.begin(); i != r.end(); i++)
        for (unsigned step = 0; step < plan.numTimeSteps; step++) {
          LatticeChoice choice(topology.spacingPerEdge());
          if (!topology.addLines(i, step, scratch, choice)) continue;
          const int exponent = choice.exponent(plan, diagonals[step]);
          own[i * plan.numTimeSteps + step] = int8_t(exponent);
          const double edge = choice.medianEdge();
          if (edge > 0 && !choice.areOnLattice(exponent)) {
            spacings += std::ldexp(1.0, exponent);
            edges += edge;
            n++;
          }
        }
      progress();
      Lock<MutexSys> lock(mutex);
      sumOfSpacings += spacings;
      sumOfEdges += edges;
      numEdges += n;
    });
    if (plan.settings.maxError > 0 && plan.kind() == cbvh::Kind::CVERT && sumOfEdges > 0)
      warnIfCoarse(device, sumOfSpacings / double(numEdges), sumOfEdges / double(numEdges));
  }

  /*! Chooses the lattices of elements 0 to numElements-1: the coarsest lattice of their primitives.
   *  Elements without a primitive get the finest lattice of all. */
  template<typename Topology, typename Progress>
  void chooseForShared(Topology& topology, size_t numElements, size_t perTask, const Progress& progress) {
    fill(shared, numElements, own.empty() ? int8_t(cbvh::losslessExponent) : *std::min_element(own.begin(), own.end()));
    forRanges(topology.size(), perTask, [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++)
        topology.forEachShared(i, [&](size_t element) {
          int8_t* const at = &shared[element * plan.numTimeSteps];
          for (unsigned step = 0; step < plan.numTimeSteps; step++)
            atomicMax(at[step], own[i * plan.numTimeSteps + step]);
        });
      progress();
    });
  }

  void clear() {
    own.clear();
    shared.clear();
  }

  /*! Exponent of a primitive's lattice; losslessExponent if the primitive has no vertices at that step. */
  int ofPrimitive(size_t primitive, unsigned step) const { return own[primitive * plan.numTimeSteps + step]; }

  /*! Exponent of an element's lattice. */
  int ofShared(size_t element, unsigned step) const { return shared[element * plan.numTimeSteps + step]; }

private:
  void fill(mvector<int8_t>& exponents, size_t count, int8_t value) const {
    cbvh::resizeToFit(exponents, count * plan.numTimeSteps);
    std::fill(exponents.begin(), exponents.end(), value);
  }

  template<typename Topology>
  static double diagonal(Topology& topology, unsigned step, size_t perTask) {
    const BBox3fa bounds = reduceRanges(
        topology.size(), perTask, BBox3fa(empty),
        [&](const range<size_t>& r) {
          BBox3fa b(empty);
          for (size_t i = r.begin(); i != r.end(); i++) topology.extendBounds(i, step, b);
          return b;
        },
        [](const BBox3fa& a, const BBox3fa& b) { return merge(a, b); });
    if (bounds.empty()) return 0.0;
    const Vec3fa size = bounds.size();
    /* in double if squares of floats underflow, below 1e-19; they cannot overflow (cbvh::maxCoordinate) */
    if (dot(size, size) >= std::numeric_limits<float>::min()) return length(size);
    return cbvh::length(cbvh::Double3{size.x, size.y, size.z});
  }

  static void atomicMax(int8_t& exponent, int8_t value) {
    const cbvh::AtomicRef<int8_t> at(exponent);
    int8_t found = at.load(std::memory_order_relaxed);
    while (found < value && !at.compareExchangeWeak(found, value, std::memory_order_relaxed)) {}
  }

  Device* const device;
  const CompressionPlan& plan;
  mvector<int8_t> own, shared; //!< exponents of all steps, per primitive and per element
};
} // namespace embree::isa
