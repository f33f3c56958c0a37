// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/sheet_crossings.h"
#include "basics/parallel.h"
#include "building/vulkan_tracer.h"
#include "tracing/ray_conversion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <random>
#include <utility>

namespace programs {
namespace {

constexpr int cageQuads = 4;          // per side
constexpr double maxCoordinate = 0.9; // limits rays, because displacement moves borders sideways
constexpr size_t raysPerChunk = 1000; // with one seed
constexpr double pi = 3.14159265358979323846;

class Draws {
public:
  explicit Draws(uint64_t seed) : engine(seed) {}
  double uniform(double lower, double upper) { return lower + (upper - lower) * (double(engine() >> 11) * 0x1p-53); }
  double magnitude(double lower, double upper) { return lower * std::pow(upper / lower, uniform(0, 1)); }
  int index(int n) { return int(uniform(0, n)); }

private:
  std::mt19937_64 engine;
};

/* The same on both sides of each edge. */
std::vector<float> drawRates(Draws& draws) {
  const auto vertex = [](int x, int y) { return y * (cageQuads + 1) + x; };
  std::map<std::pair<int, int>, float> rateOf;
  std::vector<float> rates;
  for (int y = 0; y < cageQuads; y++)
    for (int x = 0; x < cageQuads; x++) {
      const int ring[4] = {vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)};
      for (int i = 0; i < 4; i++) {
        const auto edge = std::minmax(ring[i], ring[(i + 1) % 4]);
        const auto found = rateOf.find(edge);
        rates.push_back(found != rateOf.end() ? found->second : rateOf[edge] = float(1 + draws.index(32)));
      }
    }
  return rates;
}

DisplacedSheet drawSheet(Draws& draws) {
  DisplacedSheet sheet;
  sheet.level = 2 + draws.index(5);
  sheet.frameLevel = draws.index(sheet.level + 1);
  sheet.amplitude = draws.magnitude(0.03, 5);
  sheet.sideways = draws.index(2) ? draws.uniform(0, 0.6) : 0;
  sheet.frequency = draws.magnitude(0.35, 1.6);
  const int rates = draws.index(8); // 6 of 8 sheets have a power of two as rate
  sheet.rate = rates == 0 ? float(1 + draws.index(40)) : float(1 << sheet.level);
  if (rates == 1) sheet.rates = drawRates(draws);
  return sheet;
}

void displace(const RTCDisplacementFunctionNArguments* args) {
  const DisplacedSheet& sheet = *(const DisplacedSheet*)args->geometryUserPtr;
  const double q = sheet.quad(), f = 0.15 / q * sheet.frequency;
  for (unsigned i = 0; i < args->N; i++) {
    const double x = args->P_x[i], y = args->P_y[i];
    const auto waves = [&](int k) {
      return (std::sin(2 * pi * f * x + 3.1 * f * y + 1.3 * k) + std::sin(5.7 * f * y - 2.3 * f * x + 2.1 * k) +
              std::sin(9.1 * f * (x + y) + 0.7 * k)) /
             3;
    };
    args->P_z[i] += float(sheet.amplitude * q * waves(0));
    args->P_x[i] += float(sheet.sideways * q * waves(1));
    args->P_y[i] += float(sheet.sideways * q * waves(2));
  }
}

bool isHit(const RTCRayHit& ray) { return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

/* From above the sheet to below it, or the opposite. */
Ray drawRay(Draws& draws, const RTCBounds& bounds) {
  const double height = bounds.upper_z - bounds.lower_z + 0.02;
  while (true) {
    const double slope = draws.magnitude(0.03, 3);
    double above = bounds.upper_z + height * draws.uniform(0.01, 1);
    double below = bounds.lower_z - height * draws.uniform(0.01, 1);
    if (above - below > slope * maxCoordinate) // too long for the sheet
    {
      above = bounds.upper_z + 1e-3;
      below = bounds.lower_z - 1e-3;
    }
    const double length = std::min((above - below) / slope, 1.7 * maxCoordinate), angle = draws.uniform(0, 2 * pi);
    const double x = draws.uniform(-maxCoordinate, maxCoordinate), y = draws.uniform(-maxCoordinate, maxCoordinate);
    const double dx = length * std::cos(angle), dy = length * std::sin(angle);
    if (std::fabs(x + dx) > maxCoordinate || std::fabs(y + dy) > maxCoordinate) continue;
    const bool down = draws.index(2);
    const Vec3f begin{float(x), float(y), float(down ? above : below)};
    return Ray{begin, 0.0f, {float(dx), float(dy), float(down ? below - above : above - below)}, INFINITY};
  }
}

int octant(const Ray& ray) { return (ray.direction.x < 0) + 2 * (ray.direction.y < 0) + 4 * (ray.direction.z < 0); }

class SheetScene {
public:
  SheetScene(RTCDevice device, const DisplacedSheet& sheet, RTCCompression compression)
    : scene(commitSheet(device, sheet, compression)) {}
  ~SheetScene() { rtcReleaseScene(scene); }
  SheetScene(const SheetScene&) = delete;
  SheetScene& operator=(const SheetScene&) = delete;
  operator RTCScene() const { return scene; }

private:
  RTCScene scene;
};

std::string describe(const DisplacedSheet& sheet, const Ray& r, bool closest, bool any) {
  char text[300];
  std::snprintf(text, sizeof(text), "%s, ray (%.9g, %.9g, %.9g), (%.9g, %.9g, %.9g): %s%s", sheet.describe().c_str(),
                r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z,
                closest ? "" : "closest ", any ? "" : "any");
  return text;
}

} // namespace

std::string DisplacedSheet::describe() const {
  char text[200];
  std::snprintf(text, sizeof(text), "level %d, n %d, rate %g%s, amplitude %.9g, sideways %.9g, frequency %.9g", level,
                frameLevel, rate, rates.empty() ? "" : " (mixed)", amplitude, sideways, frequency);
  return text;
}

RTCScene commitSheet(RTCDevice device, const DisplacedSheet& sheet, RTCCompression compression) {
  constexpr int n = cageQuads + 1;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  const auto newBuffer = [&](RTCBufferType type, RTCFormat format, size_t bytes, size_t count) {
    return rtcSetNewGeometryBuffer(geometry, type, 0, format, bytes, count);
  };
  float* p = (float*)newBuffer(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), n * n);
  for (int i = 0; i < n * n; i++) {
    *p++ = 2.0f * float(i % n) / cageQuads - 1;
    *p++ = 2.0f * float(i / n) / cageQuads - 1;
    *p++ = 0;
  }
  constexpr int faces = cageQuads * cageQuads;
  unsigned* face = (unsigned*)newBuffer(RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, sizeof(unsigned), faces);
  unsigned* index = (unsigned*)newBuffer(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, sizeof(unsigned), 4 * faces);
  for (int i = 0; i < faces; i++) {
    const unsigned first = unsigned((i / cageQuads) * n + i % cageQuads);
    *face++ = 4;
    for (unsigned v : {first, first + 1, first + n + 1, first + n}) *index++ = v;
  }
  if (!sheet.rates.empty()) {
    float* rate = (float*)newBuffer(RTC_BUFFER_TYPE_LEVEL, RTC_FORMAT_FLOAT, sizeof(float), sheet.rates.size());
    std::copy(sheet.rates.begin(), sheet.rates.end(), rate);
  }
  rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
  rtcSetGeometryTessellationRate(geometry, sheet.rate);
  rtcSetGeometryUserData(geometry, (void*)&sheet);
  rtcSetGeometryDisplacementFunction(geometry, displace);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = compression;
  args.frameLevel = sheet.frameLevel;
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  RTCScene scene = rtcNewScene(device);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

SheetCrossings crossSheets(RTCDevice device, RTCCompression compression, const SheetSettings& settings,
                           unsigned threads) {
  const std::shared_ptr<void> open = keepTraceDeviceOpen(settings.device);
  SheetCrossings all;
  Draws draws(settings.seed);
  std::mutex mutex;
  while (all.rays < settings.rays) {
    const size_t rays = std::min(settings.raysPerSheet, settings.rays - all.rays);
    const DisplacedSheet sheet = drawSheet(draws);
    const SheetScene grid(device, sheet, RTC_COMPRESSION_NONE), scene(device, sheet, compression);
    RTCBounds bounds, own;
    rtcGetSceneBounds(grid, &bounds);
    rtcGetSceneBounds(scene, &own);
    bounds.lower_z = std::min(bounds.lower_z, own.lower_z);
    bounds.upper_z = std::max(bounds.upper_z, own.upper_z);
    const std::unique_ptr<SceneTracer> tracer =
        settings.packets ? std::make_unique<PacketTracer>(scene) : makeTracer(settings.device, scene);
    const uint64_t seed = (uint64_t(settings.seed) << 40) + (uint64_t(all.sheets) << 20);
    parallelFor(rays, raysPerChunk, threads, [&](size_t begin, size_t end) {
      Draws rayDraws(seed + begin);
      std::vector<Ray> drawn;
      std::vector<RTCRayHit> closestHits(end - begin);
      std::vector<RTCRay> anyHits(end - begin);
      for (size_t i = 0; i < end - begin; i++) drawn.push_back(drawRay(rayDraws, bounds));
      std::stable_sort(drawn.begin(), drawn.end(), [](const Ray& a, const Ray& b) { return octant(a) < octant(b); });
      for (size_t i = 0; i < end - begin; i++) {
        load(drawn[i], closestHits[i]);
        load(drawn[i], anyHits[i]);
      }
      tracer->intersect(closestHits.data(), drawn.size());
      tracer->occluded(anyHits.data(), drawn.size());
      SheetCrossings found;
      for (size_t i = 0; i < drawn.size(); i++) {
        const Ray& ray = drawn[i];
        const bool closest = isHit(closestHits[i]), any = anyHits[i].tfar < 0;
        if (closest && any) continue;
        RTCRayHit inGrid;
        load(ray, inGrid);
        EmbreeTracer(grid).intersect(&inGrid, 1);
        if (!isHit(inGrid)) {
          found.gridMisses++;
          continue;
        }
        found.closest += !closest;
        found.any += !any;
        found.examples.push_back(describe(sheet, ray, closest, any));
      }
      std::lock_guard<std::mutex> lock(mutex);
      all.closest += found.closest;
      all.any += found.any;
      all.gridMisses += found.gridMisses;
      for (std::string& example : found.examples)
        if (all.examples.size() < all.maxExamples) all.examples.push_back(std::move(example));
    });
    all.sheets++;
    all.rays += rays;
  }
  return all;
}

} // namespace programs
