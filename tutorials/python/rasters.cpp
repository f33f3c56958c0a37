// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Files of rasters: read_raster() and write_raster(). */

#include "arrays.h"
#include "classes.h"
#include "interruptible.h"
#include "large_array.h"
#include "scene.h"
#include "terrain.h"

#include "../terrain/elevation.h"

#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/parallel.h"
#include "surface/geo_tiff.h"

#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

namespace programs::python {
namespace {

namespace fs = std::filesystem;

/* --- reading -------------------------------------------------------------------- */

struct Raster {
  size_t rows = 0, columns = 0;
  LargeArray<float> heights;
  GeoTags tags;
};

Raster readHeights(const ElevationSettings& settings, unsigned threads) {
  constexpr int rowsAtOnce = 256;
  Elevation elevation(settings);
  const int w = elevation.width(), h = elevation.height();
  Raster raster;
  raster.rows = size_t(h);
  raster.columns = size_t(w);
  raster.heights = LargeArray<float>(raster.rows * raster.columns);
  for (int row = 0; row < h; row += rowsAtOnce) {
    throwIfCanceled();
    const std::vector<float> part = elevation.heights(0, row, w, std::min(rowsAtOnce, h - row), threads);
    std::copy(part.begin(), part.end(), raster.heights.begin() + size_t(row) * raster.columns);
  }
  raster.tags = elevation.geoTags(0, 0);
  return raster;
}

py::dict readRaster(const fs::path& path, const std::string& channel, const std::string& encoding,
                    const std::optional<float>& nodata, int threads) {
  ElevationSettings settings;
  const size_t code = choice(encoding, "encoding", {"", "terrarium", "mapbox"});
  if (code && !channel.empty())
    throwValueError("channel", "is '" + channel + "' although encoding is '" + encoding + "': expected none");
  settings.encoding = HeightEncoding(code);
  settings.path = path.string();
  settings.channel = channel;
  settings.nodata = nodata;
  const unsigned n = threadsOf(threads);
  auto* const raster = new Raster(interruptibleQuery([&] { return readHeights(settings, n); }));
  const py::capsule owner(raster, [](void* p) { delete static_cast<Raster*>(p); });
  py::dict result;
  result["heights"] =
      py::array_t<float>(Shape{py::ssize_t(raster->rows), py::ssize_t(raster->columns)}, raster->heights.data(), owner);
  const std::optional<SamplePlaces> places = samplePlaces(raster->tags);
  const bool isPlaced = places && !places->isRotated();
  result["cell"] = isPlaced ? py::object(py::make_tuple(places->xOfColumn, places->yOfRow)) : py::none();
  result["origin"] = isPlaced ? py::object(py::make_tuple(places->x0, places->y0)) : py::none();
  return result;
}

/* --- writing -------------------------------------------------------------------- */

/* The raster that values are a part of. */
struct Frame {
  size_t rows = 0, columns = 0;
  GeoTags tags;
};

/* Of the first image of a GeoTIFF. */
Frame frameOfFile(const fs::path& path, const std::string& argument) {
  if (fs::exists(path) && !fs::is_regular_file(path))
    throw Error(argument + ": " + path.string() + " is not a regular file: expected a GeoTIFF file");
  recordInputFile(path.string());
  const std::optional<TiffPage> page = firstImage(path.string());
  if (page && !(page->tags.keys.empty() && page->tags.tiepoints.empty() && page->tags.matrix.empty()))
    return {page->height, page->width, page->tags};
  if (!fs::exists(path)) throw Error(argument + ": " + path.string() + " does not exist: expected a GeoTIFF file");
  throwValueError(argument, path.string() + " has no georeference of a GeoTIFF: expected a GeoTIFF file");
}

Frame frameOfTerrain(const Georeference& space, const std::optional<fs::path>& crs) {
  Frame frame{space.rows, space.columns, {}};
  if (crs) {
    const GeoTags tags = frameOfFile(*crs, "crs").tags;
    if (tags.keys.empty())
      throwValueError("crs", crs->string() + " has no coordinate system: expected a GeoTIFF file with geokeys");
    frame.tags.keys = tags.keys;
    frame.tags.keyNumbers = tags.keyNumbers;
    frame.tags.keyTexts = tags.keyTexts;
  }
  if (frame.tags.keys.empty()) frame.tags.keys = {1, 1, 0, 1, 1025, 0, 1, 1}; // revision 1.0; pixels are areas
  setSamplePlaces(frame.tags, {space.origin.x, space.cellX, 0, space.origin.y, 0, space.cellY});
  return frame;
}

/* Contiguous, and of a type that a TIFF can have. */
py::array tiffArray(const py::object& value) {
  const py::array given = realNumbers(value, "values");
  const char kind = given.dtype().kind();
  const auto bytes = given.itemsize();
  const std::string type = kind == 'b' ? "u1" : kind != 'f' ? kind + std::to_string(bytes) : bytes <= 4 ? "f4" : "f8";
  return py::module_::import("numpy").attr("ascontiguousarray")(given, py::dtype(type));
}

void writeRaster(const fs::path& path, const py::object& values, const py::object& like, py::ssize_t row,
                 py::ssize_t column, const std::optional<fs::path>& crs) {
  const py::array array = tiffArray(values);
  const Shape shape = shapeOf(array);
  if ((shape.size() != 2 && shape.size() != 3) || array.size() == 0 || (shape.size() == 3 && shape[2] > 65535))
    throwValueError("values", "has shape " + shapeText(shape) +
                                  ": expected (rows, columns), or (rows, columns, n) with n from 1 to 65535");
  const bool isTerrain = py::isinstance<Terrain>(like);
  std::optional<fs::path> file;
  if (!isTerrain) {
    if (!py::isinstance<py::str>(like) && !py::hasattr(like, "__fspath__"))
      throw py::type_error("like: is of type " + std::string(py::str(py::type::of(like).attr("__name__"))) +
                           ": expected a Terrain or the path of a GeoTIFF");
    file = like.cast<fs::path>();
  }
  if (crs && !isTerrain)
    throw py::type_error("crs: is given although like is a file, which has its own: expected None");
  const Frame frame = isTerrain ? frameOfTerrain(like.cast<const Terrain&>().space, crs) : frameOfFile(*file, "like");
  const auto requireInside = [&](const char* argument, py::ssize_t first, py::ssize_t count, size_t limit) {
    if (first < 0 || first > py::ssize_t(limit) - count)
      throwValueError(argument, "is " + std::to_string(first) + ", and values has shape " + shapeText(shape) +
                                    ": expected a part of a raster of " + std::to_string(frame.rows) + " x " +
                                    std::to_string(frame.columns) + " samples, see like");
  };
  requireInside("row", row, shape[0], frame.rows);
  requireInside("column", column, shape[1], frame.columns);

  RasterSamples samples;
  samples.height = size_t(shape[0]);
  samples.width = size_t(shape[1]);
  samples.channels = shape.size() == 3 ? size_t(shape[2]) : 1;
  const char kind = array.dtype().kind();
  samples.kind = kind == 'f' ? SampleKind::Floating : kind == 'i' ? SampleKind::Signed : SampleKind::Unsigned;
  samples.bits = unsigned(8 * array.itemsize());
  samples.data = array.data();
  const GeoTags tags = tagsOfPart(frame.tags, size_t(column), size_t(row));
  /* Not as a query: at most one file may be written at a time. */
  runBuild(py::none(), [&] { writeGeoTiff(path.string(), samples, tags); });
}

/* --- docstrings -------------------------------------------------------------------- */

constexpr const char* readText = R"(Reads the heights of a raster file, such as a GeoTIFF.

path: of the file, str or os.PathLike: any format that cbvh_terrain reads.
channel: name or number of the channel of heights. Empty is the only channel.
encoding: "terrarium" or "mapbox" decodes heights in meters from the colors of map tiles.
nodata: value of missing samples, in addition to NaN and GDAL's tag.
threads: 0 for all.

Returns a dictionary of arguments of terrain(), so that terrain(**read_raster(path)) traces the file:
  "heights": (rows, columns) float32, NaN for missing samples. GDAL's scale and offset are applied.
  "cell": (x, y), the steps of x per column and of y per row, in the unit of the file's coordinates. None if the file is
    no GeoTIFF, or is rotated.
  "origin": (x, y) of the center of pixel [0, 0], or None.

World files (.tfw) and GDAL's files .aux.xml are not read. Angles are not converted: for cells in degrees and heights in
meters, project the raster first. The file is read completely; see terrain() for larger ones. Ctrl-C stops the call.

Raises Error for files that cannot be read.)";

constexpr const char* writeText = R"(Writes an array as a GeoTIFF with the georeference of a terrain or of another file.

path: of the new file, str or os.PathLike. An existing file is replaced when the new one is complete.
values: (rows, columns), or (rows, columns, n) for n channels: results for samples of the raster. The file has the type
  of the array, but bool becomes uint8, and float16 float32. Of floats, NaN is the value of missing samples.
like: a Terrain, whose cell and origin are written, or the path of a GeoTIFF, whose coordinate system and transformation
  are copied. The transformation may be rotated, or refer to centers of pixels.
row, column: of the raster of `like`, of values[0, 0], for values of a part of it.
crs: path of a GeoTIFF whose coordinate system is copied, if `like` is a Terrain. None writes none.

The call uses one thread, and other Python threads run meanwhile.

Raises ValueError or TypeError that names an invalid argument, and Error if the file cannot be written, for example
because it is an input of this process.)";

} // namespace

void defineRasters(py::module_& module) {
  using py::arg;
  module.def("read_raster", &readRaster, arg("path"), py::kw_only(), arg("channel") = "", arg("encoding") = "",
             arg("nodata") = py::none(), arg("threads") = 0, readText);
  module.def("write_raster", &writeRaster, arg("path"), arg("values"), arg("like"), py::kw_only(), arg("row") = 0,
             arg("column") = 0, arg("crs") = py::none(), writeText);
}

} // namespace programs::python
