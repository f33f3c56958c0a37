// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/sampled_picture.h"
#include "basics/parallel.h"
#include "tracing/trace_hits.h"

#include <cmath>

namespace programs {

/* The additive sequence of the plastic number: any prefix fills a square evenly. */
Vec2f sampleOffset(int i) {
  const auto offset = [i](double step) {
    const double x = 0.5 + double(i) * step;
    return float(x - std::floor(x) - 0.5);
  };
  return {offset(0.7548776662466927), offset(0.5698402909980532)};
}

SampledPicture::SampledPicture(const Camera& camera, Vec3f up, HitColors colors)
  : SampledPicture(camera, Crop(camera.size()), up, colors) {}

SampledPicture::SampledPicture(const Camera& camera, const Crop& part, Vec3f up, HitColors colors)
  : part(part),
    height(camera.size().height),
    shader(camera.direction(float(camera.size().width / 2), float(height / 2)), up, colors),
    sums(part.numPixels()) {}

void SampledPicture::add(const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits, unsigned threads) {
  constexpr size_t chunk = 4096;
  parallelFor(sums.size(), chunk, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) addTo(i, rays[i], hits[i]);
  });
  endSample();
}

void SampledPicture::addTo(size_t pixel, const Ray& ray, const SurfaceHit& hit) {
  sums[pixel] =
      sums[pixel] + (hit.hit() ? shader.color(ray, hit) : backgroundColor(float(part.row(pixel)) / float(height)));
}

Image SampledPicture::image() const {
  Image image(part.size());
  for (size_t i = 0; i < sums.size(); i++) image.set(i, mean(i));
  return image;
}

std::vector<Vec3f> SampledPicture::linear() const {
  std::vector<Vec3f> colors(sums.size());
  for (size_t i = 0; i < sums.size(); i++) colors[i] = mean(i);
  return colors;
}

SampledPicture sampledPicture(const TracedScene& scene, const Camera& camera, const Crop& part, Vec3f up,
                              const std::vector<Ray>& first, const std::vector<SurfaceHit>& hits, int samples,
                              const Shutter& shutter, HitColors colors, unsigned threads) {
  SampledPicture picture(camera, part, up, colors);
  picture.add(first, hits, threads);
  for (int i = 1; i < samples; i++) {
    std::vector<Ray> rays = primaryRays(camera, part, sampleOffset(i));
    setTimes(rays, shutter, i, part, camera.size().width);
    picture.add(rays, traceClosest(scene, rays, threads), threads);
  }
  return picture;
}

} // namespace programs
