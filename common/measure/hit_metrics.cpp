// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/hit_metrics.h"

namespace programs {

std::vector<float> pixelErrors(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits,
                               float footprint) {
  std::vector<float> errors(hits.size());
  for (size_t i = 0; i < hits.size(); i++) {
    if (reference[i].hit() && hits[i].hit())
      errors[i] = std::abs(hits[i].t - reference[i].t) / (footprint * reference[i].t);
    else errors[i] = hits[i].hit() ? falseHitError : reference[i].hit() ? missError : backgroundError;
  }
  return errors;
}

std::vector<SurfaceHit> nearerHits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b) {
  std::vector<SurfaceHit> nearer = a;
  for (size_t i = 0; i < nearer.size(); i++)
    if (b[i].t < nearer[i].t) nearer[i] = b[i];
  return nearer;
}

/* Distance in quads; none if the hits are on different patches. */
static std::optional<float> distanceOnPatch(const SurfaceHit& a, const SurfaceHit& b, const PatchLayout& layout) {
  if (a.face != b.face) return std::nullopt;
  const Patch& patch = layout.find(b.face, b.u, b.v);
  if (&patch != &layout.find(b.face, a.u, a.v)) return std::nullopt;
  return std::hypot(b.u - a.u, b.v - a.v) * float(patch.resolution);
}

HitErrors compareHits(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits, float footprint,
                      const PatchLayout& layout) {
  HitErrors result;
  result.rays = hits.size();
  const std::vector<float> pixels = pixelErrors(reference, hits, footprint);
  ErrorSamples samples;
  double inlierSquares = 0, signedSum = 0;
  for (size_t i = 0; i < hits.size(); i++) {
    result.falseHits += pixels[i] == falseHitError;
    result.misses += pixels[i] == missError;
    if (pixels[i] < 0.0f) continue;
    if (pixels[i] > outlierPixels) result.outliers++;
    else {
      inlierSquares += double(pixels[i]) * pixels[i];
      signedSum += hits[i].t < reference[i].t ? -double(pixels[i]) : double(pixels[i]);
    }
    const Vec3f a = normalize(reference[i].normal), b = normalize(hits[i].normal);
    const float angle = std::atan2(length(cross(a, b)), dot(a, b));
    samples.add(pixels[i], angle * 180.0f / float(M_PI), distanceOnPatch(reference[i], hits[i], layout));
  }
  result.bothHit = samples.hits();
  const size_t inliers = result.bothHit - result.outliers;
  result.inlierRmse = rootOfMean(inlierSquares, inliers);
  result.bias = inliers ? signedSum / double(inliers) : 0.0;
  static_cast<ErrorSummary&>(result) = samples.summary();
  return result;
}

} // namespace programs
