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

namespace programs::python {
namespace {

namespace fs = std::filesystem;

/* --- displacement -------------------------------------------------------------- */

struct Heights {
  std::string path; // image, or
  HeightMap map;    // array if the path is empty
};

/* Stores an array in a file, because OpenImageIO's texture system only reads files. */
class MapFile {
public:
  explicit MapFile(const HeightMap& map) : folder((fs::temp_directory_path() / "embree_cbvh_XXXXXX").string()) {
    if (!mkdtemp(folder.data()))
      throw Error("height: cannot create a temporary folder in " + fs::temp_directory_path().string());
    map.write(path());
  }
  ~MapFile() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  MapFile(const MapFile&) = delete;
  MapFile& operator=(const MapFile&) = delete;

  std::string path() const { return folder + "/height.exr"; }

private:
  std::string folder;
};

/* Keeps the file while its tiles may be read. */
struct ArrayDisplacement {
  MapFile file;
  std::shared_ptr<const Displacement> displacement;
};

Heights readHeights(const py::object& height) {
  if (py::isinstance<py::str>(height) || py::hasattr(height, "__fspath__"))
    return {height.cast<fs::path>().string(), {}};
  constexpr py::ssize_t most = 1 << 16;
  const Floats array = floats(height, "height");
  if (array.ndim() != 2 || array.size() == 0 || array.shape(0) > most || array.shape(1) > most)
    throwValueError("height",
                    "has shape " + shapeText(shapeOf(array)) + ": expected (rows, columns) with 1 to 65536 each");
  const py::ssize_t columns = array.shape(1);
  HeightMap map(int(columns), int(array.shape(0)));
  for (py::ssize_t i = 0; i < array.size(); i++) {
    const float value = array.data()[i];
    if (!std::isfinite(value))
      throwValueError("height", "row " + std::to_string(i / columns) + ", column " + std::to_string(i % columns) +
                                    " is not finite: expected finite numbers");
    map.at(int(i % columns), int(i / columns)) = value;
  }
  return {"", std::move(map)};
}

std::shared_ptr<const Displacement> displace(const Cage& cage, const Heights& heights, DisplacementMap map,
                                             std::string& warnings) {
  map.path = heights.path;
  if (!map.path.empty()) {
    std::shared_ptr<const Displacement> displacement = displaceByMap(cage, map, warnings);
    recordMapFiles(cage, map.path);
    return displacement;
  }
  const std::shared_ptr<ArrayDisplacement> owner(new ArrayDisplacement{MapFile(heights.map), nullptr});
  map.path = owner->file.path();
  /* Replaces the temporary file's name by the argument's. */
  const auto withArgument = [&](std::string text) {
    for (size_t at; (at = text.find(map.path)) != std::string::npos;) text.replace(at, map.path.size(), "height");
    return text;
  };
  try {
    owner->displacement = displaceByMap(cage, map, warnings);
  } catch (const Canceled&) { throw; } catch (const Error& e) {
    throw Error(withArgument(e.what()));
  }
  warnings = withArgument(warnings);
  return {owner, owner->displacement.get()};
}

/* --- models -------------------------------------------------------------------- */

const std::vector<std::string> valuesOfMaps{"heights", "object", "tangent"}; // in the order of MapValues

Vec2f readRepeat(const py::object& value) {
  const Floats array = floats(value, "repeat");
  if (array.size() != 1 && array.size() != 2)
    throwValueError("repeat", "has " + std::to_string(array.size()) + " numbers: expected one or two");
  const Vec2f repeat{array.data()[0], array.data()[array.size() - 1]};
  if (!(repeat.x > 0.0f && repeat.y > 0.0f && std::isfinite(repeat.x) && std::isfinite(repeat.y)))
    throwValueError("repeat", "is (" + std::to_string(repeat.x) + ", " + std::to_string(repeat.y) +
                                  "): expected finite numbers above 0");
  return repeat;
}

/* Requires shape (steps, vertices, 3), or (vertices, 3) for one step. */
std::vector<std::vector<Vec3f>> readPoses(const py::object& poses, size_t numVertices) {
  constexpr size_t most = 128; // Embree's 129 time steps without the cage
  if (poses.is_none()) return {};
  const Floats array = floats(poses, "poses");
  Shape shape = shapeOf(array);
  if (shape.size() == 2) shape.insert(shape.begin(), 1);
  if (shape.size() != 3 || size_t(shape[0]) > most || size_t(shape[1]) != numVertices || shape[2] != 3)
    throwValueError("poses", "has shape " + shapeText(shapeOf(array)) + ": expected (steps, " +
                                 std::to_string(numVertices) + ", 3) with at most " + std::to_string(most) + " steps");
  const Vec3f* const positions = reinterpret_cast<const Vec3f*>(array.data());
  std::vector<std::vector<Vec3f>> result;
  result.resize(size_t(shape[0]));
  for (size_t i = 0; i < result.size(); i++)
    result[i].assign(positions + i * numVertices, positions + (i + 1) * numVertices);
  return result;
}

std::shared_ptr<Model> makeModel(const Cage& cage, const py::object& height, std::optional<float> amplitude,
                                 std::optional<float> midLevel, const std::string& channel, const py::object& repeat,
                                 const std::string& values, const py::object& poses,
                                 const std::optional<std::string>& wrap) {
  auto model = std::make_shared<Model>();
  model->name = cage.name;
  model->cage = cage;
  model->poses = readPoses(poses, cage.positions.size());
  if (amplitude && height.is_none()) throwValueError("amplitude", "is given without a height: expected both");
  if (amplitude && !std::isfinite(*amplitude)) throwValueError("amplitude", "is not finite: expected a finite number");
  if (midLevel && !std::isfinite(*midLevel)) throwValueError("mid_level", "is not finite: expected a finite number");
  DisplacementMap map;
  map.values = MapValues(choice(values, "values", valuesOfMaps));
  map.midLevel = midLevel;
  map.channel = channel;
  map.repeat = readRepeat(repeat);
  if (wrap) map.wrap = TextureWrap(choice(*wrap, "wrap", textureWrapNames()));
  const float diagonal = cage.bounds().diagonal();
  if (!amplitude && map.values == MapValues::Heights) amplitude = defaultAmplitude;
  map.scale = amplitude ? *amplitude * diagonal : 1.0f;
  if (height.is_none()) return model;
  validateScale(amplitude, amplitude ? std::nullopt : std::optional(map.scale), midLevel, cage);
  const Heights heights = readHeights(height);
  std::string warnings;
  model->displacement = interruptibleBuild(py::none(), [&] { return displace(cage, heights, map, warnings); });
  warn(warnings);
  return model;
}

std::shared_ptr<Model> makeScene(const std::string& name, std::optional<float> amplitude, bool rough,
                                 const std::optional<std::string>& mapping, std::optional<int> count,
                                 const std::string& motion, std::optional<int> steps,
                                 const std::optional<fs::path>& mapFolder, int threads, const py::object& progress) {
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
  auto model = interruptibleBuild(progress, [&] { return std::make_shared<Model>(loadScene(settings, warning)); });
  warn(warning);
  return model;
}

/* --- tessellation -------------------------------------------------------------- */

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<unsigned> quads; // four corners each
};

BuildSettings settingsOf(int level, int threads) {
  BuildSettings settings;
  settings.level = level;
  settings.threads = threads;
  validateBuild(settings);
  return settings;
}

Mesh meshOf(const Model& model, int level, int threads) {
  const BuildSettings settings = settingsOf(level, threads);
  const PatchLayout layout = model.layout(level);
  for (const Patch& patch : layout.patches())
    if (level == 0 && !layout.isQuadFace(patch.face))
      throw Error("level 0: face " + std::to_string(patch.face) + " is not a quad: expected only quads, or level 1");
  if (layout.numVertices() > UINT32_MAX)
    throw Error("level " + std::to_string(level) + " has " + std::to_string(layout.numVertices()) +
                " vertices: expected at most 2**32 - 1");
  Mesh mesh{tessellate(model, settings), {}};
  mesh.quads.reserve(4 * layout.numQuads());
  for (const Patch& patch : layout.patches())
    for (unsigned y = 0; y < patch.resolution; y++)
      for (unsigned x = 0; x < patch.resolution; x++) {
        const unsigned row = patch.resolution + 1, corner = unsigned(patch.firstVertex) + y * row + x;
        for (unsigned vertex : {corner, corner + 1, corner + row + 1, corner + row}) mesh.quads.push_back(vertex);
      }
  return mesh;
}

py::tuple tessellateModel(const Model& model, int level, int threads, const py::object& progress) {
  const auto mesh = std::make_unique<Mesh>(interruptibleBuild(progress, [&] { return meshOf(model, level, threads); }));
  const float* const data = mesh->vertices.empty() ? nullptr : &mesh->vertices[0].x;
  Floats vertices(Shape{py::ssize_t(mesh->vertices.size()), 3}, data);
  py::array_t<unsigned> quads(Shape{py::ssize_t(mesh->quads.size() / 4), 4}, mesh->quads.data());
  return py::make_tuple(vertices, quads);
}

constexpr const char* modelText = "A displaced subdivision surface: a cage, and a displacement of its limit surface.";

constexpr const char* makeText = R"(Creates a model from a cage, displaced by a map if there is one.

height: path of an image that OpenImageIO reads (<UDIM> or <UVTILE> in it stands for a tile), or an array (rows,
  columns) of finite numbers, whose row 0 is the top of the image. It is read through the cage's texture coordinates; a
  cage without them gets the whole map on every face. Unsigned integers of a file become 0 to 1, signed integers -1 to
  1. Texels without a value (NaN, -3.4e38, GDAL's nodata) and texels outside of a data window move nothing.
amplitude: displacement between heights 0 and 1 as a fraction of the diagonal of the cage's bounding box; default 0.006.
  For vectors, the default is a scale of 1 in world units.
mid_level: height that moves nothing; default 0.5, 0 for vectors.
channel: channel of a file, by name or number from 0; default the first. For vectors, the first of three channels.
repeat: copies of the map per unit of texture coordinates; one number, or one each for u and v.
wrap: heights outside of the image: "clamp", of the nearest texel; "repeat", of copies of the image; "black", 0. The
  default is "repeat", but "clamp" for tiles and for a map on every face that is not repeated.
values: contents of a file: "heights"; "object", vectors along the cage's axes; "tangent", vectors along the texture's
  u, the normal, and the texture's v.
poses: (steps, vertices, 3), for a surface that moves: positions of the cage's vertices at later times, at equal
  intervals from the cage at time 0 to the last pose at time 1. Points move linearly between two steps. naive does not
  support motion.

Raises Error for a map that cannot be read.)";

constexpr const char* sceneText = R"(Creates one of the generated scenes, see scene_names().

amplitude: as in Model; default the scene's own.
rough: trex and herd: multiplies the amplitude by five.
mapping: trex and herd: heights by "faces" (the default) or by an "atlas".
count: herd: number of copies of the cage.
motion: "turn", "bend", "twist" or "walk": motion of the cage from time 0 to 1; default none.
steps: number of time steps of the motion; default 2.
map_folder: folder of the map of trex and herd, 134 MB, which takes seconds to generate; default the user's cache
  folder.
threads: for generating the map, 0 for all.
progress: called with the name of a phase and the fraction done, 0 to 1.)";

const std::string tessellateText = R"(Returns the mesh of GRID and NAIVE, to the bit, at time 0.

Every patch, which is a face or a corner of a face of n != 4 vertices, has its own vertices, in rows along u. GRID and
NAIVE split a quad a, b, c, d into the triangles a, b, d and d, b, c.

level: )" + levelRange() + R"(, 2**level x 2**level quads per face.
threads: 0 for all.
progress: called with the name of a phase and the fraction done, 0 to 1.

Returns vertices, (n, 3) float32, and quads, (m, 4) uint32.)";

} // namespace

void defineModel(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>>(module, "Model", modelText)
      .def(py::init(&makeModel), py::arg("cage"), py::arg("height") = py::none(), py::arg("amplitude") = py::none(),
           py::kw_only(), py::arg("mid_level") = py::none(), py::arg("channel") = "", py::arg("repeat") = 1,
           py::arg("values") = "heights", py::arg("poses") = py::none(), py::arg("wrap") = py::none(), makeText)
      .def_static("generate", &makeScene, py::arg("name"), py::arg("amplitude") = py::none(), py::kw_only(),
                  py::arg("rough") = false, py::arg("mapping") = py::none(), py::arg("count") = py::none(),
                  py::arg("motion") = "", py::arg("steps") = py::none(), py::arg("map_folder") = py::none(),
                  py::arg("threads") = 0, py::arg("progress") = py::none(), sceneText)
      .def_readonly("cage", &Model::cage, "The Cage.")
      .def_property_readonly(
          "name", [](const Model& m) { return stringOf(m.name); }, "Name of the scene or of the cage.")
      .def_property_readonly(
          "copies", [](const Model& m) { return m.copies.size(); },
          "Number of copies of the cage, each a geometry of its own: 1 except for herd.")
      .def_property_readonly(
          "steps", [](const Model& m) { return 1 + m.poses.size(); },
          "Number of time steps: 1 if the model does not move.")
      .def_property_readonly(
          "is_displaced", [](const Model& m) { return bool(m.displacement); }, "True if the model is displaced.")
      .def(
          "num_quads",
          [](const Model& m, int level) {
            settingsOf(level, 0);
            return m.layout(level).numQuads();
          },
          py::arg("level"), ("Returns the number of quads at a level, " + levelRange() + ".").c_str())
      .def("tessellate", &tessellateModel, py::arg("level"), py::kw_only(), py::arg("threads") = 0,
           py::arg("progress") = py::none(), tessellateText.c_str())
      .def("__repr__", [](const Model& m) {
        return stringOf("<Model '" + m.name + "' of " + std::to_string(m.numFaces()) + " faces, " +
                        (m.displacement ? "displaced>" : "not displaced>"));
      });
  py::implicitly_convertible<Cage, Model>();

  module.def(
      "scene_names", [] { return sceneNames(); }, "Returns the names of the generated scenes, for Model.generate.");
}

} // namespace programs::python
