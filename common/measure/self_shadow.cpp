// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/self_shadow.h"
#include "basics/parallel.h"
#include "basics/sampling.h"
#include "tracing/ray_conversion.h"

namespace programs {
namespace {

constexpr size_t chunk = 1024;

bool seenFromBehind(const Ray& ray, const SurfaceHit& hit) { return dot(hit.normal, ray.direction) > 0.0f; }

/* Unit normal on the side of the ray, or zero if there is none. */
Vec3f facing(const Ray& ray, const SurfaceHit& hit) {
  const Vec3f n = normalize(hit.normal);
  return seenFromBehind(ray, hit) ? -n : n;
}

Vec3f position(const Ray& ray, const SurfaceHit& hit) { return ray.origin + hit.t * ray.direction; }

bool hasNormal(const SurfaceHit& hit) { return hit.hit() && hasDirection(hit.normal); }

/* Traced in one call, for the speed of devices. */
class ShadowRays {
public:
  void add(const Ray& ray) {
    rays.emplace_back();
    load(ray, rays.back());
  }
  void trace(const SceneTracer& scene) { scene.occluded(rays.data(), rays.size()); }
  bool isOccluded(size_t i) const { return rays[i].tfar < 0.0f; }

private:
  std::vector<RTCRay> rays;
};

void count(ShadowErrors& errors, bool truth, bool found) {
  errors.falseOcclusions += found && !truth;
  errors.falsePasses += truth && !found;
}

ShadowErrors& operator+=(ShadowErrors& sum, const ShadowErrors& e) {
  sum.falseOcclusions += e.falseOcclusions;
  sum.falsePasses += e.falsePasses;
  return sum;
}

ShadowComparison& operator+=(ShadowComparison& sum, const ShadowComparison& c) {
  sum.rays += c.rays;
  sum.occluded += c.occluded;
  sum.sameHitRays += c.sameHitRays;
  sum.flippedRays += c.flippedRays;
  sum.all += c.all;
  sum.sameHitErrors += c.sameHitErrors;
  sum.flippedErrors += c.flippedErrors;
  sum.control += c.control;
  return sum;
}

/* Every pixel consumes the same number of random numbers, so that every representation gets the same directions. */
std::mt19937 randomOfChunk(const ShadowSettings& settings, size_t begin) {
  return std::mt19937(settings.seed + 0x9E3779B9u * uint32_t(begin / chunk + 1));
}

void skipPixel(const ShadowSettings& settings, std::mt19937& random) { random.discard(2 * settings.raysPerHit); }

/* The origin is offset to the side of the primary ray. */
Ray secondaryRay(const Ray& primary, const SurfaceHit& hit, Vec3f direction, const ShadowSettings& settings,
                 float footprint) {
  const RayOffset& offset = settings.offset;
  const Vec3f p = position(primary, hit);
  Ray ray;
  ray.time = primary.time;
  ray.origin = p + (offset.length + offset.pixels * footprint * hit.t) * facing(primary, hit);
  ray.direction = direction;
  ray.tnear = offset.ulps * 0x1p-23f * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), hit.t});
  ray.tfar = settings.length;
  return ray;
}

class PixelComparer {
public:
  PixelComparer(const TracedHits& grid, const TracedHits& tested, const PrimaryRays& primary,
                const ShadowSettings& settings)
    : grid(grid),
      tested(tested),
      primary(primary),
      settings(settings) {}

  void add(size_t pixel, std::mt19937& random) {
    const Ray& ray = primary.rays[pixel];
    const SurfaceHit &gridHit = grid.hits[pixel], &hit = tested.hits[pixel];
    if (!hasNormal(gridHit) || !hasNormal(hit)) {
      skipPixel(settings, random);
      return;
    }
    const bool same = std::abs(hit.t - gridHit.t) <= primary.footprint * gridHit.t;
    const bool flipped = seenFromBehind(ray, hit) != seenFromBehind(ray, gridHit);
    const Vec3f n = facing(ray, gridHit);
    for (unsigned k = 0; k < settings.raysPerHit; k++) {
      const Vec3f direction = cosineDirection(n, random);
      const Ray ownRay = secondaryRay(ray, hit, direction, settings, primary.footprint);
      truth.add(secondaryRay(ray, gridHit, direction, settings, primary.footprint));
      own.add(ownRay);
      control.add(ownRay);
      kinds.push_back({same, flipped});
    }
  }

  ShadowComparison compare() {
    truth.trace(grid.scene);
    control.trace(grid.scene);
    own.trace(tested.scene);
    ShadowComparison sum;
    for (size_t i = 0; i < kinds.size(); i++) {
      const bool isShadow = truth.isOccluded(i), found = own.isOccluded(i);
      sum.rays++;
      sum.occluded += isShadow;
      count(sum.all, isShadow, found);
      count(sum.control, isShadow, control.isOccluded(i));
      if (kinds[i].same) {
        sum.sameHitRays++;
        count(sum.sameHitErrors, isShadow, found);
      }
      if (kinds[i].flipped) {
        sum.flippedRays++;
        count(sum.flippedErrors, isShadow, found);
      }
    }
    return sum;
  }

private:
  struct Kind {
    bool same, flipped;
  };

  const TracedHits &grid, &tested;
  const PrimaryRays& primary;
  const ShadowSettings& settings;
  ShadowRays truth, own, control;
  std::vector<Kind> kinds;
};

} // namespace

ShadowComparison compareShadows(const TracedHits& grid, const TracedHits& tested, const PrimaryRays& primary,
                                const ShadowSettings& settings, unsigned threads) {
  ShadowComparison sum;
  std::mutex mutex;
  parallelFor(primary.rays.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    std::mt19937 random = randomOfChunk(settings, begin);
    PixelComparer comparer(grid, tested, primary, settings);
    for (size_t i = begin; i < end; i++) comparer.add(i, random);
    const ShadowComparison chunkSum = comparer.compare();
    const std::lock_guard<std::mutex> lock(mutex);
    sum += chunkSum;
  });
  return sum;
}

std::vector<float> ambientOcclusion(const TracedHits& tested, const PrimaryRays& primary,
                                    const ShadowSettings& settings, unsigned threads) {
  std::vector<float> light(primary.rays.size(), 1.0f);
  parallelFor(light.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    std::mt19937 random = randomOfChunk(settings, begin);
    ShadowRays rays;
    std::vector<size_t> pixels;
    for (size_t i = begin; i < end; i++) {
      const Ray& ray = primary.rays[i];
      const SurfaceHit& hit = tested.hits[i];
      if (!hasNormal(hit)) {
        skipPixel(settings, random);
        continue;
      }
      const Vec3f n = facing(ray, hit);
      for (unsigned k = 0; k < settings.raysPerHit; k++)
        rays.add(secondaryRay(ray, hit, cosineDirection(n, random), settings, primary.footprint));
      pixels.push_back(i);
    }
    rays.trace(tested.scene);
    for (size_t i = 0; i < pixels.size(); i++) {
      unsigned free = 0;
      for (unsigned k = 0; k < settings.raysPerHit; k++) free += !rays.isOccluded(i * settings.raysPerHit + k);
      light[pixels[i]] = float(free) / float(settings.raysPerHit);
    }
  });
  return light;
}

} // namespace programs
