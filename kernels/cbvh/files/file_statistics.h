// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts the statistics of a surface to and from its record in a file (cvert/file/format.h). */

#include "../base/codec_names.h"
#include "../base/surface_statistics.h"
#include "../../cvert/file/format.h"

namespace embree::cbvh {
/*! Calls closure(member) for each integer that files store, in the order of FileGeometry::counts, which must not
 *  change. */
template<typename Statistics, typename Closure>
void forEachCount(Statistics& s, const Closure& closure) {
  closure(s.sums.topLevelBytes);
  closure(s.sums.headerBytes);
  closure(s.sums.nodeBytes);
  closure(s.sums.leafBytes);
  closure(s.sums.uncompressedBytes);
  closure(s.sums.numBlocks);
  closure(s.sums.numQuads);
  closure(s.sums.numUncompressedQuads);
  closure(s.sums.numInvalidQuads);
  closure(s.sums.numAffineBlocks);
  closure(s.sums.numSolidLeaves);
  closure(s.sums.numRawBlocks);
  closure(s.sums.numFallbackQuads);
  closure(s.sums.numFlippedQuads);
  closure(s.sums.numMeshQuads);
  closure(s.sums.numIrregularQuads);
  closure(s.sums.numMovingQuads);
  closure(s.sums.motionBytes);
  closure(s.highRateQuads);
  closure(s.framelessQuads);
  closure(s.framelessQuadsInGrid);
  closure(s.quadsForHoles);
  closure(s.bytesInEmbree);
}
/*! Same for floats, in the order of FileGeometry::measures. */
template<typename Statistics, typename Closure>
void forEachMeasure(Statistics& s, const Closure& closure) {
  closure(s.sums.maxLeafThickness);
  closure(s.sums.maxVertexSpacing);
  closure(s.sums.maxVertexDeviation);
  closure(s.sums.maxBorderMismatch);
}

inline SurfaceStatistics statisticsOf(const FileGeometry& record) {
  SurfaceStatistics statistics;
  size_t n = 0, m = 0;
  forEachCount(statistics, [&](size_t& count) { count = size_t(record.counts[n++]); });
  forEachMeasure(statistics, [&](float& measure) { measure = record.measures[m++]; });
  return statistics;
}
inline void setStatistics(FileGeometry& record, const SurfaceStatistics& statistics) {
  size_t n = 0, m = 0;
  forEachCount(statistics, [&](size_t count) { record.counts[n++] = count; });
  forEachMeasure(statistics, [&](float measure) { record.measures[m++] = measure; });
}
} // namespace embree::cbvh
