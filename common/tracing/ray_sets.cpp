// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/ray_sets.h"
#include "basics/sampling.h"

namespace programs {
namespace {

void shuffle(std::vector<size_t>& order, std::mt19937& random) {
  for (size_t i = order.size(); i > 1; i--) std::swap(order[i - 1], order[random() % i]);
}

} // namespace

const char* raySetName(RaySet set) { return set == Coherent ? "coherent" : "incoherent"; }

Ray primaryRay(const Camera& camera, int x, int y, Vec2f offset) {
  Ray ray;
  ray.origin = camera.eye();
  ray.direction = camera.direction(float(x) + offset.x, float(y) + offset.y);
  return ray;
}

std::vector<Ray> primaryRays(const Camera& camera, Vec2f offset) {
  return primaryRays(camera, Crop(camera.size()), offset);
}

std::vector<Ray> primaryRays(const Camera& camera, const Crop& part, Vec2f offset) {
  std::vector<Ray> rays;
  rays.reserve(part.numPixels());
  for (int y = part.y0; y < part.y1; y++)
    for (int x = part.x0; x < part.x1; x++) rays.push_back(primaryRay(camera, x, y, offset));
  return rays;
}

std::vector<Ray> coherentRays(const std::vector<Ray>& primary, ImageSize size, size_t count) {
  constexpr int tile = 8;
  const int columns = (size.width + tile - 1) / tile, rows = (size.height + tile - 1) / tile;
  const size_t tiles = size_t(columns) * rows;
  const size_t wanted = count == 0 ? tiles : std::min(tiles, (count - 1) / (tile * tile) + 1);
  std::vector<Ray> rays;
  rays.reserve(wanted * tile * tile);
  for (size_t i = 0; i < wanted; i++) {
    const size_t t = i * tiles / wanted;
    const int x0 = int(t % columns) * tile, y0 = int(t / columns) * tile;
    for (int y = y0; y < std::min(y0 + tile, size.height); y++)
      for (int x = x0; x < std::min(x0 + tile, size.width); x++) rays.push_back(primary[size_t(y) * size.width + x]);
  }
  return rays;
}

std::vector<Ray> bounceRays(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                            const BounceSettings& settings) {
  std::mt19937 random(settings.seed);
  std::vector<size_t> order;
  for (size_t i = 0; i < hits.size(); i++)
    if (hits[i].hit() && hasDirection(hits[i].normal)) order.push_back(i);
  shuffle(order, random);
  if (settings.count) order.resize(std::min(order.size(), settings.count));

  std::vector<Ray> rays;
  rays.reserve(order.size());
  for (size_t i : order) {
    Vec3f n = normalize(hits[i].normal);
    if (dot(n, primary[i].direction) > 0.0f) n = -n;
    Ray ray;
    ray.origin = primary[i].origin + hits[i].t * primary[i].direction + settings.offset * n;
    ray.direction = cosineDirection(n, random);
    ray.time = primary[i].time;
    rays.push_back(ray);
  }
  return rays;
}

} // namespace programs
