// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Elevation rasters of any size, as tiles, each a surface. */

#include "classes.h"
#include "georeference.h"
#include "geometry_scene.h"
#include "interruptible.h"
#include "json_objects.h"
#include "open_files.h"
#include "terrain.h"

#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/parallel.h"
#include "basics/seconds.h"
#include "building/saved_scene.h"
#include "programs/compression_json.h"
#include "tracing/trace_batches.h"

#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

namespace programs::python {
namespace {

namespace fs = std::filesystem;

constexpr size_t tileQuads = 1024; // along a side of a tile
constexpr double defaultErrorInCells = 1.0 / 128;

/* --- tiles ----------------------------------------------------------------------- */

/* Heights of samples from a row and a column on. Neighboring tiles share the samples between them. */
class TerrainTile : public SurfaceGeometry {
public:
  TerrainTile(const Georeference& space, size_t row, size_t column)
    : space(space),
      row(row),
      column(column),
      numRows(std::min(tileQuads, space.rows - 1 - row) + 1),
      numColumns(std::min(tileQuads, space.columns - 1 - column) + 1) {
    maxError = space.spacing(); // the same in all tiles, so that shared vertices are the same floats
  }

  /* Reads the tile from anything that can be sliced as an array. Samples that equal `nodata` are missing. */
  void read(const py::object& raster, const std::optional<double>& nodata) {
    const py::object part = raster[py::make_tuple(py::slice(py::ssize_t(row), py::ssize_t(row + numRows), 1),
                                                  py::slice(py::ssize_t(column), py::ssize_t(column + numColumns), 1))];
    heights = Doubles(realNumbers(part, "heights"));
    if (shapeOf(heights) != Shape{py::ssize_t(numRows), py::ssize_t(numColumns)})
      throwValueError("heights", "returned a part of shape " + shapeText(shapeOf(heights)) + " for " +
                                     std::to_string(numRows) + " rows and " + std::to_string(numColumns) +
                                     " columns: expected as many");
    double* const h = heights.mutable_data();
    for (size_t i = 0; i < numRows * numColumns; i++) {
      if (nodata && h[i] == *nodata) h[i] = NAN;
      if (std::isinf(float(h[i])))
        throwValueError("heights", "row " + std::to_string(row + i / numColumns) + ", column " +
                                       std::to_string(column + i % numColumns) + " is " + std::to_string(h[i]) +
                                       ": expected 32-bit floats, or NaN or nodata for a missing sample");
    }
  }

  size_t numPrimitives() const override { return 1; }
  unsigned steps() const override { return 1; }
  std::string description() const override { return "tile"; }

  CbvhError setInput(CbvhSurface surface, std::vector<Vec3f>& scratch) const override {
    scratch.resize(numRows * numColumns + 1); // the library reads beyond the last vertex
    for (size_t i = 0; i < numRows * numColumns; i++)
      scratch[i] = space.vertex(row + i / numColumns, column + i % numColumns, heights.data()[i]);
    const float* const steps[1] = {&scratch[0].x};
    return setGrid(surface, numRows, numColumns, numColumns, {numRows * numColumns, sizeof(Vec3f), steps, 1, 0, 0});
  }

private:
  const Georeference& space;
  size_t row, column, numRows, numColumns;
  Doubles heights;
};

/* --- arguments --------------------------------------------------------------------- */

Vec3d readOrigin(const py::object& value) {
  const Doubles origin(realNumbers(value, "origin"));
  if (origin.ndim() != 1 || (origin.size() != 2 && origin.size() != 3))
    throwValueError("origin", "has shape " + shapeText(shapeOf(origin)) + ": expected (2,) or (3,)");
  for (py::ssize_t i = 0; i < origin.size(); i++)
    if (!std::isfinite(origin.data()[i])) throwValueError("origin", "is not finite: expected finite numbers");
  return {origin.data()[0], origin.data()[1], origin.size() == 3 ? origin.data()[2] : 0.0};
}

/* --- files: the scene, and next to it its georeference as JSON, like a world file ------------------ */

fs::path georeferencePath(fs::path path) { return path += ".json"; }

void writeGeoreference(const Georeference& s, const fs::path& path) {
  const nlohmann::ordered_json json{{"rows", s.rows},
                                    {"columns", s.columns},
                                    {"cell", {s.cellX, s.cellY}},
                                    {"origin", {s.origin.x, s.origin.y, s.origin.z}},
                                    {"max_error", s.maxError}};
  std::ofstream file(georeferencePath(path));
  file << json.dump(2) << std::endl;
  if (!file) throw Error(georeferencePath(path).string() + ": cannot be written");
}

void save(const Terrain& terrain, const fs::path& path) {
  runBuild(py::none(), [&] {
    if (const auto* built = dynamic_cast<const BuiltGeometries*>(terrain.scene.get())) built->save(path.string());
    else dynamic_cast<const SavedScene&>(*terrain.scene).save(path.string());
    writeGeoreference(terrain.space, path);
  });
}

Georeference readGeoreference(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw Error(path.string() + ": cannot be opened: expected the file that Terrain.save wrote");
  try {
    const nlohmann::json j = nlohmann::json::parse(file);
    const auto& cell = j.at("cell");
    const auto& origin = j.at("origin");
    return Georeference(j.at("rows"), j.at("columns"), cell.at(0), cell.at(1),
                        {origin.at(0), origin.at(1), origin.at(2)}, j.at("max_error"));
  } catch (const nlohmann::json::exception& e) {
    throw Error(path.string() + ": is not a georeference of Terrain.save: " + e.what());
  }
}

std::shared_ptr<Terrain> load(const fs::path& path, const std::string& representation, int threads) {
  const unsigned n = threadsOf(threads);
  const SavedScene::Form form = readForm(representation);
  return interruptibleBuild(py::none(), [&] {
    const Georeference space = readGeoreference(georeferencePath(path));
    std::unique_ptr<const SavedScene> scene = std::make_unique<SavedScene>(path.string(), n, "", form);
    const double seconds = scene->seconds();
    auto terrain = std::make_shared<Terrain>(space, std::move(scene), seconds, fs::absolute(path));
    OpenFiles<Terrain>::ofProcess().add(path, terrain);
    return terrain;
  });
}

/* For pickle. */
fs::path pickled(const Terrain& terrain) {
  if (terrain.file.empty())
    throw py::type_error(
        "the terrain is in memory and cannot be pickled: save it, and pickle what Terrain.load() returns");
  return terrain.file;
}

std::shared_ptr<Terrain> loadOnce(const fs::path& path) {
  const std::shared_ptr<Terrain> known = OpenFiles<Terrain>::ofProcess().find(path);
  return known ? known : load(path, "cvert", 0);
}

/* --- building -------------------------------------------------------------------- */

/* Receives tiles and makes a terrain of them. */
class TerrainBuilder {
public:
  virtual ~TerrainBuilder() = default;
  virtual void add(const TerrainTile& tile) = 0;
  virtual std::unique_ptr<const TracedScene> finish() = 0;
};

class MemoryBuilder : public TerrainBuilder {
public:
  MemoryBuilder(const Representation& representation, unsigned threads)
    : scene(std::make_unique<BuiltGeometries>(representation, threads, "")) {}

  void add(const TerrainTile& tile) override { scene->add(tile, "tile"); }

  std::unique_ptr<const TracedScene> finish() override {
    scene->commit();
    return std::move(scene);
  }

private:
  std::unique_ptr<BuiltGeometries> scene;
};

/* Keeps no tile in memory. */
class FileBuilder : public TerrainBuilder {
public:
  /* form: of the finished scene. */
  FileBuilder(const Georeference& space, fs::path path, SavedScene::Form form, unsigned threads)
    : space(space),
      path(std::move(path)),
      form(form),
      threads(threads),
      device(Representation{RepresentationKind::CVert}, threads, "") {
    requireNoInputFile(this->path.string());
    CbvhFileWriter made = nullptr;
    cbvhNewFileWriter(device.context().get(), this->path.c_str(), &made);
    writer.reset(made);
    device.check("saving");
  }

  void add(const TerrainTile& tile) override {
    cbvhAppendSurface(writer.get(), device.build(tile, "tile").get());
    device.check("saving");
  }

  std::unique_ptr<const TracedScene> finish() override {
    cbvhCommitFileWriter(writer.get());
    device.check("saving");
    writeGeoreference(space, path);
    return std::make_unique<SavedScene>(path.string(), threads, "", form);
  }

private:
  const Georeference& space;
  fs::path path;
  SavedScene::Form form;
  unsigned threads;
  BuiltGeometries device;  // builds surfaces, and stays empty
  FileWriterHandle writer; // released before its device
};

std::shared_ptr<Terrain> makeTerrain(py::object heights, const py::object& cell, const py::object& origin,
                                     const std::optional<double>& maxError, const std::optional<double>& nodata,
                                     const std::optional<std::string>& representation,
                                     const std::optional<fs::path>& path, int threads, const py::object& progress) {
  if (!py::hasattr(heights, "shape")) heights = realNumbers(heights, "heights");
  const Shape shape = heights.attr("shape").cast<Shape>();
  if (shape.size() != 2 || shape[0] < 2 || shape[1] < 2 || shape[0] > 1 << 23 || shape[1] > 1 << 23)
    throwValueError("heights", "has shape " + shapeText(shape) + ": expected 2 to 2**23 rows and columns");
  const auto [cellX, cellY] = readCell(cell);
  const double bound = maxError.value_or(defaultErrorInCells * std::sqrt(std::abs(cellX * cellY)));
  if (!(bound >= 0) || !std::isfinite(bound) || (bound > 0 && !(bound >= 1e-30 && bound <= 1e30)))
    throwValueError("max_error", "is " + std::to_string(bound) + ": expected 0, or 1e-30 to 1e30");
  const size_t rows = size_t(shape[0]), columns = size_t(shape[1]);
  const Georeference space(rows, columns, cellX, cellY, readOrigin(origin), bound);
  const std::string name = representation.value_or(path ? "cvert" : "ctile");
  const unsigned n = threadsOf(threads);
  if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
    throw py::type_error("progress: is not callable: expected None or a callable");

  const std::unique_ptr<TerrainBuilder> builder =
      interruptibleBuild(py::none(), [&]() -> std::unique_ptr<TerrainBuilder> {
        if (path) return std::make_unique<FileBuilder>(space, *path, readForm(name), n);
        return std::make_unique<MemoryBuilder>(readExactRepresentation(name), n);
      });
  const size_t down = (rows - 2) / tileQuads + 1, across = (columns - 2) / tileQuads + 1;
  double seconds = 0;
  for (size_t i = 0; i < down * across; i++) {
    if (!progress.is_none()) progress("terrain", double(i) / double(down * across));
    TerrainTile tile(space, i / across * tileQuads, i % across * tileQuads);
    tile.read(heights, nodata);
    seconds += interruptibleBuild(py::none(), [&] { return secondsOf([&] { builder->add(tile); }); });
  }
  std::unique_ptr<const TracedScene> scene;
  seconds += interruptibleBuild(py::none(), [&] { return secondsOf([&] { scene = builder->finish(); }); });
  if (!progress.is_none()) progress("terrain", 1.0);
  if (!(scene->bounds().lower.x <= scene->bounds().upper.x))
    throwValueError("heights", "has no triangle of three samples: expected heights that are not all missing");
  auto terrain = std::make_shared<Terrain>(space, std::move(scene), seconds, path ? fs::absolute(*path) : fs::path());
  if (path) OpenFiles<Terrain>::ofProcess().add(*path, terrain);
  return terrain;
}

/* --- queries ----------------------------------------------------------------------- */

/* Throws ValueError for rays that have no direction or place. Runs without Python's lock. */
void requireTerrainRay(const RayArrays& rays, size_t i) {
  const Vec3d o = rays.origins.vectorAt<double>(i);
  if (!std::isfinite(o.x) || !std::isfinite(o.y) || !std::isfinite(o.z))
    throwValueError("origins", "ray " + std::to_string(i) + " is not finite: expected finite numbers");
  const double size = length(rays.directions.vectorAt<double>(i));
  if (!(size > 0) || !std::isfinite(size))
    throwValueError("directions", "ray " + std::to_string(i) + " has length " + std::to_string(size) +
                                      ": expected finite numbers that are not all 0");
}

void requireTerrainRays(const RayArrays& rays, unsigned threads) {
  constexpr size_t chunk = 1 << 16;
  parallelFor(rays.count, chunk, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) requireTerrainRay(rays, i);
  });
}

TerrainHits intersect(const Terrain& terrain, const py::object& origins, const py::object& directions,
                      const py::object& tnear, const py::object& tfar, int threads) {
  const RayArrays rays = readRays(origins, directions, tnear, tfar, py::float_(0.0));
  TerrainHits result(rays.shape, terrain.space, rays.count);
  runQuery(rays.count, rayChunk(*terrain.scene), threadsOf(threads), [&](unsigned n) {
    requireTerrainRays(rays, n);
    terrain.intersect(rays, n, result.hits.data());
  });
  return result;
}

py::array_t<bool> occluded(const Terrain& terrain, const py::object& origins, const py::object& directions,
                           const py::object& tnear, const py::object& tfar, int threads) {
  const RayArrays rays = readRays(origins, directions, tnear, tfar, py::float_(0.0));
  py::array_t<bool> result(rays.shape);
  bool* const hits = result.mutable_data();
  runQuery(rays.count, rayChunk(*terrain.scene), threadsOf(threads), [&](unsigned n) {
    requireTerrainRays(rays, n);
    terrain.occluded(rays, n, hits);
  });
  return result;
}

py::object statistics(const Terrain& terrain) {
  const auto* built = dynamic_cast<const BuiltGeometries*>(terrain.scene.get());
  const auto* saved = dynamic_cast<const SavedScene*>(terrain.scene.get());
  const RTCCompressionStatistics compression = built ? built->compression() : saved->compression();
  const double bytes = double(built ? built->liveBytes() : saved->bytes());
  return objectOf(
      nlohmann::ordered_json{{"quads", compression.numQuads},
                             {"bytes_per_quad", compression.numQuads ? bytes / double(compression.numQuads) : 0.0},
                             {"live_bytes", built ? built->liveBytes() : saved->liveBytes()},
                             {built ? "build_seconds" : "open_seconds", terrain.seconds},
                             {"compression", compressionJson(compression)}});
}

py::array_t<double> boundsOf(const Terrain& terrain) {
  const Box3f box = terrain.scene->bounds();
  const Georeference& s = terrain.space;
  const Vec3d a = s.position(0, 0, double(box.lower.z));
  const Vec3d b = s.position(double(s.rows - 1), double(s.columns - 1), double(box.upper.z));
  const double corners[6] = {std::min(a.x, b.x), std::min(a.y, b.y), a.z, std::max(a.x, b.x), std::max(a.y, b.y), b.z};
  return arrayOf<double>({2, 3}, [&](size_t i) { return corners[i]; });
}

/* --- docstrings -------------------------------------------------------------------- */

constexpr const char* terrainText = R"(A raster of heights that is traced in its own coordinates, see terrain().

Coordinates are float64, for example those of a national grid.)";

constexpr const char* makeText = R"(Builds a raster of heights of any size and returns a Terrain.

heights: (rows, columns), 2 to 2**23 each: an array, a numpy.memmap, or any object with a shape whose slices
  [row:row, column:column] are arrays, such as a dataset of h5py. It is read in parts of 1025 x 1025 samples, so it may
  be larger than memory. NaN is a missing sample: triangles with it are left out. read_raster() reads heights, cell and
  origin of a GeoTIFF.
cell: distance between samples, in the unit of the coordinates. A number c means (c, -c): columns go east, and rows from
  north to south. Two numbers are the steps of x per column and of y per row, as in a geotransform.
origin: (x, y) of sample [0, 0], not of the corner of its pixel; a third number is added to all heights.
max_error: heights are rounded to multiples of the largest power of two that is not above it, and so move by at most
  half of it. x and y do not move. 0 keeps heights, as 32-bit floats. None is 1/128 of a cell.
nodata: value of missing samples, in addition to NaN.
representation: in which rays trace the terrain: "ctile", or "cvert", which is smaller and slower. Hits are the same.
  None is "ctile" in memory, and "cvert" with a path.
path: of a file, as of Terrain.save, to which parts are written as soon as they are built. With "cvert", the terrain is
  then traced in the file, and may be larger than memory. "ctile" makes tiles as Terrain.load does. None keeps the
  terrain in memory.
threads: for building, 0 for all.
progress: called with "terrain" and the fraction done, 0 to 1. An exception that it raises stops the build.

Quads are split as in Grid. The surface is closed at borders of parts. The raster is not needed afterwards. Ctrl-C stops
the build.

Raises ValueError or TypeError that names an invalid argument, and Error for other reasons, such as a full disk.)";

constexpr const char* intersectText = R"(Finds the closest hit of each ray and returns TerrainHits.

origins: (..., 3), in the raster's coordinates, at any distance.
directions: (..., 3), of any length except 0; distances are multiples of the length.
tnear, tfar: (...), range of distances in which hits are found.
threads: 0 for all.

Arguments are broadcast by NumPy's rules. Rays are moved to the terrain in 64 bits, and traced in 32 bits: this adds
errors of about 1e-7 of the extent of the raster. Ctrl-C stops the call. Several Python threads may trace at the same
time. Hits do not depend on the number of threads.

A ray that starts less than max_error / 2 above a sample may start below the stored surface.

Raises ValueError or TypeError for invalid arguments, and Error if a block of a loaded file is damaged.)";

constexpr const char* saveText = R"(Saves the terrain to a file, and its georeference to path + ".json".

path: of the file, str or os.PathLike. An existing file is replaced when the new one is complete.

Raises Error if a file cannot be written.)";

constexpr const char* loadText = R"(Opens a file that Terrain.save wrote, and returns a Terrain with the same hits.

path: of the file, str or os.PathLike. It must not be modified while it is open.
representation, threads: as in load(). Files store cVERT. By default, the file is mapped and traced as it is.

pickle stores the absolute path of a terrain in a file, as for scenes of load(). Raises Error with the reason for
invalid files.)";

} // namespace

void defineTerrain(py::module_& module) {
  using py::arg;
  const py::float_ zero(0.0), infinity(INFINITY);
  defineTerrainHits(module);
  py::class_<Terrain, std::shared_ptr<Terrain>> terrain(module, "Terrain", terrainText);
  terrain
      .def_static("load", &load, arg("path"), py::kw_only(), arg("representation") = "cvert", arg("threads") = 0,
                  loadText)
      .def("intersect", &intersect, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("threads") = 0, intersectText)
      .def("occluded", &occluded, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("threads") = 0,
           "Returns (...) bool: True if the ray hits anything. Arguments and errors as in intersect.")
      .def("save", &save, arg("path"), saveText)
      .def(py::pickle(&pickled, &loadOnce))
      .def("statistics", &statistics,
           "Returns statistics as a dict, with keys of Scene.statistics: quads, bytes_per_quad, live_bytes, "
           "build_seconds (without reading the raster) or open_seconds, and compression.")
      .def_property_readonly(
          "shape", [](const Terrain& t) { return py::make_tuple(t.space.rows, t.space.columns); },
          "Rows and columns of the raster.")
      .def_property_readonly(
          "cell", [](const Terrain& t) { return py::make_tuple(t.space.cellX, t.space.cellY); },
          "Steps of x per column and of y per row.")
      .def_property_readonly(
          "origin",
          [](const Terrain& t) { return py::make_tuple(t.space.origin.x, t.space.origin.y, t.space.origin.z); },
          "Position of sample [0, 0], if its height is 0.")
      .def_property_readonly(
          "max_error", [](const Terrain& t) { return t.space.maxError; }, "Bound of heights, see terrain().")
      .def_property_readonly("bounds", &boundsOf,
                             "(2, 3) float64: lower and upper corner of the bounding box, in the raster's coordinates.")
      .def("__repr__", [](const Terrain& t) {
        return "<Terrain of " + std::to_string(t.space.rows) + " x " + std::to_string(t.space.columns) + " samples>";
      });
  defineHorizons(terrain);
  module.def("terrain", &makeTerrain, arg("heights"), arg("cell") = 1.0, arg("origin") = py::make_tuple(0.0, 0.0),
             py::kw_only(), arg("max_error") = py::none(), arg("nodata") = py::none(),
             arg("representation") = py::none(), arg("path") = py::none(), arg("threads") = 0,
             arg("progress") = py::none(), makeText);
}

} // namespace programs::python
