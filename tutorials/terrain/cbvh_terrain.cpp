// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sky-view factors of an elevation raster. An example for more geometry than memory: one surface per tile, whose
 * vertices are then freed, and one group of all tiles. */

#include "elevation.h"
#include "embree_terrain.h"
#include "options.h"
#include "terrain_space.h"
#include "basics/error.h"
#include "basics/image_file.h"
#include "basics/input_files.h"
#include "basics/parallel.h"
#include "basics/seconds.h"
#include "basics/text.h"
#include "programs/run_program.h"
#include "programs/warnings.h"

#include <sys/resource.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace programs { namespace {

void check(CbvhError error) {
  if (error != CBVH_OK) throw Error(std::string("libembree_cbvh: ") + cbvhGetErrorText());
}

class CompressedTerrain {
public:
  /* spacing: of the lattice that contains all vertices, or 0. */
  CompressedTerrain(int threads, float spacing) {
    check(cbvhNewContext(("threads=" + std::to_string(threads)).c_str(), nullptr, nullptr, &context));
    /* All tiles use the same spacing, so that shared vertices are the same floats. The default depends on each grid's
     * quads and would leave cracks. */
    accuracy.maxError = spacing;
  }
  ~CompressedTerrain() {
    cbvhReleaseGroup(group);
    for (CbvhSurface surface : surfaces) cbvhReleaseSurface(surface);
    cbvhReleaseContext(context);
  }
  CompressedTerrain(const CompressedTerrain&) = delete;
  CompressedTerrain& operator=(const CompressedTerrain&) = delete;

  /* Vertices may be freed afterwards. */
  void add(const TerrainTile& tile) {
    surfaces.push_back(nullptr);
    check(cbvhNewSurface(context, &surfaces.back()));
    if (accuracy.maxError > 0) check(cbvhSetSurfaceAccuracy(surfaces.back(), &accuracy));
    else check(cbvhSetSurfaceLossless(surfaces.back(), 1));
    const CbvhGrid grid = {0, unsigned(tile.width), (unsigned short)tile.width, (unsigned short)tile.height};
    const float* const steps[1] = {&tile.vertices[0].x};
    CbvhGrids grids = CbvhGrids();
    grids.numGrids = 1;
    grids.grids = &grid;
    grids.vertices = {tile.vertices.size() - 1, sizeof(Vec3f), steps, 1, 0, 0};
    check(cbvhSetSurfaceGrids(surfaces.back(), &grids));
    check(cbvhCommitSurface(surfaces.back(), nullptr, nullptr));
  }

  void commit() {
    check(cbvhNewGroup(context, surfaces.data(), surfaces.size(), &group));
    check(cbvhCommitGroup(group));
    check(cbvhGetGroupStatistics(group, &statistics));
  }

  bool isOccluded(CbvhRay ray) const { return cbvhOccluded1(group, &ray, nullptr) != 0; }
  size_t bytes() const { return statistics.bytes; }
  size_t numQuads() const { return statistics.numQuads; }
  float maxDeviation() const { return statistics.maxVertexDeviation; }

private:
  CbvhContext context = nullptr;
  std::vector<CbvhSurface> surfaces;
  CbvhGroup group = nullptr;
  CbvhAccuracy accuracy{};
  CbvhGroupStatistics statistics{};
};

/* Returns the largest distance by which a vertex moved. */
template<typename Terrain>
float build(const Options& options, Elevation& elevation, const TerrainSpace& space, Terrain& terrain) {
  Phase phase("building tiles");
  float moved = 0;
  for (int y0 = 0; y0 < elevation.height() - 1; y0 += options.tile)
    for (int x0 = 0; x0 < elevation.width() - 1; x0 += options.tile) {
      throwIfCanceled();
      const TerrainTile tile = makeTile(options, elevation, space, x0, y0);
      moved = std::max(moved, tile.moved);
      terrain.add(tile);
      phase.update((double(y0) + double(x0) / elevation.width() * options.tile) / elevation.height());
    }
  terrain.commit();
  return std::max(moved, terrain.maxDeviation());
}

/* Fraction of a horizontal surface's diffuse light that comes from the sky: the mean of cos^2 of the horizon's
 * elevation over all azimuths. Terrain without overhangs occludes every ray below the horizon. */
template<typename Terrain>
float skyViewFactor(const Options& options, const TerrainSpace& space, const Terrain& terrain, Vec3f from,
                    size_t& rays) {
  double sum = 0;
  for (int i = 0; i < options.azimuths; i++) {
    // + 0.5, because rays along an axis would lie in the plane of a tile's border (if azimuths is a multiple of 4)
    const double azimuth = 2 * M_PI * (i + 0.5) / options.azimuths;
    const auto isOccluded = [&](double degrees) {
      rays++;
      const Vec3f direction = space.direction(azimuth, degrees * M_PI / 180);
      CbvhRay ray{};
      ray.org_x = from.x;
      ray.org_y = from.y;
      ray.org_z = from.z;
      ray.dir_x = direction.x;
      ray.dir_y = direction.y;
      ray.dir_z = direction.z;
      ray.tfar = INFINITY;
      ray.mask = ~0u;
      return terrain.isOccluded(ray);
    };
    double low = 0, high = isOccluded(0) ? 90 : 0;
    while (high - low > options.accuracy) {
      const double middle = (low + high) / 2;
      (isOccluded(middle) ? low : high) = middle;
    }
    const double cosine = std::cos((low + high) / 2 * M_PI / 180);
    sum += cosine * cosine;
  }
  return float(sum / options.azimuths);
}

/* Warns if floats are so coarse at the samples' heights that rays cannot start at options.startHeight. */
void warnIfRaised(const Options& options, const TerrainSpace& space, const std::vector<float>& heights) {
  float most = 0;
  for (float height : heights)
    if (std::isfinite(height)) most = std::max(most, space.rayHeight(height) - space.storedHeight(height));
  if (options.startHeight > 0 && most > 2 * options.startHeight)
    printWarnings("cbvh_terrain", "rays start up to " + shortNumber(most) +
                                      " above the surface instead of "
                                      "--start-height " +
                                      shortNumber(options.startHeight) + ": floats are too coarse at these heights");
}

/* tags: of a GeoTIFF of the written samples. */
void writeFactors(const Options& options, int w, int h, const std::vector<float>& factors, const GeoTags& tags) {
  const std::string extension = lowerCase(std::filesystem::path(options.output).extension().string());
  if (extension == ".tif" || extension == ".tiff") {
    RasterSamples samples;
    samples.width = size_t(w);
    samples.height = size_t(h);
    samples.data = factors.data();
    writeGeoTiff(options.output, samples, tags);
    return;
  }
  const bool isPng = extension == ".png" || extension.empty();
  const OIIO::ImageSpec spec(w, h, 1, isPng ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::FLOAT);
  writeImageFile(options.output, spec, OIIO::TypeDesc::FLOAT, factors.data());
}

template<typename Terrain>
void measure(const Options& options, Elevation& elevation, const TerrainSpace& space, Terrain& terrain) {
  float moved = 0;
  const double buildSeconds = secondsOf([&] { moved = build(options, elevation, space, terrain); });
  if (terrain.numQuads() == 0)
    throw Error(options.elevation.path + ": no quad has four valid samples: expected heights that are neither "
                                         "missing nor huge");
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const double quads = double(terrain.numQuads()), mebibyte = 1 << 20;
  std::printf("%d x %d samples, %.2f million quads: built in %.1f s, %.1f MiB, %.2f bytes per quad, "
              "peak of the process %.1f MiB\nlargest distance by which a vertex moved: %g\n",
              elevation.width(), elevation.height(), quads * 1e-6, buildSeconds, double(terrain.bytes()) / mebibyte,
              double(terrain.bytes()) / quads, double(usage.ru_maxrss) / 1024, double(moved));
  std::fflush(stdout);

  const int x0 = options.crop[0], y0 = options.crop[1], w = options.crop[2] - x0, h = options.crop[3] - y0;
  const std::vector<float> heights = elevation.heights(x0, y0, w, h, threadCount(options.threads));
  warnIfRaised(options, space, heights);
  std::vector<float> factors(heights.size());
  std::atomic<size_t> rays{0}, done{0};
  const double seconds = secondsOf([&] {
    Phase phase("tracing horizons", Phase::PercentAndTimeLeft);
    parallelFor(factors.size(), 64, threadCount(options.threads), [&](size_t begin, size_t end) {
      size_t traced = 0;
      for (size_t i = begin; i < end; i++) {
        const int x = x0 + int(i % size_t(w)), y = y0 + int(i / size_t(w));
        const Vec3f from = space.rayStart(x, y, heights[i]);
        factors[i] = std::isfinite(from.z) ? skyViewFactor(options, space, terrain, from, traced) : NAN;
      }
      rays += traced;
      phase.update(double(done += end - begin) / double(factors.size()));
    });
  });
  double sum = 0;
  size_t valid = 0;
  for (float factor : factors)
    if (std::isfinite(factor)) sum += double(factor), valid++;
  const double million = double(rays) * 1e-6;
  std::printf("%d x %d cells with %d azimuths: %.1f million rays in %.1f s, %.2f million per second; "
              "mean sky-view factor %.4f\n",
              w, h, options.azimuths, million, seconds, million / seconds, valid ? sum / double(valid) : NAN);
  writeFactors(options, w, h, factors, elevation.geoTags(x0, y0));
}

int run(int argc, char** argv) {
  Options options;
  if (!parseOptions(options, argc, argv)) return 0;
  installCancelHandler();
  Elevation elevation(options.elevation);
  requireNoInputFile(options.output);
  setCrop(options, elevation);
  const TerrainSpace space(options, elevation.height());
  if (options.embree.empty())
    measure(options, elevation, space, *std::make_unique<CompressedTerrain>(options.threads, space.spacing()));
  else measure(options, elevation, space, *std::make_unique<EmbreeTerrain>(options.embree));
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_terrain", [=] { return programs::run(argc, argv); });
}
