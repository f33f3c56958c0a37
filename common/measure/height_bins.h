// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What heights of 4 bits can give at best, in the tightest box of each quad: a yardstick
 * for leaves, out of the surface alone, without any code of theirs.
 *
 * A box along z, the normal of a block's corners before displacement, has 16 bins from
 * the lowest to the highest vertex of its quad. Rounding to a bin's middle leaves an error
 * of up to half a bin either way, all alike, and a plane with normal N that moves by dz
 * along z moves by dz (z.N)/(d.N) along a ray d. That interpolation averages several
 * rounded heights is left out: with three it would take RMSE down to sqrt(1/2) on average. */

#include "measure/block_grid.h"
#include "measure/true_errors.h"

#include <array>

namespace cbvh {

struct HeightBins
{
  size_t hits = 0; // that were measured
  /* Of bins along the ray, in pixels: quantile k + 1 of 20. */
  std::array<double, 19> quantiles{};
  /* Of the errors that such bins leave, in pixels, as HitErrors has them: the median of
   * all, the RMSE of those within 5 pixels. */
  double median = 0, rmseOfOthers = 0;
};

/* view: with the sample to measure. hits: GRID's, one a ray of the view. Throws Cancelled. */
HeightBins heightBins(const TrueView& view, const std::vector<SurfaceHit>& hits, const BlockGrid& blocks,
                      unsigned threads);

} // namespace cbvh
