// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The best possible accuracy of 4-bit heights in the tightest box of each quad: a reference for leaves.
 *
 * A box along z, the normal of a block's corners before displacement, has 16 bins from the lowest to the highest
 * vertex of its quad. Rounding to the middle of a bin leaves an error that is uniform over half a bin each way. A
 * plane with normal N that moves by dz along z moves by dz (z.N)/(d.N) along a ray d. Interpolation is ignored:
 * averaging three rounded heights would reduce the RMSE to sqrt(1/2). */

#include "measure/block_grid.h"
#include "measure/true_errors.h"

#include <array>

namespace programs {

struct HeightBins {
  size_t hits = 0;
  /* Sizes of bins along the ray in pixels, quantiles (k + 1) / 20. */
  std::array<double, 19> quantiles{};
  /* Errors in pixels, as in HitErrors: the median of all, and the RMSE of errors up to 5 pixels. */
  double median = 0, inlierRmse = 0;
};

/* `view` holds the sample to measure; `hits` holds GRID's hits, one per ray of the view. Throws Canceled. */
HeightBins heightBins(const TrueView& view, const std::vector<SurfaceHit>& hits, const BlockGrid& blocks,
                      unsigned threads);

} // namespace programs
