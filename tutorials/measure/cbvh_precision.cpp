// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares each precision of cVERT with Embree's own kernel: memory, commits and rays, and how far vertices move. */

#include "building/diced_surface.h"
#include "building/subdivision_geometry.h"
#include "building/surface_handles.h"
#include "measure/interleaved_speed.h"
#include "measure/quantiles.h"
#include "programs/command_line.h"
#include "programs/compared_scenes.h"
#include "programs/run_program.h"
#include "timed_build.h"
#include "scenes/motion.h"
#include "scenes/noise.h"

#include <CLI/CLI.hpp>
#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <array>
#include <cstdio>
#include <string>
#include <tuple>
#include <vector>

namespace programs { namespace {

struct Options {
  ComparedScenes compared;
  std::vector<std::string> sources{"terrain", "national", "scan", "model", "cage"};
  std::vector<std::string> inputs{"grids", "triangles"};
  std::string motion = "bend"; // of models and cages
  std::vector<int> steps{1, 2};
  std::vector<int> divisors; // of the median edge; empty: one that suits the source
  std::string form = "ctile";
  int sheetQuads = 1536; // per side of a sheet
  int gridQuads = 512;   // per side of a grid
};

// --- sources --------------------------------------------------------------------------------------

struct Source {
  std::string name;
  size_t numQuads = 0;
  unsigned steps = 1;
  bool isCage = false;
  Model model; // for the camera
  PrepareGeometry prepare;
};

struct Diced {
  std::vector<std::vector<Vec3f>> steps; // vertices
  std::vector<RTCGrid> grids;            // empty for a mesh
  std::vector<std::array<unsigned, 4>> quads;
};

template<typename T>
void fill(EmbreeDevice& device, RTCGeometry geometry, RTCBufferType type, RTCFormat format,
          const std::vector<T>& values, unsigned slot = 0) {
  void* const data = rtcSetNewGeometryBuffer(geometry, type, slot, format, sizeof(T), values.size());
  device.check("allocating a buffer");
  std::copy(values.begin(), values.end(), static_cast<T*>(data));
}

/* `input` is "grids", "quads", "triangles", or "irregular": triangles with random diagonals, which form no grids. */
GeometryHandle makeGeometry(EmbreeDevice& device, const Diced& diced, const std::string& input) {
  const RTCGeometryType type = input == "grids"   ? RTC_GEOMETRY_TYPE_GRID
                               : input == "quads" ? RTC_GEOMETRY_TYPE_QUAD
                                                  : RTC_GEOMETRY_TYPE_TRIANGLE;
  GeometryHandle geometry(rtcNewGeometry(device.handle(), type));
  rtcSetGeometryTimeStepCount(geometry.get(), unsigned(diced.steps.size()));
  for (unsigned i = 0; i < diced.steps.size(); i++)
    fill(device, geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, diced.steps[i], i);
  if (type == RTC_GEOMETRY_TYPE_GRID) fill(device, geometry.get(), RTC_BUFFER_TYPE_GRID, RTC_FORMAT_GRID, diced.grids);
  else if (type == RTC_GEOMETRY_TYPE_QUAD)
    fill(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4, diced.quads);
  else {
    std::vector<std::array<unsigned, 3>> triangles;
    for (const auto& q : diced.quads) {
      const bool isOther = input == "irregular" && hashCell(int(triangles.size()), 0, 0, 3) & 1;
      triangles.push_back({q[0], q[1], q[isOther ? 2 : 3]});
      triangles.push_back({q[isOther ? 0 : 1], q[2], q[3]});
    }
    fill(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
  }
  return geometry;
}

std::string motionLabel(unsigned steps) { return steps > 1 ? ", " + std::to_string(steps) + " time steps" : ""; }

/* `diced` must outlive the source. */
Source sourceOf(const std::string& name, const Diced& diced, const std::string& input, size_t numQuads) {
  Source source;
  source.name = name + ", " + input + motionLabel(unsigned(diced.steps.size()));
  source.numQuads = numQuads;
  source.steps = unsigned(diced.steps.size());
  source.prepare = [&diced, input](EmbreeDevice& device) { return commitOf(makeGeometry(device, diced, input)); };
  return source;
}

/* side x side quads, both as grids and as a mesh. */
template<typename Place>
Diced dicedSheet(const Options& options, unsigned steps, const Place& place) {
  const unsigned side = unsigned(options.sheetQuads), tile = unsigned(options.gridQuads), width = side + 1;
  Diced diced;
  for (unsigned step = 0; step < steps; step++) {
    diced.steps.emplace_back();
    for (unsigned y = 0; y <= side; y++)
      for (unsigned x = 0; x <= side; x++) diced.steps.back().push_back(place(int(x), int(y), step));
  }
  for (unsigned y = 0; y < side; y += tile)
    for (unsigned x = 0; x < side; x += tile) {
      const unsigned w = std::min(tile, side - x) + 1, h = std::min(tile, side - y) + 1;
      diced.grids.push_back({y * width + x, width, static_cast<unsigned short>(w), static_cast<unsigned short>(h)});
    }
  for (unsigned y = 0; y < side; y++)
    for (unsigned x = 0; x < side; x++) {
      const unsigned a = y * width + x;
      diced.quads.push_back({a, a + 1, a + width + 1, a + width});
    }
  return diced;
}

/* Octaves from `wave` quads down to 4, each half as high as the previous one. */
double fractalNoise(double x, double y, double z, double wave) {
  double sum = 0, amplitude = 1;
  for (uint32_t octave = 0; wave >= 4; octave++, wave /= 2, amplitude /= 2)
    sum += amplitude * double(gradientNoise({float(x / wave), float(y / wave), float(z)}, octave));
  return sum;
}

/* Hills of up to about 100 m, well above sea level, because floats near 0 have finer steps. */
Vec3f terrainAt(Vec3d corner, double cell, int x, int y) {
  return {float(corner.x + cell * x), float(corner.y + cell * y), float(corner.z + 100 * fractalNoise(x, y, 0.5, 256))};
}

/* A depth image in meters: 2 m away, a field of view of 53 degrees, white noise with a standard deviation of a tenth of
 * a quad. Each time step moves the surface and has new noise. */
Vec3f scannedAt(int side, int x, int y, unsigned step) {
  const double pixel = 1.0 / side, edge = 2 * pixel, u = (x - 0.5 * side) * pixel, v = (y - 0.5 * side) * pixel;
  double sum = 0; // of 4 uniform numbers in [0,1): almost normally distributed
  for (uint32_t i = 0; i < 4; i++) sum += double(hashCell(x, y, int(step), 7 + i) >> 8) * 0x1p-24;
  const double noise = (sum - 2) * std::sqrt(3.0) * 0.1 * edge;
  const double depth = 2 + 0.2 * fractalNoise(x, y, 0.5 + 0.2 * step, 0.25 * side) + noise;
  return {float(u * depth), float(v * depth), float(depth)};
}

/* Every 64th vertex at all time steps, for fitting a camera. */
Model outlineOf(const std::string& name, const Diced& diced, ViewHints view) {
  Model model;
  model.name = name;
  model.view = view;
  for (const auto& vertices : diced.steps)
    for (size_t i = 0; i < vertices.size(); i += 64) model.cage.positions.push_back(vertices[i]);
  return model;
}

template<typename Measure>
void forEachSheet(const Options& options, const std::string& name, unsigned steps, const Measure& measure) {
  Diced diced;
  ViewHints view;
  if (name == "scan") {
    diced = dicedSheet(options, steps,
                       [&](int x, int y, unsigned step) { return scannedAt(options.sheetQuads, x, y, step); });
    view.direction = {0.2f, 0.1f, 1};
  } else {
    const bool isNational = name == "national";
    diced = dicedSheet(options, 1, [&](int x, int y, unsigned) {
      return isNational ? terrainAt({4.5e6, 5.4e6, 300}, 1, x, y) : terrainAt({0, 0, 300}, 2, x, y);
    });
    view.direction = {0.5f, 0.7f, -0.6f};
    view.up = {0, 0, 1};
  }
  for (const std::string& input : options.inputs) {
    Source source = sourceOf(name, diced, input, diced.quads.size());
    source.model = outlineOf(name, diced, view);
    measure(source);
  }
}

/* Merges shared vertices. */
template<typename Measure>
void forEachDicedModel(const Options& options, const Model& model, const Measure& measure) {
  BuildSettings settings;
  settings.level = options.compared.level;
  Diced diced;
  for (size_t step = 0; step <= model.poses.size(); step++) {
    Model posed = model;
    posed.poses.clear();
    if (step) posed.cage.positions = model.poses[step - 1];
    QuadMesh mesh = DicedSurface(posed, settings).mesh(DicedInput::Rows);
    diced.steps.push_back(std::move(mesh.vertices));
    diced.quads = std::move(mesh.quads);
  }
  for (const std::string& input : options.inputs) {
    if (input == "grids") continue; // merged vertices are not in rows, as grids require
    Source source = sourceOf(model.name, diced, input, diced.quads.size());
    source.model = model;
    measure(source);
  }
}

Source cageOf(const Options& options, const Model& model) {
  Source source;
  source.name = model.name + ", cage" + motionLabel(1 + unsigned(model.poses.size()));
  source.numQuads = model.layout(options.compared.level).numQuads();
  source.steps = 1 + unsigned(model.poses.size());
  source.isCage = true;
  source.model = model;
  source.prepare = prepareCage(model, options.compared.level);
  return source;
}

// --- measurements ------------------------------------------------------------------------------

class Built : public TimedBuild {
public:
  Built(const Source& source, const ComparedScenes& compared, RTCCompression compression, float maxError)
    : TimedBuild(source.prepare, compared, compression, maxError) {
    const bool compresses = compression != RTC_COMPRESSION_NONE;
    if (compresses != (statistics.numQuads == source.numQuads))
      throw Error(source.name + ": " + std::to_string(statistics.numQuads) + " of " + std::to_string(source.numQuads) +
                  " quads are compressed: expected " + (compresses ? "all" : "none"));
  }

  /* All stored vertices at all time steps, in the same order for each precision. */
  std::vector<Vec3f> vertices(unsigned steps) {
    std::vector<Vec3f> all;
    for (unsigned i = 0; i < steps; i++) {
      std::vector<Part> parts;
      cbvhForEachPart(surfaceOf(geometry.get()).get(), steps > 1 ? float(i) / float(steps - 1) : 0, add, &parts);
      std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.name < b.name; });
      for (const Part& part : parts) all.insert(all.end(), part.vertices.begin(), part.vertices.end());
    }
    device.check("reading vertices");
    return all;
  }

private:
  /* Primitive and parameters of the first vertex. */
  using PartName = std::tuple<unsigned, float, float>;
  struct Part {
    PartName name;
    std::vector<Vec3f> vertices;
  };

  static int add(void* out, const CbvhPart* part) {
    const bool isMesh = part->primitivesPerQuad > 0;
    Part copy;
    copy.name =
        isMesh ? PartName{part->primIDs[0], 0, 0} : PartName{part->primID, part->parameters[0], part->parameters[1]};
    const float* p = part->vertices;
    for (unsigned i = 0; i < part->width * part->height; i++, p += 3) copy.vertices.push_back({p[0], p[1], p[2]});
    static_cast<std::vector<Part>*>(out)->push_back(std::move(copy));
    return true;
  }
};

/* Along u. Includes distances between ends of rows, which are few. */
double medianEdge(Built& built) {
  std::vector<float> edges;
  const std::vector<Vec3f> vertices = built.vertices(1);
  for (size_t i = 1; i < vertices.size(); i++) edges.push_back(length(vertices[i] - vertices[i - 1]));
  return quantile(edges, 0.5);
}

void printSpread(std::vector<double> values) {
  std::printf(" %.2f ±%.2f |", median(values), 0.5 * interquartileRange(values));
}

void measure(const Options& options, const Source& source) {
  const ComparedScenes& compared = options.compared;
  const RTCCompression form = options.form == "ctile" ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT;
  Built embree(source, compared, RTC_COMPRESSION_NONE, -1), exact(source, compared, form, 0);
  const std::vector<Vec3f> expected = exact.vertices(source.steps);
  const double edge = medianEdge(exact), quads = double(source.numQuads);
  const PictureRays picture(source.model, embree.handle(), compared.size, source.steps > 1);
  std::vector<std::pair<std::string, double>> precisions;
  for (int divisor : options.divisors.empty() ? std::vector<int>{source.isCage ? 512 : 36} : options.divisors)
    precisions.push_back({"1/" + std::to_string(divisor), edge / divisor});
  precisions.push_back({"default", -1});
  precisions.push_back({"lossless", 0});
  for (const auto& precision : precisions) {
    std::unique_ptr<Built> other;
    if (precision.second != 0) other = std::make_unique<Built>(source, compared, form, float(precision.second));
    Built& built = other ? *other : exact;
    std::printf("| %s | %.2f | %s | %.1f | %.2f |", source.name.c_str(), quads * 1e-6, precision.first.c_str(),
                double(embree.bytes) / quads, double(built.bytes) / quads);
    const std::pair<TimedQuery, const std::vector<RTCRayHit>&> sets[] = {{TimedQuery::Single, picture.primary},
                                                                         {TimedQuery::Single, picture.bounces},
                                                                         {TimedQuery::AnyHit, picture.bounces}};
    {
      const FlushDenormals fast;
      std::vector<RTCRayHit> hits[2];
      for (const auto& set : sets)
        printSpread(interleavedSpeedups(embree.handle(), built.handle(), set.second, set.first, compared.repeat, hits));
    }
    std::vector<double> times;
    for (double seconds : built.processorSeconds) times.push_back(seconds / median(embree.processorSeconds));
    printSpread(times);
    const std::vector<Vec3f> found = built.vertices(source.steps);
    if (found.size() != expected.size())
      throw Error(source.name + ": " + std::to_string(found.size()) + " vertices: expected " +
                  std::to_string(expected.size()) + ", as with lossless precision");
    std::vector<float> moved;
    for (size_t i = 0; i < found.size(); i++) moved.push_back(float(double(length(found[i] - expected[i])) / edge));
    const double p99 = quantile(moved, 0.99), most = quantile(moved, 1);
    std::printf(" %.5f | %.5f |\n", p99, most);
    std::fflush(stdout);
  }
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Compares precisions of cVERT with Embree's own kernel for the same geometry. Prints bytes per quad, "
               "without the application's buffers; the speed of rays and the processor time of commits in multiples of "
               "Embree's, as medians and half of their interquartile ranges; and how far vertices move, in median "
               "edges: the 99th percentile and the maximum.",
               "cbvh_precision");
  options.compared.scenes = {"trex"};
  options.compared.level = 5;
  options.compared.addOptions(app);
  app.add_option("--source", options.sources,
                 "comma-separated list: terrain, a raster with cells of 2 m; national, a raster with cells of 1 m at "
                 "(4.5e6, 5.4e6); scan, a noisy depth image; model, a diced --scene; cage, a --scene")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(CLI::IsMember({"terrain", "national", "scan", "model", "cage"}))
      ->capture_default_str();
  app.add_option(
         "--input", options.inputs,
         "comma-separated list of geometry types for diced sources: grids; quads; triangles; irregular, triangles that "
         "cut quads along random diagonals; models have no grids")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(CLI::IsMember({"grids", "quads", "triangles", "irregular"}))
      ->capture_default_str();
  app.add_option("--steps", options.steps, "comma-separated list of numbers of time steps; terrains do not move")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(CLI::Range(1, 129))
      ->capture_default_str();
  app.add_option("--form", options.form, "how vertices are stored: ctile or cvert")
      ->type_name("NAME")
      ->check(CLI::IsMember({"ctile", "cvert"}))
      ->capture_default_str();
  app.add_option("--motion", options.motion, "motion of models and cages: turn, bend, twist, walk")
      ->type_name("NAME")
      ->capture_default_str();
  app.add_option(
         "--divisor", options.divisors,
         "comma-separated list of N: lattice spacings to measure besides the default and lossless, at most 1/N of the "
         "median edge each (default: 36; cages: 512)")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--quads-per-side", options.sheetQuads, "quads per side of terrains and scans")
      ->type_name("N")
      ->check(CLI::Range(16, 30000))
      ->capture_default_str();
  if (!parseCommandLine(app, argc, argv)) return 0;
  options.compared.validate();
  for (int steps : options.steps)
    if (steps > 1) validateMotion({options.motion, steps});
  std::printf("| source | million quads | precision | Embree, bytes | cVERT | coherent | incoherent | any hit "
              "| build | moved, p99 | largest |\n"
              "|:--|--:|:--|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  const auto measured = [&](const Source& source) { measure(options, source); };
  for (const std::string& source : options.sources)
    for (int steps : options.steps) {
      const bool isTerrain = source == "terrain" || source == "national";
      if (isTerrain && steps > 1) continue;
      if (isTerrain || source == "scan") {
        forEachSheet(options, source, unsigned(steps), measured);
        continue;
      }
      options.compared.forEach([&](Model& model) {
        if (steps > 1) {
          MotionSettings motion;
          motion.name = options.motion;
          motion.steps = steps;
          addMotion(model, motion);
        }
        if (source == "cage") measured(cageOf(options, model));
        else forEachDicedModel(options, model, measured);
      });
    }
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  return programs::runProgram("cbvh_precision", [=] { return programs::run(argc, argv); });
}
