// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Filters a map within charts. The texture's own filter reads up to three filter widths around a point, also texels of
 * other charts and of the background. Near the ends of a chart, this filter only reads texels of the chart, and
 * continues them linearly beyond its ends. */

#include "surface/height_texture.h"
#include "surface/texture_charts.h"

namespace programs {

class ChartFilter {
public:
  /* Both must outlive the filter. */
  ChartFilter(const HeightTexture& texture, const TextureCharts& charts) : texture(texture), charts(charts) {}

  /* As HeightTexture::sample, for a point of a chart: the same values away from the chart's ends. */
  void sample(unsigned image, unsigned chart, Vec2f at, Vec2f width, float* values) const;

private:
  const HeightTexture& texture;
  const TextureCharts& charts;
};

} // namespace programs
