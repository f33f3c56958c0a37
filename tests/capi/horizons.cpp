// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Finds horizons of elevation models: any-hit rays start 0.01 m above the grid's vertices and rise until they miss. The
 * default accuracy must suffice: a stored vertex above its ray's start would hide the whole sky. The same rays through
 * the exact triangles, in Embree's robust mode, give the expected horizons.
 *
 *   capi_horizons [--max-error E] [--searches N]
 *
 * Prints a line per terrain. E is maxError of cbvhSetSurfaceAccuracy, 0 for the default. */

#include "host.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

using namespace host;

namespace {

constexpr double cell = 2;           // meters
constexpr float startHeight = 0.01f; // of rays above vertices, meters
constexpr double lowest = -20;       // elevation at which searches begin, degrees
constexpr double step = 0.25;        // step of the discrete search, degrees
constexpr double binaryStep = 0.01;  // resolution of the binary search, degrees
// tolerance of horizons in most searches, degrees: one step of the discrete search
constexpr double agreement = 0.25;
constexpr double shareThatAgrees = 0.999;
// tolerance in any search, degrees: a ray may miss a summit that is one cell wide
constexpr double mostDifference = 2;

// --- the terrain ------------------------------------------------------------------------------

// Values between -1 and 1 at integer positions.
double valueAt(int x, int y, unsigned octave) {
  unsigned h = unsigned(x) * 73856093u ^ unsigned(y) * 19349663u ^ octave * 83492791u;
  h = (h ^ h >> 13) * 1274126177u;
  return double((h ^ h >> 16) & 0xffff) / 32767.5 - 1;
}

// Value noise of 7 octaves: a relief of about 60 m.
double heightAt(double x, double y) {
  double sum = 0, amplitude = 24, wave = 128;
  for (unsigned octave = 0; octave < 7; octave++, amplitude /= 2, wave /= 2) {
    const double u = x / wave, v = y / wave;
    const int i = int(std::floor(u)), j = int(std::floor(v));
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double a = smooth(u - i), b = smooth(v - j);
    sum += amplitude * ((1 - b) * ((1 - a) * valueAt(i, j, octave) + a * valueAt(i + 1, j, octave)) +
                        b * ((1 - a) * valueAt(i, j + 1, octave) + a * valueAt(i + 1, j + 1, octave)));
  }
  return sum;
}

struct Terrain {
  unsigned side;
  std::vector<Vec> vertices; // row by row

  // side x side vertices from (x0,y0) on, with heights around z0.
  Terrain(unsigned side, double x0, double y0, double z0) : side(side) {
    for (unsigned y = 0; y < side; y++)
      for (unsigned x = 0; x < side; x++)
        vertices.push_back({float(x0 + cell * x), float(y0 + cell * y), float(z0 + heightAt(x, y))});
    vertices.push_back({0, 0, 0}); // padding that may be read
  }
};

// --- the two surfaces ---------------------------------------------------------------------------

class Compressed {
public:
  Compressed(CbvhContext context, const Terrain& terrain, float maxError) {
    const CbvhGrid grid = {0, terrain.side, (unsigned short)terrain.side, (unsigned short)terrain.side};
    const float* const steps[1] = {terrain.vertices[0].data()};
    CbvhGrids grids = CbvhGrids();
    grids.numGrids = 1;
    grids.grids = &grid;
    grids.vertices = {terrain.vertices.size() - 1, sizeof(Vec), steps, 1, 0, 0};
    CbvhAccuracy accuracy = CbvhAccuracy();
    accuracy.maxError = maxError;
    CbvhSurface surface = nullptr;
    OK(cbvhNewSurface(context, &surface));
    OK(cbvhSetSurfaceAccuracy(surface, &accuracy));
    OK(cbvhSetSurfaceGrids(surface, &grids));
    OK(cbvhCommitSurface(surface, nullptr, nullptr));
    OK(cbvhNewGroup(context, &surface, 1, &group));
    OK(cbvhCommitGroup(group));
    OK(cbvhGetGroupStatistics(group, &statistics));
    cbvhReleaseSurface(surface);
  }
  ~Compressed() { cbvhReleaseGroup(group); }
  Compressed(const Compressed&) = delete;
  Compressed& operator=(const Compressed&) = delete;

  bool isOccluded(const RTCRay& ray) const {
    CbvhRay own;
    std::memcpy(&own, &ray, sizeof(own));
    return cbvhOccluded1(group, &own, nullptr) != 0;
  }

  CbvhGroupStatistics statistics = CbvhGroupStatistics();

private:
  CbvhGroup group = nullptr;
};

// Triangles with the same diagonals as grids.
class Exact {
public:
  Exact(RTCDevice device, const Terrain& terrain) : scene(rtcNewScene(device)) {
    const unsigned side = terrain.side;
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST); // otherwise rays pass between triangles
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t count = size_t(side) * side;
    void* const copy =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec), count);
    std::memcpy(copy, terrain.vertices.data(), sizeof(Vec) * count);
    unsigned* index = (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                                         2 * size_t(side - 1) * (side - 1));
    for (unsigned y = 0; y + 1 < side; y++)
      for (unsigned x = 0; x + 1 < side; x++) {
        const unsigned a = y * side + x, b = a + 1, c = a + side, d = c + 1;
        for (unsigned corner : {a, b, c, c, b, d}) *index++ = corner;
      }
    rtcSetGeometryMask(geometry, ~0u); // the default of Embree 4 is 1
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~Exact() { rtcReleaseScene(scene); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;

  bool isOccluded(RTCRay ray) const {
    occluded(scene, ray);
    return ray.tfar < 0;
  }

private:
  RTCScene scene;
};

// --- the searches -------------------------------------------------------------------------------

// True if a ray at this elevation in degrees hits.
using IsOccluded = std::function<bool(double elevation)>;

// The first elevation at which a ray misses; 90 if all hit.
double discreteSearch(const IsOccluded& isOccluded) {
  double elevation = lowest;
  while (elevation < 90 && isOccluded(elevation)) elevation += step;
  return elevation;
}

double binarySearch(const IsOccluded& isOccluded) {
  if (!isOccluded(lowest)) return lowest;
  double low = lowest, high = 90;
  while (high - low > binaryStep) {
    const double middle = (low + high) / 2;
    (isOccluded(middle) ? low : high) = middle;
  }
  return high;
}

struct Result {
  size_t unended = 0, others[2] = {0, 0}; // searches without an end, and different horizons: discrete, binary
  double most[2] = {0, 0};                // largest difference, degrees
};

template<typename Surface>
bool isOccludedAt(const Surface& surface, const Vec& from, double azimuth, double elevation) {
  const double degree = M_PI / 180;
  RTCRayHit ray =
      makeRay(from, {float(std::sin(azimuth) * std::cos(elevation * degree)),
                     float(std::cos(azimuth) * std::cos(elevation * degree)), float(std::sin(elevation * degree))});
  return surface.isOccluded(ray.ray);
}

struct Accuracy {
  float maxError;
  size_t searches;
};

void testTerrain(RTCDevice device, CbvhContext context, const Accuracy& accuracy, const Terrain& terrain) {
  const unsigned side = terrain.side;
  const size_t searches = accuracy.searches;
  const Compressed compressed(context, terrain, accuracy.maxError);
  const Exact exact(device, terrain);
  std::mt19937 random(7);
  Result result;
  for (size_t i = 0; i < searches; i++) {
    // not on the border, where the azimuth decides whether there is terrain
    const unsigned x = 1 + random() % (side - 2), y = 1 + random() % (side - 2);
    const double azimuth = 2 * M_PI * double(random() % 3600 + 0.5) / 3600;
    Vec from = terrain.vertices[y * side + x];
    from[2] += startHeight;
    const IsOccluded ours = [&](double elevation) { return isOccludedAt(compressed, from, azimuth, elevation); };
    const IsOccluded theirs = [&](double elevation) { return isOccludedAt(exact, from, azimuth, elevation); };
    const double found[2] = {discreteSearch(ours), binarySearch(ours)};
    const double expected[2] = {discreteSearch(theirs), binarySearch(theirs)};
    CHECK(expected[0] < 90);
    result.unended += found[0] >= 90;
    for (int k : {0, 1}) {
      const double difference = std::fabs(found[k] - expected[k]);
      result.others[k] += difference > agreement + 1e-9;
      result.most[k] = std::max(result.most[k], difference);
    }
  }
  const Vec& corner = terrain.vertices[0];
  std::printf("%u x %u from (%.2f, %.2f, %.2f) on: vertices moved by up to %.4f m, %.2f bytes per quad; "
              "of %zu searches %zu without an end; off by more than %.2f degrees: "
              "%zu discrete (most %.2f), %zu binary (most %.2f)\n",
              side, side, double(corner[0]), double(corner[1]), double(corner[2]),
              double(compressed.statistics.maxVertexDeviation),
              double(compressed.statistics.bytes) / double(compressed.statistics.numQuads), searches, result.unended,
              agreement, result.others[0], result.most[0], result.others[1], result.most[1]);
  CHECK(compressed.statistics.numQuads == size_t(side - 1) * (side - 1));
  CHECK(result.unended == 0);
  for (int k : {0, 1}) {
    CHECK(double(result.others[k]) <= (1 - shareThatAgrees) * double(searches));
    CHECK(result.most[k] <= mostDifference);
  }
}

} // namespace

int main(int argc, char** argv) {
  Accuracy accuracy = {0, 3000};
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--max-error") accuracy.maxError = float(std::atof(argv[i + 1]));
    if (std::string(argv[i]) == "--searches") accuracy.searches = size_t(std::atol(argv[i + 1]));
  }
  RTCDevice device = rtcNewDevice(nullptr);
  CbvhContext context = nullptr;
  OK(cbvhNewContext(nullptr, nullptr, nullptr, &context));
  testTerrain(device, context, accuracy, Terrain(300, 0, 0, 0));
  testTerrain(device, context, accuracy, Terrain(300, -300.37, -299.91, 0));
  testTerrain(device, context, accuracy, Terrain(300, 0, 0, 4000));
  testTerrain(device, context, accuracy, Terrain(1200, 0, 0, 0));
  // coordinates of Great Britain's national grid
  testTerrain(device, context, accuracy, Terrain(300, 528980, 183526, 0));
  testTerrain(device, context, accuracy, Terrain(300, 4.5e6, 5.4e6, 300)); // coordinates of Gauss-Krueger zones
  cbvhReleaseContext(context);
  rtcReleaseDevice(device);
  return conclude("horizons");
}
