// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/true_errors.h"
#include "basics/parallel.h"
#include "measure/hit_metrics.h"
#include "measure/quantiles.h"

#include <random>

namespace programs {
namespace {

/* In pixels unless stated otherwise. */
struct Measure {
  bool isMeasured = false, isOutlier = false;
  float distance = 0, world = 0, along = 0, angle = 0; // world: world units; angle: degrees
  std::optional<float> uvDistance;                     // in quads, on the same patch
};

Measure measure(const TrueView& view, const Ray& ray, const SurfaceHit& hit, const PatchLayout& layout) {
  constexpr double crossingTolerance = 1e-3; // pixels
  Measure result;
  const unsigned faces = unsigned(view.model.cage.numFaces());
  if (!hit.hit()) return result;
  const FacePoint reported{hit.face % faces, hit.u, hit.v};
  const TrueSurface& surface = view.surfaces[hit.face / faces];
  if (!surface.has(reported.face)) return result;
  result.isMeasured = true;
  const Placement& copy = view.model.copies[hit.face / faces];

  const double pixel = double(view.footprint) * hit.t;
  const Vec3d origin = copy.pointToCage(toDouble(ray.origin));
  const Vec3d direction = copy.directionToCage(toDouble(ray.direction));
  const Vec3d x = origin + direction * (hit.t / copy.scale);
  const PatchPoint start = surface.patches().fromEmbree(reported);
  const double resolution = layout.find(hit.face, hit.u, hit.v).resolution;
  const TruePoint foot = surface.nearest(x, start, 1.0 / resolution);
  result.world = float(length(foot.position - x) * copy.scale);
  result.distance = float(result.world / pixel);

  const auto intersection =
      surface.crossing(origin, direction, foot, 1.0 / resolution, crossingTolerance * pixel / copy.scale);
  result.along = intersection ? float(dot(x - intersection->position, direction) * copy.scale / pixel) : INFINITY;
  result.isOutlier = std::abs(result.along) > outlierPixels;

  const Vec3d a = normalize(cross(foot.du, foot.dv));
  const Vec3d b = normalize(copy.directionToCage(toDouble(hit.normal)));
  result.angle = float(std::atan2(length(cross(a, b)), dot(a, b)) * 180.0 / M_PI);
  if (foot.at.face == start.face && foot.at.subPatch == start.subPatch)
    result.uvDistance = float(std::hypot(foot.at.u - start.u, foot.at.v - start.v) * resolution);
  return result;
}

} // namespace

std::vector<size_t> sampleHits(const std::vector<SurfaceHit>& hits, size_t count, uint32_t seed) {
  std::vector<size_t> all;
  for (size_t i = 0; i < hits.size(); i++)
    if (hits[i].hit()) all.push_back(i);
  std::vector<size_t> chosen;
  std::mt19937 engine(seed);
  for (size_t i = 0; i < all.size() && chosen.size() < count; i++)
    if (double(engine()) * 0x1p-32 * double(all.size() - i) < double(count - chosen.size())) chosen.push_back(all[i]);
  return chosen;
}

TrueErrors compareToTrueSurface(const TrueView& view, const std::vector<SurfaceHit>& hits, const PatchLayout& layout,
                                unsigned threads) {
  std::vector<Measure> measures(view.sample.size());
  parallelFor(measures.size(), 64, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++)
      measures[i] = measure(view, view.rays[view.sample[i]], hits[view.sample[i]], layout);
  });

  TrueErrors result;
  ErrorSamples samples;
  std::vector<float> world;
  double squaresWorld = 0, squaresAlong = 0, sumAlong = 0;
  for (const Measure& m : measures) {
    if (!m.isMeasured) continue;
    samples.add(m.distance, m.angle, m.uvDistance);
    world.push_back(m.world);
    squaresWorld += double(m.world) * m.world;
    result.outliers += m.isOutlier;
    if (!m.isOutlier) {
      squaresAlong += double(m.along) * m.along;
      sumAlong += m.along;
    }
  }
  static_cast<ErrorSummary&>(result) = samples.summary();
  result.hits = samples.hits();
  const size_t inliers = result.hits - result.outliers;
  result.rmseWorld = rootOfMean(squaresWorld, result.hits);
  result.medianWorld = quantile(world, 0.5);
  result.p99World = quantile(world, 0.99);
  result.rmseAlong = rootOfMean(squaresAlong, inliers);
  result.bias = inliers ? sumAlong / double(inliers) : 0.0;
  return result;
}

} // namespace programs
