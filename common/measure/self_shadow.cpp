// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/self_shadow.h"
#include "basics/parallel.h"
#include "basics/sampling.h"
#include "tracing/ray_conversion.h"

namespace cbvh {
namespace {

constexpr size_t chunk = 1024;

bool seenFromBehind(const Ray& ray, const SurfaceHit& hit)
{
  return dot(hit.normal, ray.direction) > 0.0f;
}

/* On the side that the ray comes from; nothing where there is no normal. */
Vec3f facing(const Ray& ray, const SurfaceHit& hit)
{
  const Vec3f n = normalize(hit.normal);
  return seenFromBehind(ray, hit) ? -n : n;
}

Vec3f position(const Ray& ray, const SurfaceHit& hit)
{
  return ray.origin + hit.t * ray.direction;
}

bool hasNormal(const SurfaceHit& hit)
{
  return hit.hit() && length(hit.normal) > 0.0f;
}

bool isOccluded(RTCScene scene, RTCIntersectContext& context, const Ray& ray)
{
  RTCRay out;
  load(ray, out);
  rtcOccluded1(scene, &context, &out);
  return out.tfar < 0.0f;
}

void count(ShadowErrors& errors, bool truth, bool found)
{
  errors.falseOcclusions += found && !truth;
  errors.falsePasses += truth && !found;
}

void add(ShadowErrors& sum, const ShadowErrors& e)
{
  sum.falseOcclusions += e.falseOcclusions;
  sum.falsePasses += e.falsePasses;
}

/* Random numbers of a chunk of pixels. A pixel always takes the same number of them, so
 * that every representation gets the same. */
std::mt19937 randomOfChunk(const ShadowSettings& settings, size_t begin)
{
  return std::mt19937(settings.seed + 0x9E3779B9u * uint32_t(begin / chunk + 1));
}

void skipPixel(const ShadowSettings& settings, std::mt19937& random)
{
  random.discard(2 * settings.raysPerHit);
}

} // namespace

Ray secondaryRay(const Ray& primary, const SurfaceHit& hit, Vec3f direction, const RayOffset& offset, float footprint,
                 float length)
{
  const Vec3f p = position(primary, hit);
  Ray ray;
  ray.origin = p + (offset.length + offset.pixels * footprint * hit.t) * facing(primary, hit);
  ray.direction = direction;
  ray.tnear = offset.ulps * 0x1p-23f * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), hit.t});
  ray.tfar = length;
  return ray;
}

ShadowComparison compareShadows(RTCScene grid, const std::vector<SurfaceHit>& gridHits, RTCScene scene,
                                const std::vector<SurfaceHit>& hits, const std::vector<Ray>& primary,
                                float footprint, const ShadowSettings& settings, unsigned threads)
{
  ShadowComparison sum;
  std::mutex mutex;
  parallelFor(primary.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    std::mt19937 random = randomOfChunk(settings, begin);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    ShadowComparison local;
    for (size_t i = begin; i < end; i++)
    {
      if (!hasNormal(gridHits[i]) || !hasNormal(hits[i]))
      {
        skipPixel(settings, random);
        continue;
      }
      const bool same = std::abs(hits[i].t - gridHits[i].t) <= footprint * gridHits[i].t;
      const bool turned = seenFromBehind(primary[i], hits[i]) != seenFromBehind(primary[i], gridHits[i]);
      const Vec3f n = facing(primary[i], gridHits[i]);
      for (unsigned k = 0; k < settings.raysPerHit; k++)
      {
        const Vec3f direction = cosineDirection(n, random);
        const auto from = [&](const SurfaceHit& hit) {
          return secondaryRay(primary[i], hit, direction, settings.offset, footprint, settings.length);
        };
        const bool truth = isOccluded(grid, context, from(gridHits[i]));
        const Ray own = from(hits[i]);
        const bool found = isOccluded(scene, context, own);
        local.rays++;
        local.occluded += truth;
        count(local.all, truth, found);
        count(local.control, truth, isOccluded(grid, context, own));
        if (same)
        {
          local.raysOfSame++;
          count(local.ofSame, truth, found);
        }
        if (turned)
        {
          local.raysOfTurned++;
          count(local.ofTurned, truth, found);
        }
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    sum.rays += local.rays;
    sum.occluded += local.occluded;
    sum.raysOfSame += local.raysOfSame;
    add(sum.all, local.all);
    add(sum.ofSame, local.ofSame);
    sum.raysOfTurned += local.raysOfTurned;
    add(sum.ofTurned, local.ofTurned);
    add(sum.control, local.control);
  });
  return sum;
}

std::vector<float> ambientOcclusion(RTCScene scene, const std::vector<Ray>& primary,
                                    const std::vector<SurfaceHit>& hits, float footprint,
                                    const ShadowSettings& settings, unsigned threads)
{
  std::vector<float> light(primary.size(), 1.0f);
  parallelFor(primary.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    std::mt19937 random = randomOfChunk(settings, begin);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = begin; i < end; i++)
    {
      if (!hasNormal(hits[i]))
      {
        skipPixel(settings, random);
        continue;
      }
      const Vec3f n = facing(primary[i], hits[i]);
      unsigned free = 0;
      for (unsigned k = 0; k < settings.raysPerHit; k++)
        free += !isOccluded(scene, context,
                            secondaryRay(primary[i], hits[i], cosineDirection(n, random), settings.offset, footprint,
                                         settings.length));
      light[i] = float(free) / float(settings.raysPerHit);
    }
  });
  return light;
}

} // namespace cbvh
