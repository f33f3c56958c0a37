// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Places inside are found by rays inwards from aim points: the middle of such a ray sees its aim point, and is
 * inside if random rays from there first hit GRID's surface from the back. */

#include "measure/leak_rays.h"
#include "basics/parallel.h"
#include "basics/sampling.h"
#include "tracing/ray_conversion.h"

#include <atomic>
#include <limits>

namespace cbvh {
namespace {

constexpr size_t raysOfPlace = 8;
constexpr size_t placesOfChunk = 128;
constexpr size_t maxExamples = 16;

struct Place
{
  Vec3f origin;
  AimPoint target;
};

struct Found
{
  float t = INFINITY;
  float slope = 0; // d(height above the surface)/dt, positive if the ray leaves
  Vec3f normal;

  bool fromBack() const { return slope > 0.0f; }
  bool hit() const { return t < INFINITY; }
};

Found foundBy(const RTCRayHit& out, const Ray& ray)
{
  if (out.hit.geomID == RTC_INVALID_GEOMETRY_ID)
    return {};
  const Vec3f normal = normalize(Vec3f{out.hit.Ng_x, out.hit.Ng_y, out.hit.Ng_z});
  return {out.ray.tfar, dot(normal, ray.direction), normal};
}

Found closest(RTCScene scene, RTCIntersectContext& context, const Ray& ray)
{
  RTCRayHit out;
  load(ray, out);
  rtcIntersect1(scene, &context, &out);
  return foundBy(out, ray);
}

bool any(RTCScene scene, RTCIntersectContext& context, const Ray& ray)
{
  RTCRay out;
  load(ray, out);
  rtcOccluded1(scene, &context, &out);
  return out.tfar < 0.0f;
}

Ray rayFrom(Vec3f origin, Vec3f direction, float tnear = 0.0f)
{
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.tnear = tnear;
  return ray;
}

float nudged(float x, std::mt19937& random)
{
  const int steps = int(random() % 5) - 2;
  for (int i = 0; i < std::abs(steps); i++)
    x = std::nextafter(x, steps < 0 ? -INFINITY : INFINITY);
  return x;
}

class Tracer
{
public:
  Tracer(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings, uint32_t seed)
    : grid(grid), scene(scene), points(points), settings(settings), random(seed)
  {
    rtcInitIntersectContext(&context);
  }

  LeakCounts run(size_t places)
  {
    for (size_t i = 0; i < places; i++)
    {
      Place place;
      if (findPlace(points[i % numAimKinds], i / numAimKinds % 2, place))
        drawFrom(place);
    }
    trace();
    return counts;
  }

private:
  /* If `grazing`, directions are within 6 degrees of the surface, slightly more if they end too close to it. */
  bool findPlace(const std::vector<AimPoint>& from, bool grazing, Place& place)
  {
    for (int attempt = 0; attempt < 64 && !from.empty(); attempt++)
    {
      place.target = from[below(from.size(), random)];
      const Vec3f inwards = -normalize(place.target.normal);
      const float cosine = (grazing ? 0.1f + 0.01f * float(attempt) : 1.0f) * uniform(random);
      const Vec3f direction = around(inwards, cosine, 2.0f * float(M_PI) * uniform(random));
      const float edge = length(place.target.neighbor - place.target.position);
      const Found wall = closest(grid, context, rayFrom(place.target.position, direction, 0.01f * edge));
      if (!wall.fromBack() || wall.t < 4.0f * std::max(edge, settings.thickness))
        continue;
      place.origin = place.target.position + 0.5f * wall.t * direction;
      if (isInside(place.origin) && isClear(place.origin, {place.target.position - place.origin, place.target.normal}))
        return true;
    }
    return false;
  }

  bool isInside(Vec3f p)
  {
    for (int i = 0; i < 2; i++)
      if (!closest(grid, context, rayFrom(p, anyDirection(random))).fromBack())
        return false;
    return true;
  }

  bool isOutside(Vec3f p)
  {
    for (int i = 0; i < 16; i++)
      if (closest(grid, context, rayFrom(p, anyDirection(random))).fromBack())
        return false;
    return true;
  }

  /* True if p is farther from the surface than the thickness, so that rays from p start inside. Searches along the
   * normals of walls seen in the given and in random directions, where the nearest points are. */
  bool isClear(Vec3f p, std::array<Vec3f, 2> directions)
  {
    const float distance = 1.5f * settings.thickness;
    for (size_t i = 0; i < 10; i++)
    {
      const Vec3f direction = i < directions.size() ? normalize(directions[i]) : anyDirection(random);
      const Found wall = closest(grid, context, rayFrom(p, direction));
      Ray nearest = rayFrom(p, wall.fromBack() ? wall.normal : -wall.normal);
      nearest.tfar = distance;
      if (wall.hit() && (wall.t < distance || any(grid, context, nearest)))
        return false;
    }
    return true;
  }

  void drawFrom(const Place& place)
  {
    const auto towards = [&](Vec3f target) { return target - place.origin; };
    const AimPoint& a = place.target;
    Vec3f d = towards(a.position);
    draw(place, d, true);
    draw(place, {nudged(d.x, random), nudged(d.y, random), nudged(d.z, random)}, true);
    for (int i = 0; i < 3; i++)
      draw(place, towards(lerp(a.position, a.neighbor, uniform(random))), true);
    draw(place, normalize(d), true);
    draw(place, anyDirection(random), false);
    const float side = random() & 1 ? 1.0f : -1.0f;
    const size_t axis = below(3, random);
    draw(place, {axis == 0 ? side : 0.0f, axis == 1 ? side : 0.0f, axis == 2 ? side : 0.0f}, false);
  }

  void draw(const Place& place, Vec3f direction, bool aimed)
  {
    drawn.push_back({rayFrom(place.origin, direction), aimed});
  }

  /* Traces all rays in one call, for the speed of devices. */
  void trace()
  {
    std::vector<RTCRayHit> closestHits(drawn.size());
    std::vector<RTCRay> anyHits(drawn.size());
    for (size_t i = 0; i < drawn.size(); i++)
    {
      load(drawn[i].ray, closestHits[i]);
      load(drawn[i].ray, anyHits[i]);
    }
    scene.intersect(closestHits.data(), drawn.size());
    scene.occluded(anyHits.data(), drawn.size());
    for (size_t i = 0; i < drawn.size(); i++)
      judge(drawn[i].ray, drawn[i].aimed, foundBy(closestHits[i], drawn[i].ray), anyHits[i].tfar < 0.0f);
  }

  void judge(const Ray& ray, bool aimed, const Found& inScene, bool anyInScene)
  {
    const Found inGrid = closest(grid, context, ray);
    const Leaks sceneLeaks = leaks(inScene, anyInScene, inGrid, ray);
    counts.rays++;
    counts.aimed += aimed;
    counts.gridLeaks += leaks(inGrid, any(grid, context, ray), inScene, ray);
    counts.sceneLeaks += sceneLeaks;
    if (!aimed)
      counts.random += sceneLeaks;
    if (sceneLeaks.closest + sceneLeaks.any + sceneLeaks.through > 0 && counts.examples.size() < maxExamples)
      counts.examples.push_back(ray);
  }

  Leaks leaks(const Found& found, bool foundAny, const Found& other, const Ray& ray)
  {
    Leaks leaks;
    leaks.closest = !found.hit();
    leaks.any = !foundAny;
    leaks.through = found.hit() && other.hit() && leaksThrough(found, other, ray);
    return leaks;
  }

  /* True if a ray hits the outside of a wall, well after the first wall of the other scene, and is outside halfway
   * between. Excludes rays that only touch the first wall and continue inside the surface. */
  bool leaksThrough(const Found& found, const Found& first, const Ray& ray)
  {
    const float tolerance = 2.0f * settings.thickness + 1e-5f * length(ray.origin);
    if (found.fromBack() || !((found.t - first.t) * std::abs(first.slope) > tolerance))
      return false;
    const Vec3f p = ray.origin + 0.5f * (first.t + found.t) * ray.direction;
    return isOutside(p) && isClear(p, {first.normal, found.normal});
  }

  struct Drawn
  {
    Ray ray;
    bool aimed;
  };

  RTCScene grid;
  const SceneTracer& scene;
  std::vector<Drawn> drawn;
  const AimPoints& points;
  const LeakSettings& settings;
  std::mt19937 random;
  RTCIntersectContext context;
  LeakCounts counts;
};

} // namespace

Leaks& Leaks::operator+=(const Leaks& other)
{
  closest += other.closest;
  any += other.any;
  through += other.through;
  return *this;
}

LeakCounts countLeaks(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings,
                      unsigned threads)
{
  LeakCounts sum;
  std::mutex mutex;
  const size_t places = (settings.rays + raysOfPlace - 1) / raysOfPlace;
  parallelFor(places, placesOfChunk, threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    const uint32_t seed = settings.seed + 0x9E3779B9u * uint32_t(begin / placesOfChunk + 1);
    const LeakCounts local = Tracer(grid, scene, points, settings, seed).run(end - begin);
    const std::lock_guard<std::mutex> lock(mutex);
    sum.rays += local.rays;
    sum.aimed += local.aimed;
    sum.sceneLeaks += local.sceneLeaks;
    sum.gridLeaks += local.gridLeaks;
    sum.random += local.random;
    for (const Ray& ray : local.examples)
      if (sum.examples.size() < maxExamples)
        sum.examples.push_back(ray);
  });
  return sum;
}

} // namespace cbvh
