// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "classes.h"
#include "geometry_scene.h"
#include "interruptible.h"
#include "json_objects.h"
#include "open_files.h"
#include "scene.h"

#include "basics/error.h"
#include "basics/parallel.h"
#include "building/saved_scene.h"
#include "programs/compression_json.h"
#include "programs/view_options.h"

#include <pybind11/stl/filesystem.h>

#include <filesystem>

namespace programs::python {
namespace {

/* A scene from a file, without a model. */
class LoadedScene : public Scene {
public:
  LoadedScene(const std::string& path, std::unique_ptr<const SavedScene> opened)
    : Scene(opened->faces()),
      path(path),
      saved(std::move(opened)) {}

  const TracedScene& traced() const override { return *saved; }

  void requireSearchable(const char* operation) const override {
    for (const CbvhFileSurfaceInfo& geometry : saved->geometries())
      if (geometry.representation != CBVH_REPRESENTATION_CVERT)
        throw Error(std::string(operation) + ": " + path + " stores no triangles that can be searched: expected cVERT");
  }

  Camera camera(const std::string& view, ImageSize size) const override {
    return chooseCamera(view, boxModel(path, saved->bounds()), *saved, size, threadCount(0));
  }

  void save(const std::string& copy) const override { saved->save(copy); }

  py::object statistics() const override {
    const double bytes = double(saved->bytes());
    const size_t quads = saved->quads();
    return objectOf(nlohmann::ordered_json{{"quads", quads},
                                           {"bytes_per_quad", quads ? bytes / double(quads) : 0.0},
                                           {"file_bytes", saved->bytes()},
                                           {"live_bytes", saved->liveBytes()},
                                           {"open_seconds", saved->seconds()},
                                           {"compression", compressionJson(saved->compression())}});
  }

  std::string repr() const override {
    return "<LoadedScene '" + path + "': " + countText(faces()->numGeometries(), "geometry") + ", " +
           countText(saved->quads(), "quad") + ">";
  }

  const std::string path;
  const std::filesystem::path file = std::filesystem::absolute(path);
  const std::unique_ptr<const SavedScene> saved;
};

std::shared_ptr<LoadedScene> loadFile(const std::filesystem::path& path, const std::string& representation,
                                      int threads) {
  const unsigned n = threadsOf(threads);
  const SavedScene::Form form = readForm(representation);
  return interruptibleBuild(py::none(), [&] {
    auto scene = std::make_shared<LoadedScene>(path.string(), std::make_unique<SavedScene>(path.string(), n, "", form));
    OpenFiles<LoadedScene>::ofProcess().add(path, scene);
    return scene;
  });
}

/* For pickle. */
std::shared_ptr<LoadedScene> loadOnce(const std::filesystem::path& path) {
  const std::shared_ptr<LoadedScene> known = OpenFiles<LoadedScene>::ofProcess().find(path);
  return known ? known : loadFile(path, "cvert", 0);
}

constexpr const char* loadText =
    R"(Opens a file that Scene.save or `cbvh_render --save` wrote, and returns a LoadedScene.

path: of the file, str or os.PathLike. The file must not be modified while it is open.
representation: "cvert" or "ctile", of blocks of cVERT. "cvert" maps the file: parts that no ray reaches stay on disk.
  "ctile" reads the whole file and makes tiles, which take twice the memory, or stays with "cvert" if they took more
  than half of the machine's memory. Rays are faster, and have the same hits.
threads: of the device, 0 for all.

The scene has no model, but the same hits to the bit.

pickle stores the absolute path instead of the scene. Processes that receive it, such as Dask's workers, open the file
themselves, as "cvert", once for all copies.

Raises Error with the reason for a file that is truncated, altered, of another version, or not such a file.)";

} // namespace

void defineLoadedScene(py::module_& module) {
  using py::arg;
  py::class_<LoadedScene, Scene, std::shared_ptr<LoadedScene>>(module, "LoadedScene",
                                                               "Compressed geometries of a file, see load().")
      .def_property_readonly(
          "quads", [](const LoadedScene& s) { return s.saved->quads(); }, "Number of quads of all geometries.")
      .def_property_readonly(
          "open_seconds", [](const LoadedScene& s) { return s.saved->seconds(); },
          "Time for opening the file and committing the scene, in seconds.")
      .def(py::pickle([](const LoadedScene& s) { return s.file; }, &loadOnce));
  module.def("load", &loadFile, arg("path"), py::kw_only(), arg("representation") = "cvert", arg("threads") = 0,
             loadText);
}

} // namespace programs::python
