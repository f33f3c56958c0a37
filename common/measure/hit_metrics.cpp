// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/hit_metrics.h"

namespace cbvh {

std::vector<float> pixelErrors(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits,
                               float footprint)
{
  std::vector<float> errors(hits.size());
  for (size_t i = 0; i < hits.size(); i++)
  {
    if (reference[i].hit() && hits[i].hit())
      errors[i] = std::abs(hits[i].t - reference[i].t) / (footprint * reference[i].t);
    else
      errors[i] = hits[i].hit() ? falseHitError : reference[i].hit() ? missError : backgroundError;
  }
  return errors;
}

std::vector<SurfaceHit> nearerHits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b)
{
  std::vector<SurfaceHit> nearer = a;
  for (size_t i = 0; i < nearer.size(); i++)
    if (b[i].t < nearer[i].t)
      nearer[i] = b[i];
  return nearer;
}

double quantile(std::vector<float>& values, double q)
{
  if (values.empty())
    return 0.0;
  const double rank = std::ceil(q * double(values.size()));
  const size_t k = size_t(std::min(std::max(rank - 1.0, 0.0), double(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + ptrdiff_t(k), values.end());
  return values[k];
}

HitErrors compareHits(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits, float footprint,
                      const PatchLayout& layout)
{
  HitErrors result;
  result.rays = hits.size();
  const std::vector<float> pixels = pixelErrors(reference, hits, footprint);
  std::vector<float> distances, angles, cells;
  double sumOfSquares = 0, sumOfOthers = 0, signedSum = 0;
  for (size_t i = 0; i < hits.size(); i++)
  {
    result.falseHits += pixels[i] == falseHitError;
    result.misses += pixels[i] == missError;
    if (pixels[i] < 0.0f)
      continue;
    distances.push_back(pixels[i]);
    sumOfSquares += double(pixels[i]) * pixels[i];
    if (pixels[i] > farOffPixels)
      result.farOff++;
    else
    {
      sumOfOthers += double(pixels[i]) * pixels[i];
      signedSum += hits[i].t < reference[i].t ? -double(pixels[i]) : double(pixels[i]);
    }

    const Vec3f a = reference[i].normal, b = hits[i].normal;
    const float angle = std::atan2(length(cross(normalize(a), normalize(b))), dot(normalize(a), normalize(b)));
    angles.push_back(angle * 180.0f / float(M_PI));

    const Patch* patch = nullptr;
    if (reference[i].face == hits[i].face)
    {
      patch = &layout.find(hits[i].face, hits[i].u, hits[i].v);
      if (patch != &layout.find(hits[i].face, reference[i].u, reference[i].v))
        patch = nullptr;
    }
    if (patch)
      cells.push_back(std::hypot(hits[i].u - reference[i].u, hits[i].v - reference[i].v) * float(patch->resolution));
    else
      result.otherPatch++;
  }
  result.bothHit = distances.size();
  if (result.bothHit)
    result.rmse = std::sqrt(sumOfSquares / double(result.bothHit));
  if (result.bothHit > result.farOff)
  {
    result.rmseOfOthers = std::sqrt(sumOfOthers / double(result.bothHit - result.farOff));
    result.bias = signedSum / double(result.bothHit - result.farOff);
  }
  result.median = quantile(distances, 0.5);
  result.p99 = quantile(distances, 0.99);
  result.max = quantile(distances, 1.0);
  result.normalMedian = quantile(angles, 0.5);
  result.normalP99 = quantile(angles, 0.99);
  result.uvMedian = quantile(cells, 0.5);
  result.uvP99 = quantile(cells, 0.99);
  return result;
}

} // namespace cbvh
