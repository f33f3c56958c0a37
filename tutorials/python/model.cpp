// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "arrays.h"
#include "classes.h"
#include "interruptible.h"
#include "warning.h"

#include "basics/error.h"
#include "building/built_scene.h"
#include "scenes/catalogue.h"
#include "surface/height_map.h"
#include "surface/model.h"
#include "surface/udim_tiles.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <cstdint>
#include <cstdlib> // mkdtemp
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

namespace cbvh::python {
namespace {

namespace fs = std::filesystem;

/* --- displacement -------------------------------------------------------------- */

/* Heights as they come from Python, and where they are read from. */
struct Heights
{
  std::string path;      // of an image
  HeightMap map;         // else these
};

/* An array as a file, which is how OpenImageIO's texture system takes it. */
class MapFile
{
public:
  explicit MapFile(const HeightMap& map) : folder((fs::temp_directory_path() / "embree_cbvh_XXXXXX").string())
  {
    if (!mkdtemp(folder.data()))
      throw Error("height: no temporary folder can be made in " + fs::temp_directory_path().string());
    map.write(path());
  }
  ~MapFile()
  {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  MapFile(const MapFile&) = delete;
  MapFile& operator=(const MapFile&) = delete;

  std::string path() const { return folder + "/height.exr"; }

private:
  std::string folder;
};

/* The file is there for as long as tiles of it may be read. */
struct ArrayDisplacement
{
  MapFile file;
  std::shared_ptr<const Displacement> displacement;
};

Heights readHeights(const py::object& height)
{
  if (py::isinstance<py::str>(height) || py::hasattr(height, "__fspath__"))
    return {height.cast<fs::path>().string(), {}};
  constexpr py::ssize_t most = 1 << 16;
  const Floats array = floats(height, "height");
  if (array.ndim() != 2 || array.size() == 0 || array.shape(0) > most || array.shape(1) > most)
    refuse("height", "has shape " + textOf(shapeOf(array)) + ", not (rows, columns) with 1 to 65536 each");
  const py::ssize_t columns = array.shape(1);
  HeightMap map(int(columns), int(array.shape(0)));
  for (py::ssize_t i = 0; i < array.size(); i++)
  {
    const float value = array.data()[i];
    if (!std::isfinite(value))
      refuse("height", "row " + std::to_string(i / columns) + ", column " + std::to_string(i % columns) + " is not finite");
    map.at(int(i % columns), int(i / columns)) = value;
  }
  return {"", std::move(map)};
}

std::shared_ptr<const Displacement> displace(const Cage& cage, const Heights& heights, DisplacementMap map,
                                             std::string& warnings)
{
  map.path = heights.path;
  if (!map.path.empty())
  {
    std::shared_ptr<const Displacement> displacement = displaceByMap(cage, map, warnings);
    noteMapFiles(cage, map.path);
    return displacement;
  }
  const std::shared_ptr<ArrayDisplacement> kept(new ArrayDisplacement{MapFile(heights.map), nullptr});
  map.path = kept->file.path();
  /* users know the argument, not its file */
  const auto named = [&](std::string text) {
    for (size_t at; (at = text.find(map.path)) != std::string::npos;)
      text.replace(at, map.path.size(), "height");
    return text;
  };
  try
  {
    kept->displacement = displaceByMap(cage, map, warnings);
  }
  catch (const Cancelled&)
  {
    throw;
  }
  catch (const Error& e)
  {
    throw Error(named(e.what()));
  }
  warnings = named(warnings);
  return {kept, kept->displacement.get()};
}

/* --- models -------------------------------------------------------------------- */

const std::vector<std::string> valuesOfMaps{"heights", "object", "tangent"}; // in order of MapValues

/* One number, or one for each direction. */
Vec2f readRepeat(const py::object& value)
{
  const Floats given = floats(value, "repeat");
  if (given.size() != 1 && given.size() != 2)
    refuse("repeat", "is neither one number nor two");
  const Vec2f repeat{given.data()[0], given.data()[given.size() - 1]};
  if (!(repeat.x > 0.0f && repeat.y > 0.0f && std::isfinite(repeat.x) && std::isfinite(repeat.y)))
    refuse("repeat", "is not finite and more than 0");
  return repeat;
}

/* (steps, vertices, 3), or (vertices, 3) of one. */
std::vector<std::vector<Vec3f>> readPoses(const py::object& given, size_t numVertices)
{
  constexpr size_t most = 128; // with the cage, Embree's 129 time steps
  if (given.is_none())
    return {};
  const Floats array = floats(given, "poses");
  Shape shape = shapeOf(array);
  if (shape.size() == 2)
    shape.insert(shape.begin(), 1);
  if (shape.size() != 3 || size_t(shape[0]) > most || size_t(shape[1]) != numVertices || shape[2] != 3)
    refuse("poses", "has shape " + textOf(shapeOf(array)) + ", not (steps, " + std::to_string(numVertices) + ", 3), with at most " + std::to_string(most) + " steps");
  const Vec3f* const positions = reinterpret_cast<const Vec3f*>(array.data());
  std::vector<std::vector<Vec3f>> poses;
  poses.resize(size_t(shape[0]));
  for (size_t i = 0; i < poses.size(); i++)
    poses[i].assign(positions + i * numVertices, positions + (i + 1) * numVertices);
  return poses;
}

std::shared_ptr<Model> makeModel(const Cage& cage, const py::object& height, std::optional<float> amplitude,
                                 std::optional<float> midLevel, const std::string& channel, const py::object& repeat,
                                 const std::string& values, const py::object& poses)
{
  auto model = std::make_shared<Model>();
  model->name = cage.name;
  model->cage = cage;
  model->poses = readPoses(poses, cage.positions.size());
  if (amplitude && height.is_none())
    refuse("amplitude", "needs a height");
  if (amplitude && !std::isfinite(*amplitude))
    refuse("amplitude", "is not finite");
  if (midLevel && !std::isfinite(*midLevel))
    refuse("mid_level", "is not finite");
  DisplacementMap map;
  map.values = MapValues(choice(values, "values", valuesOfMaps));
  map.midLevel = midLevel;
  map.channel = channel;
  map.repeat = readRepeat(repeat);
  const float diagonal = cage.bounds().diagonal();
  map.scale = amplitude ? *amplitude * diagonal : map.values == MapValues::Heights ? defaultAmplitude * diagonal : 1.0f;
  if (height.is_none())
    return model;
  const Heights heights = readHeights(height);
  std::string warnings;
  model->displacement = interruptible(py::none(), [&] { return displace(cage, heights, map, warnings); });
  warn(warnings);
  return model;
}

std::shared_ptr<Model> makeScene(const std::string& name, std::optional<float> amplitude, bool rough,
                                 const std::optional<std::string>& mapping, std::optional<int> count,
                                 const std::string& motion, std::optional<int> steps, const std::optional<fs::path>& mapFolder, int threads, const py::object& progress)
{
  SceneSettings settings;
  settings.scene = name;
  settings.amplitude = amplitude;
  settings.rough = rough;
  settings.mapping = mapping.value_or("");
  settings.count = count;
  settings.motion = motion;
  settings.steps = steps;
  settings.mapFolder = mapFolder ? mapFolder->string() : "";
  settings.threads = threads;
  validateScene(settings);
  std::string warning;
  auto model = interruptible(progress, [&] { return std::make_shared<Model>(loadScene(settings, warning)); });
  warn(warning);
  return model;
}

/* --- tessellation -------------------------------------------------------------- */

struct Mesh
{
  std::vector<Vec3f> vertices;
  std::vector<unsigned> quads; // four corners each
};

BuildSettings settingsOf(int level, int threads)
{
  BuildSettings settings;
  settings.level = level;
  settings.threads = threads;
  validateBuild(settings);
  return settings;
}

Mesh meshOf(const Model& model, int level, int threads)
{
  const BuildSettings settings = settingsOf(level, threads);
  const PatchLayout layout = model.layout(level);
  for (const Patch& patch : layout.patches())
    if (level == 0 && !layout.isQuadFace(patch.face))
      throw Error("level 0 needs a cage of quads only");
  if (layout.numVertices() > UINT32_MAX)
    throw Error("level " + std::to_string(level) + " has " + std::to_string(layout.numVertices()) +
                " vertices, more than 32 bits count");
  Mesh mesh{tessellate(model, settings), {}};
  mesh.quads.reserve(4 * layout.numQuads());
  for (const Patch& patch : layout.patches())
    for (unsigned y = 0; y < patch.resolution; y++)
      for (unsigned x = 0; x < patch.resolution; x++)
      {
        const unsigned row = patch.resolution + 1, corner = unsigned(patch.firstVertex) + y * row + x;
        for (unsigned vertex : {corner, corner + 1, corner + row + 1, corner + row})
          mesh.quads.push_back(vertex);
      }
  return mesh;
}

py::tuple tessellateModel(const Model& model, int level, int threads, const py::object& progress)
{
  const auto mesh = std::make_unique<Mesh>(interruptible(progress, [&] { return meshOf(model, level, threads); }));
  Floats vertices(Shape{py::ssize_t(mesh->vertices.size()), 3}, mesh->vertices.empty() ? nullptr : &mesh->vertices[0].x);
  py::array_t<unsigned> quads(Shape{py::ssize_t(mesh->quads.size() / 4), 4}, mesh->quads.data());
  return py::make_tuple(vertices, quads);
}

constexpr const char* modelText = R"(A displaced subdivision surface: a cage, and heights along the normal of its limit surface.)";

constexpr const char* makeText = R"(Makes a model of a cage, displaced by a height map if there is one.

height: path of an image that OpenImageIO reads (<UDIM> or <UVTILE> in it stands for a tile), or an array (rows, columns)
  of finite numbers whose row 0 is the top of the image. Looked up by the cage's texture coordinates; a cage without
  them gets the whole map on every face. Unsigned integers of a file become 0 to 1, signed integers -1 to 1. Texels
  without a value (NaN, -3.4e38, GDAL's nodata) and outside of a data window move nothing.
amplitude: displacement from height 0 to height 1 as a fraction of the diagonal of the cage's bounding box, 0.006 if it
  is not given; vectors are in world units then.
mid_level: height that leaves the surface where it is, 0.5 if it is not given, 0 of vectors.
channel: of a file, by name or number from 0, its first if it is not given; the first of three of vectors.
repeat: copies of the map in a unit of texture coordinates, one number or one for u and one for v.
values: what a file holds: "heights", or vectors, "object" in the cage's axes, "tangent" along the texture's u, the
  normal, and the texture's v.
poses: (steps, vertices, 3), of a surface that moves: where the cage's vertices are at later times, which are even from
  the cage at time 0 to the last pose at 1. Points between two steps move on lines. Error for naive, which stands still.

Error is raised for a map that cannot be read.)";

constexpr const char* sceneText = R"(Makes one of the generated scenes, see scene_names().

amplitude: as of a model, the scene's own if it is not given.
rough: trex and herd, five times the amplitude.
mapping: trex and herd, heights by "faces", the default, or by an "atlas".
count: herd, number of copies of the cage.
motion: "turn", "bend", "twist" or "walk", what the cage does from time 0 to 1; it stands still by default.
steps: of the motion in time, 2 by default.
map_folder: where the map of trex and herd is kept, 134 MB and made in seconds; the user's cache directory by default.
threads: for making the map, 0 for all.
progress: called with the name of a phase and how much of it is done, 0 to 1.)";

const std::string tessellateText = R"(The mesh that GRID and NAIVE hold, of a model that moves at time 0, to the bit: vertices (n, 3) float32 and quads (m, 4) uint32.

Every patch, which is a face or a corner of a face of n != 4 vertices, has vertices of its own, in rows along u. GRID
and NAIVE split a quad a, b, c, d into the triangles a, b, d and d, b, c.

level: )" + levelRange() + R"(, 2**level x 2**level quads a face.
threads: 0 for all.
progress: called with the name of a phase and how much of it is done, 0 to 1.)";

} // namespace

void defineModel(py::module_& module)
{
  py::class_<Model, std::shared_ptr<Model>>(module, "Model", modelText)
    .def(py::init(&makeModel), py::arg("cage"), py::arg("height") = py::none(), py::arg("amplitude") = py::none(),
         py::kw_only(), py::arg("mid_level") = py::none(), py::arg("channel") = "", py::arg("repeat") = 1,
         py::arg("values") = "heights", py::arg("poses") = py::none(), makeText)
    .def_static("scene", &makeScene, py::arg("name"), py::arg("amplitude") = py::none(), py::kw_only(),
                py::arg("rough") = false, py::arg("mapping") = py::none(), py::arg("count") = py::none(), py::arg("motion") = "", py::arg("steps") = py::none(),
                py::arg("map_folder") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(), sceneText)
    .def_readonly("cage", &Model::cage, "The Cage.")
    .def_readonly("name", &Model::name, "Name of the scene or of the cage.")
    .def_property_readonly("copies", [](const Model& m) { return m.copies.size(); },
                           "Copies of the cage, each a geometry of its own: 1 but for herd.")
    .def_property_readonly("steps", [](const Model& m) { return 1 + m.poses.size(); }, "Steps in time: 1 where it stands still.")
    .def_property_readonly("is_displaced", [](const Model& m) { return bool(m.displacement); },
                           "Whether there are heights.")
    .def("num_quads", [](const Model& m, int level) {
           settingsOf(level, 0);
           return m.layout(level).numQuads();
         }, py::arg("level"), ("Quads at a level, " + levelRange() + ".").c_str())
    .def("tessellate", &tessellateModel, py::arg("level"), py::kw_only(), py::arg("threads") = 0,
         py::arg("progress") = py::none(), tessellateText.c_str())
    .def("__repr__", [](const Model& m) {
      return "<Model '" + m.name + "' of " + std::to_string(m.numFaces()) + " faces, " +
             (m.displacement ? "displaced>" : "not displaced>");
    });
  py::implicitly_convertible<Cage, Model>();

  module.def("scene_names", [] { return sceneNames(); }, "Names of the generated scenes, for Model.scene.");
}

} // namespace cbvh::python
