// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/height_bins.h"
#include "basics/parallel.h"
#include "measure/hit_metrics.h"
#include "measure/quantiles.h"

namespace programs {
namespace {

using Corners = std::array<Vec3d, 4>; // (0,0), (1,0), (0,1), (1,1)

Vec3d normalOf(const Corners& c) { return normalize(cross(c[3] - c[0], c[2] - c[1])); }

/* A tessellated patch, in the frame of the cage. */
struct Tessellation {
  const TrueView& view;
  const TrueSurface& surface;
  PatchPoint patch;
  unsigned resolution;
  int level;

  Vec3d vertex(unsigned i, unsigned j, bool displaced) const {
    const PatchPoint p{patch.face, patch.subPatch, double(i) / resolution, double(j) / resolution};
    const LimitSample s = surface.limitSurface().evaluate(p);
    if (!displaced || !view.model.displacement) return s.p;
    const FacePoint q = surface.patches().toEmbree(p);
    const Vec3d normal = normalize(cross(s.du, s.dv));
    const SurfacePoints point{q.face, level, 1, &q.u, &q.v};
    if (!view.model.displacement->isAlongNormals()) {
      const Vec3f n{float(normal.x), float(normal.y), float(normal.z)};
      Vec3f v;
      view.model.displacement->vectors(point, &n, &v);
      return s.p + toDouble(v);
    }
    float offset;
    view.model.displacement->offsets(point, &offset);
    return s.p + double(offset) * normal;
  }

  /* Corners of size x size quads. */
  Corners corners(unsigned i, unsigned j, unsigned size, bool displaced) const {
    return {vertex(i, j, displaced), vertex(i + size, j, displaced), vertex(i, j + size, displaced),
            vertex(i + size, j + size, displaced)};
  }
};

/* Size of a bin along the ray, in pixels. NaN without a surface, a normal of the quad or a normal of the block. */
float heightBin(const TrueView& view, const Ray& ray, const SurfaceHit& hit, const BlockGrid& blocks) {
  const unsigned faces = unsigned(view.model.cage.numFaces());
  const FacePoint reported{hit.face % faces, hit.u, hit.v};
  if (!hit.hit() || !view.surfaces[hit.face / faces].has(reported.face)) return NAN;
  const TrueSurface& surface = view.surfaces[hit.face / faces];
  const Placement& copy = view.model.copies[hit.face / faces];
  const PatchPoint at = surface.patches().fromEmbree(reported);
  const unsigned resolution = blocks.layout.find(hit.face, hit.u, hit.v).resolution;
  const Tessellation patch{view, surface, at, resolution, blocks.level};

  const unsigned block = std::min(resolution, unsigned(blocks.blockWidth()));
  const unsigned i = std::min(unsigned(at.u * resolution), resolution - 1);
  const unsigned j = std::min(unsigned(at.v * resolution), resolution - 1);
  const Vec3d z = normalOf(patch.corners(i / block * block, j / block * block, block, false));
  if (!(dot(z, z) > 0.0)) return NAN;
  const Corners quad = patch.corners(i, j, 1, true);
  const Vec3d n = normalOf(quad), d = copy.directionToCage(toDouble(ray.direction));
  double lowest = INFINITY, highest = -INFINITY;
  for (const Vec3d& p : quad) {
    lowest = std::min(lowest, dot(z, p));
    highest = std::max(highest, dot(z, p));
  }
  const double bin = (highest - lowest) / 16.0 * copy.scale;
  return float(bin * std::abs(dot(z, n) / dot(d, n)) / (double(view.footprint) * hit.t));
}

} // namespace

HeightBins heightBins(const TrueView& view, const std::vector<SurfaceHit>& hits, const BlockGrid& blocks,
                      unsigned threads) {
  std::vector<float> bins(view.sample.size());
  parallelFor(bins.size(), 64, threads, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; k++)
      bins[k] = heightBin(view, view.rays[view.sample[k]], hits[view.sample[k]], blocks);
  });
  bins.erase(std::remove_if(bins.begin(), bins.end(), [](float b) { return std::isnan(b); }), bins.end());

  /* Errors are uniform over half a bin. For bins above 10 pixels, only a share is within 5 pixels; its mean square
   * is a third of the largest square. */
  constexpr int errorsPerBin = 20;
  HeightBins result;
  result.hits = bins.size();
  std::vector<float> errors;
  double weight = 0, sumOfSquares = 0;
  for (float b : bins) {
    for (int k = 0; k < errorsPerBin; k++) errors.push_back((float(k) + 0.5f) / errorsPerBin * 0.5f * b);
    const double farthest = std::min(0.5 * b, double(outlierPixels));
    const double share = b > 0.0f ? 2.0 * farthest / b : 1.0;
    weight += share;
    sumOfSquares += share * farthest * farthest / 3.0;
  }
  for (size_t k = 0; k < result.quantiles.size(); k++)
    result.quantiles[k] = quantile(bins, double(k + 1) / double(result.quantiles.size() + 1));
  result.median = quantile(errors, 0.5);
  result.inlierRmse = weight > 0.0 ? std::sqrt(sumOfSquares / weight) : 0.0;
  return result;
}

} // namespace programs
