// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Statistics that a task of a build collects. */

#include "codec_names.h"
#include "surface_statistics.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace embree::cbvh { inline namespace CBVH_ISA {
struct BuildStatistics : public SurfaceStatistics {
  /*! findVertex(): returns an InvalidVertex, for the first face. */
  template<typename FindVertex>
  void addInvalidFace(size_t face, const FindVertex& findVertex) {
    invalidFaces++;
    if (face >= firstInvalidFace) return;
    firstInvalidFace = face;
    firstInvalidVertex = findVertex();
  }

  void addUnsupportedFace(size_t face) {
    sums.numUnsupportedFaces++;
    firstUnsupportedFace = std::min(firstUnsupportedFace, face);
  }

  /*! own: vertex as its face evaluates it. stored: the decoded vertex. */
  void addVertex(const float own[3], const float stored[3]) { addDeviation(distance2(own, stored)); }

  void addDeviation(double squaredDistance) { maxSquaredDeviation = std::max(maxSquaredDeviation, squaredDistance); }

  /*! For a vertex on an edge between two faces. shared: vertex as the edge's owner evaluates it. */
  void addBorderVertex(const float own[3], const float shared[3], const float stored[3]) {
    addVertex(shared, stored);
    maxSquaredMismatch = std::max(maxSquaredMismatch, distance2(own, shared));
  }

  /*! Adds the statistics of another part of the surface. Only this function computes sums.maxVertexDeviation and
   *  sums.maxBorderMismatch. */
  void merge(const BuildStatistics& other) {
    add(other);
    maxSquaredDeviation = std::max(maxSquaredDeviation, other.maxSquaredDeviation);
    maxSquaredMismatch = std::max(maxSquaredMismatch, other.maxSquaredMismatch);
    sums.maxVertexDeviation = float(std::sqrt(maxSquaredDeviation));
    sums.maxBorderMismatch = float(std::sqrt(maxSquaredMismatch));
  }

  /*! Adds the final statistics of a surface. */
  void add(const SurfaceStatistics& other) {
    cbvh::add(sums, other.sums);
    highRateQuads += other.highRateQuads;
    framelessQuads += other.framelessQuads;
    framelessQuadsInGrid += other.framelessQuadsInGrid;
    quadsForHoles += other.quadsForHoles;
    bytesInEmbree += other.bytesInEmbree;
    invalidFaces += other.invalidFaces;
    facesWithoutSurface += other.facesWithoutSurface;
    if (other.firstInvalidFace < firstInvalidFace) {
      firstInvalidFace = other.firstInvalidFace;
      firstInvalidVertex = other.firstInvalidVertex;
    }
    firstUnsupportedFace = std::min(firstUnsupportedFace, other.firstUnsupportedFace);
  }

private:
  /*! Squared distance; 0 if a vertex is not finite. */
  static double distance2(const float a[3], const float b[3]) {
    const double x = double(a[0]) - b[0], y = double(a[1]) - b[1], z = double(a[2]) - b[2];
    const double d2 = x * x + y * y + z * z;
    return d2 < std::numeric_limits<double>::max() ? d2 : 0.0;
  }

  double maxSquaredDeviation = 0, maxSquaredMismatch = 0;
};
}} // namespace embree::cbvh::CBVH_ISA
