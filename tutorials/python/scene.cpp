// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scene.h"
#include "all_hits.h"
#include "camera.h"
#include "classes.h"
#include "geometry_scene.h"
#include "hits.h"
#include "interruptible.h"
#include "point_queries.h"
#include "ray_arrays.h"

#include "basics/parallel.h"
#include "building/stored_surface.h"
#include "tracing/trace_batches.h"
#include "tracing/trace_timing.h"

#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace programs::python {

unsigned threadsOf(int threads) {
  if (threads < 0) throwValueError("threads", "is " + std::to_string(threads) + ": expected 0 (all) or more");
  return threadCount(threads);
}

void requireNotNegative(float value, const char* argument) {
  if (!(value >= 0.0f) || !std::isfinite(value))
    throwValueError(argument, "is " + std::to_string(value) + ": expected a finite number of at least 0");
}

void requireHitsOf(const Scene& scene, const Hits& hits, const char* argument) {
  if (!(*hits.faces == *scene.faces()))
    throwValueError(argument, "are of a scene of " + std::to_string(hits.faces->count()) + " faces: expected " +
                                  std::to_string(scene.faces()->count()) + ", as in this scene");
}

std::string countText(size_t count, const std::string& noun) {
  const std::string one = std::to_string(count) + " " + noun;
  if (count == 1) return one;
  return noun.back() == 'y' ? one.substr(0, one.size() - 1) + "ies" : one + "s";
}

namespace {

/* --- tracing ------------------------------------------------------------------- */

Hits intersect(const Scene& scene, const py::object& origins, const py::object& directions, const py::object& tnear,
               const py::object& tfar, const py::object& time, int threads) {
  const RayArrays rays = readRays(origins, directions, tnear, tfar, time);
  Hits result{rays.shape, LargeArray<SurfaceHit>(rays.count), scene.faces()};
  SurfaceHit* const hits = result.hits.data();
  const size_t chunk = rayChunk(scene.traced());
  runQuery(rays.count, chunk, threadsOf(threads), [&](unsigned n) {
    parallelFor(rays.count, chunk, n, [&](size_t begin, size_t end) {
      traceClosestBatches(
          scene.traced(), end - begin, [&](size_t i) { return rays.ray(begin + i); },
          [&](size_t i, const SurfaceHit& hit) { hits[begin + i] = hit; });
    });
    scene.checkRays();
  });
  return result;
}

py::array_t<bool> occluded(const Scene& scene, const py::object& origins, const py::object& directions,
                           const py::object& tnear, const py::object& tfar, const py::object& time, int threads) {
  const RayArrays rays = readRays(origins, directions, tnear, tfar, time);
  py::array_t<bool> result(rays.shape);
  bool* const hits = result.mutable_data();
  const size_t chunk = rayChunk(scene.traced());
  runQuery(rays.count, chunk, threadsOf(threads), [&](unsigned n) {
    parallelFor(rays.count, chunk, n, [&](size_t begin, size_t end) {
      traceAnyBatches(
          scene.traced(), end - begin, [&](size_t i) { return rays.ray(begin + i); },
          [&](size_t i, bool isHit) { hits[begin + i] = isHit; });
    });
    scene.checkRays();
  });
  return result;
}

double traceSeconds(const Scene& scene, const py::object& origins, const py::object& directions,
                    const std::string& query, const std::string& mode, bool coherent, int threads, unsigned passes) {
  TraceSettings settings;
  settings.query = parseQuery(query);
  settings.mode = parseTraceMode(mode);
  settings.coherent = coherent;
  settings.threads = threadsOf(threads);
  settings.passes = passes;
  if (passes < 1) throwValueError("passes", "is 0: expected 1 or more");
  const std::vector<Ray> rays = readRays(origins, directions).rays();
  return interruptibleQuery([&] {
    const double seconds = timeTrace(scene.traced(), rays, settings).seconds;
    scene.checkRays();
    return seconds;
  });
}

Camera cameraOf(const Scene& scene, const std::string& view, std::pair<int, int> size) {
  choice(view, "view", {"full", "close"});
  const ImageSize image = imageSize(size);
  return interruptibleQuery([&] {
    const Camera camera = scene.camera(view, image);
    scene.checkRays();
    return camera;
  });
}

/* --- stored surface --------------------------------------------------------------- */

py::array_t<float> trianglesOf(const Scene& scene, const Hits& hits, float time) {
  scene.requireTriangles("looking up a triangle");
  requireHitsOf(scene, hits, "hits");
  requireTime(time);
  Shape shape = hits.shape;
  shape.insert(shape.end(), {3, 3});
  py::array_t<float> array(shape);
  Vec3f* const out = reinterpret_cast<Vec3f*>(array.mutable_data());
  runQuery([&] {
    for (size_t i = 0; i < hits.hits.size(); i++)
      if (!storedTriangle(scene.traced(), *scene.faces(), hits.hits[i], time, out + 3 * i))
        std::fill_n(out + 3 * i, 3, Vec3f{NAN, NAN, NAN});
  });
  return array;
}

py::dict storedMeshOf(const Scene& scene, float time) {
  scene.requireTriangles("reading the surface");
  requireTime(time);
  const StoredMesh mesh = interruptibleQuery([&] { return storedMesh(scene.traced(), *scene.faces(), time); });
  py::dict result;
  const py::ssize_t quads = py::ssize_t(mesh.quads.size());
  const auto coordinate = [&](size_t i) { return (&mesh.vertices[i / 3].x)[i % 3]; };
  const auto corner = [&](size_t i) { return mesh.quads[i / 4][i % 4]; };
  result["vertices"] = arrayOf<float>({py::ssize_t(mesh.vertices.size()), 3}, coordinate);
  result["quads"] = arrayOf<unsigned>({quads, 4}, corner);
  result["primID"] = arrayOf<unsigned>({quads}, [&](size_t i) { return scene.faces()->primID(mesh.faces[i]); });
  result["geomID"] = arrayOf<unsigned>({quads}, [&](size_t i) { return scene.faces()->geomID(mesh.faces[i]); });
  return result;
}

[[noreturn]] void refusePickle(const Scene& scene) {
  throw py::type_error(scene.repr() + " is in memory and cannot be pickled: save it, and pickle what load() returns");
}

void save(const Scene& scene, const std::filesystem::path& path) {
  runBuild(py::none(), [&] { scene.save(path.string()); });
}

/* --- docstrings ---------------------------------------------------------------- */

constexpr const char* sceneText = R"(Geometries that are built and traced together.

The geometry with index i in `geometries` has the geomID i in hits. build() and load() return scenes of the subclasses
ModelScene and LoadedScene.)";

constexpr const char* intersectText = R"(Finds the closest hit of each ray and returns Hits.

origins: (..., 3), world units.
directions: (..., 3), of any length; distances are multiples of the length.
tnear, tfar: (...), range of distances in which hits are found.
time: (...), 0 to 1, for geometries that move: 0 is the first time step of a model, 1 the last.
threads: 0 for all.

Arguments are rounded to float32 and broadcast by NumPy's rules: one origin and a picture of directions return a picture
of hits. Contiguous arrays of float32 or float64 are not copied, and must not change during the call. Ctrl-C stops the
call. Several Python threads may trace at the same time, in the same scene or in several. Hits do not depend on the
number of threads.

Raises ValueError or TypeError for invalid arguments, and Error if a block of a loaded file is damaged.)";

constexpr const char* occludedText =
    R"(Returns (...) bool: True if the ray hits anything. Arguments and errors as in intersect.)";

constexpr const char* secondsText = R"(Traces the rays and returns the time of one pass in seconds.

The time is processor time for one thread and wall-clock time for several. It is measured in C++ and includes filling
Embree's ray structs. Measure representations alternately, and use medians.

origins, directions: as in intersect.
query: "closest" or "any".
mode: rays per call of Embree: "single", "packet4", "packet8", "packet16" or "stream".
coherent: the flag that Embree receives with the rays.
threads: 0 for all.
passes: number of passes over the rays, for small sets.)";

constexpr const char* cameraText = R"(Returns a Camera for the scene.

view: "full" shows the whole scene, "close" a part.
size: width and height in pixels.

The camera is fitted to the surface in this representation: use the same camera for all scenes that are compared.)";

constexpr const char* statisticsText = R"(Returns statistics of the scene as a dict.

Keys of all scenes: quads (two triangles of a mesh count as one), bytes_per_quad, live_bytes (memory that the device
holds, without mapped files), and for compressed scenes compression, a dict of bytes and counts, in which invalid_quads
counts the quads with a vertex that is not finite.

Scenes of geometries and models: representation, peak_bytes (held during the build) and build_seconds.

Models: level, distance_from_mesh (world units: a bound on the distance of hits from the mesh of this level), seam_gap
and seam_gap_quads (the largest distance between the two sides of a seam of texture coordinates before their mean closed
it, in units of the cage and in quads). live_bytes includes the cage.

Files: open_seconds, and file_bytes, of which bytes_per_quad is a part.

Names are those of `cbvh_render --json`.)";

constexpr const char* trianglesText = R"(Returns the stored triangle of each hit, (..., 3, 3) float32.

hits: hits in this scene.
time: time of the hits' rays, if the scene moves.

Vertices are in world units, NaN for a miss or if no triangle is stored. Only for ctile, cvert and cgrid; raises Error
for other representations.)";

constexpr const char* storedMeshText = R"(Returns the whole stored surface as a dict of arrays.

time: 0 to 1, for scenes that move.

Keys: vertices, (n, 3) float32 in world units; quads, (m, 4) uint32, vertices in order around each quad; primID and
geomID, (m,) uint32, as in hits. A quad 00, 10, 11, 01 consists of the triangles 00, 10, 01 and 01, 10, 11. In meshes
one of them may be empty, with two equal vertices; in meshes of triangles, primID is that of the first one. Parts
have up to 16 x 16 quads, in cgrid up to 256 x 256; vertices at their borders are repeated, as the same floats, in cgrid
only within a face. Only for ctile, cvert and cgrid; raises Error for other representations.)";

constexpr const char* saveText = R"(Saves a compressed scene to a file, which load() and cbvh_render --load open.

path: of the file, str or os.PathLike. An existing file is replaced when the new one is complete.

Raises ValueError if the scene is not compressed, and Error if the file cannot be written.)";

} // namespace

void defineScene(py::module_& module) {
  using py::arg;
  const py::float_ zero(0.0), infinity(INFINITY);
  py::class_<Scene, std::shared_ptr<Scene>> scene(module, "Scene", sceneText);
  scene
      .def(py::init(&buildGeometries), arg("geometries"), arg("representation") = optionNameOf(preferredKind),
           py::kw_only(), arg("threads") = 0, arg("isa") = "", arg("progress") = py::none(), buildGeometriesText)
      .def("intersect", &intersect, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("time") = zero, arg("threads") = 0, intersectText)
      .def("occluded", &occluded, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("time") = zero, arg("threads") = 0, occludedText)
      .def("trace_seconds", &traceSeconds, arg("origins"), arg("directions"), py::kw_only(), arg("query") = "closest",
           arg("mode") = "single", arg("coherent") = false, arg("threads") = 1, arg("passes") = 1, secondsText)
      .def("camera", &cameraOf, arg("view") = "full", arg("size") = std::pair<int, int>(1024, 1024), cameraText)
      .def("statistics", &Scene::statistics, statisticsText)
      .def("triangles", &trianglesOf, arg("hits"), py::kw_only(), arg("time") = 0.0f, trianglesText)
      .def("stored_mesh", &storedMeshOf, py::kw_only(), arg("time") = 0.0f, storedMeshText)
      .def("save", &save, arg("path"), saveText)
      .def_property_readonly(
          "geometries", [](const Scene& s) { return s.faces()->numGeometries(); }, "Number of geometries.")
      .def_property_readonly(
          "bounds", [](const Scene& s) { return arrayOf(s.traced().bounds()); },
          "(2, 3) float32: lower and upper corner of the surface's bounding box, world units.")
      .def("__getstate__", &refusePickle)
      .def("__repr__", [](const Scene& s) { return stringOf(s.repr()); });
  defineAllHits(scene);
  definePointQueries(scene);
}

} // namespace programs::python
