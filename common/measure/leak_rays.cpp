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

namespace programs {
namespace {

constexpr size_t raysPerPoint = 8;
constexpr size_t pointsPerChunk = 128;

struct InsidePoint {
  Vec3f origin;
  AimPoint target;
};

struct WallHit {
  float t = INFINITY;
  float slope = 0; // d(height above the surface)/dt, positive if the ray leaves
  Vec3f normal;

  bool fromBack() const { return slope > 0.0f; }
  bool hit() const { return t < INFINITY; }
};

WallHit wallHitOf(const RTCRayHit& out, const Ray& ray) {
  if (out.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const Vec3f normal = normalize(Vec3f{out.hit.Ng_x, out.hit.Ng_y, out.hit.Ng_z});
  return {out.ray.tfar, dot(normal, ray.direction), normal};
}

WallHit closest(RTCScene scene, RTCIntersectContext& context, const Ray& ray) {
  RTCRayHit out;
  load(ray, out);
  rtcIntersect1(scene, &context, &out);
  return wallHitOf(out, ray);
}

bool any(RTCScene scene, RTCIntersectContext& context, const Ray& ray) {
  RTCRay out;
  load(ray, out);
  rtcOccluded1(scene, &context, &out);
  return out.tfar < 0.0f;
}

Ray rayFrom(Vec3f origin, Vec3f direction, float tnear = 0.0f) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.tnear = tnear;
  return ray;
}

float perturbed(float x, std::mt19937& random) {
  const int steps = int(random() % 5) - 2;
  for (int i = 0; i < std::abs(steps); i++) x = std::nextafter(x, steps < 0 ? -INFINITY : INFINITY);
  return x;
}

class Tracer {
public:
  Tracer(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings, uint32_t seed)
    : grid(grid),
      scene(scene),
      points(points),
      settings(settings),
      random(seed) {
    rtcInitIntersectContext(&context);
  }

  LeakCounts run(size_t numPoints) {
    for (size_t i = 0; i < numPoints; i++) {
      InsidePoint point;
      if (findInsidePoint(points[i % numAimKinds], i / numAimKinds % 2, point)) addRaysFrom(point);
    }
    trace();
    return counts;
  }

private:
  /* If `grazing`, directions are within 6 degrees of the surface, more after each attempt that fails. */
  bool findInsidePoint(const std::vector<AimPoint>& from, bool grazing, InsidePoint& point) {
    for (int attempt = 0; attempt < 64 && !from.empty(); attempt++) {
      point.target = from[uniformIndex(from.size(), random)];
      const Vec3f inwards = -normalize(point.target.normal);
      const float cosine = (grazing ? 0.1f + 0.01f * float(attempt) : 1.0f) * uniform(random);
      const Vec3f direction = directionAround(inwards, cosine, 2.0f * float(M_PI) * uniform(random));
      const float edge = length(point.target.neighbor - point.target.position);
      const WallHit wall = closest(grid, context, rayFrom(point.target.position, direction, 0.01f * edge));
      if (!wall.fromBack() || wall.t < 4.0f * std::max(edge, settings.thickness)) continue;
      point.origin = point.target.position + 0.5f * wall.t * direction;
      if (isInside(point.origin) && isClear(point.origin, {point.target.position - point.origin, point.target.normal}))
        return true;
    }
    return false;
  }

  bool isInside(Vec3f p) {
    for (int i = 0; i < 2; i++)
      if (!closest(grid, context, rayFrom(p, uniformDirection(random))).fromBack()) return false;
    return true;
  }

  bool isOutside(Vec3f p) {
    for (int i = 0; i < 16; i++)
      if (closest(grid, context, rayFrom(p, uniformDirection(random))).fromBack()) return false;
    return true;
  }

  /* True if p is farther from the surface than the thickness, so that rays from p start inside. Searches along the
   * normals of walls seen in the given and in random directions, where the nearest points are. */
  bool isClear(Vec3f p, std::array<Vec3f, 2> directions) {
    const float distance = 1.5f * settings.thickness;
    for (size_t i = 0; i < 10; i++) {
      const Vec3f direction = i < directions.size() ? normalize(directions[i]) : uniformDirection(random);
      const WallHit wall = closest(grid, context, rayFrom(p, direction));
      Ray nearest = rayFrom(p, wall.fromBack() ? wall.normal : -wall.normal);
      nearest.tfar = distance;
      if (wall.hit() && (wall.t < distance || any(grid, context, nearest))) return false;
    }
    return true;
  }

  void addRaysFrom(const InsidePoint& point) {
    const auto towards = [&](Vec3f target) { return target - point.origin; };
    const AimPoint& a = point.target;
    Vec3f d = towards(a.position);
    addRay(point, d, true);
    addRay(point, {perturbed(d.x, random), perturbed(d.y, random), perturbed(d.z, random)}, true);
    for (int i = 0; i < 3; i++) addRay(point, towards(lerp(a.position, a.neighbor, uniform(random))), true);
    addRay(point, normalize(d), true);
    addRay(point, uniformDirection(random), false);
    const float side = random() & 1 ? 1.0f : -1.0f;
    const size_t axis = uniformIndex(3, random);
    addRay(point, {axis == 0 ? side : 0.0f, axis == 1 ? side : 0.0f, axis == 2 ? side : 0.0f}, false);
  }

  void addRay(const InsidePoint& point, Vec3f direction, bool aimed) {
    testRays.push_back({rayFrom(point.origin, direction), aimed});
  }

  /* Traces all rays in one call, for the speed of devices. */
  void trace() {
    std::vector<RTCRayHit> closestHits(testRays.size());
    std::vector<RTCRay> anyHits(testRays.size());
    for (size_t i = 0; i < testRays.size(); i++) {
      load(testRays[i].ray, closestHits[i]);
      load(testRays[i].ray, anyHits[i]);
    }
    scene.intersect(closestHits.data(), testRays.size());
    scene.occluded(anyHits.data(), testRays.size());
    for (size_t i = 0; i < testRays.size(); i++)
      judge(testRays[i].ray, testRays[i].aimed, wallHitOf(closestHits[i], testRays[i].ray), anyHits[i].tfar < 0.0f);
  }

  void judge(const Ray& ray, bool aimed, const WallHit& inScene, bool anyInScene) {
    const WallHit inGrid = closest(grid, context, ray);
    const Leaks sceneLeaks = leaks(inScene, anyInScene, inGrid, ray);
    counts.rays++;
    counts.aimed += aimed;
    counts.gridLeaks += leaks(inGrid, any(grid, context, ray), inScene, ray);
    counts.sceneLeaks += sceneLeaks;
    if (!aimed) counts.random += sceneLeaks;
    if (sceneLeaks.closest + sceneLeaks.any + sceneLeaks.through > 0 && counts.examples.size() < counts.maxExamples)
      counts.examples.push_back(ray);
  }

  Leaks leaks(const WallHit& found, bool foundAny, const WallHit& other, const Ray& ray) {
    Leaks leaks;
    leaks.closest = !found.hit();
    leaks.any = !foundAny;
    leaks.through = found.hit() && other.hit() && leaksThrough(found, other, ray);
    return leaks;
  }

  /* True if a ray hits the outside of a wall, well after the first wall of the other scene, and is outside halfway
   * between. Excludes rays that only touch the first wall and continue inside the surface. */
  bool leaksThrough(const WallHit& found, const WallHit& first, const Ray& ray) {
    const float tolerance = 2.0f * settings.thickness + 1e-5f * length(ray.origin);
    if (found.fromBack() || !((found.t - first.t) * std::abs(first.slope) > tolerance)) return false;
    const Vec3f p = ray.origin + 0.5f * (first.t + found.t) * ray.direction;
    return isOutside(p) && isClear(p, {first.normal, found.normal});
  }

  struct TestRay {
    Ray ray;
    bool aimed;
  };

  RTCScene grid;
  const SceneTracer& scene;
  std::vector<TestRay> testRays;
  const AimPoints& points;
  const LeakSettings& settings;
  std::mt19937 random;
  RTCIntersectContext context;
  LeakCounts counts;
};

} // namespace

Leaks& Leaks::operator+=(const Leaks& other) {
  closest += other.closest;
  any += other.any;
  through += other.through;
  return *this;
}

LeakCounts countLeaks(RTCScene grid, const SceneTracer& scene, const AimPoints& points, const LeakSettings& settings,
                      unsigned threads) {
  LeakCounts sum;
  std::mutex mutex;
  const size_t numPoints = (settings.rays + raysPerPoint - 1) / raysPerPoint;
  parallelFor(numPoints, pointsPerChunk, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    const uint32_t seed = settings.seed + 0x9E3779B9u * uint32_t(begin / pointsPerChunk + 1);
    const LeakCounts local = Tracer(grid, scene, points, settings, seed).run(end - begin);
    const std::lock_guard<std::mutex> lock(mutex);
    sum.rays += local.rays;
    sum.aimed += local.aimed;
    sum.sceneLeaks += local.sceneLeaks;
    sum.gridLeaks += local.gridLeaks;
    sum.random += local.random;
    for (const Ray& ray : local.examples)
      if (sum.examples.size() < sum.maxExamples) sum.examples.push_back(ray);
  });
  return sum;
}

} // namespace programs
