// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "camera.h"
#include "classes.h"
#include "closest_points.h"
#include "hits.h"
#include "interruptible.h"
#include "json_objects.h"
#include "warning.h"

#include "basics/error.h"
#include "basics/parallel.h"
#include "building/built_scene.h"
#include "building/memory.h"
#include "building/saved_scene.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"
#include "programs/compression_json.h"
#include "programs/errors_json.h"
#include "programs/view_options.h"
#include "programs/warnings.h"
#include "tracing/ray_conversion.h"
#include "tracing/trace_hits.h"
#include "tracing/trace_timing.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

namespace programs::python {
namespace {

struct Scene {
  Scene(std::shared_ptr<const Model> model, const Representation& representation, const BuildSettings& settings)
    : model(std::move(model)),
      level(settings.level),
      built(*this->model, representation, settings) {}

  const TracedScene& traced() const { return built; }

  Hits hitsOf(Shape shape, std::vector<SurfaceHit> hits) const {
    return {std::move(shape), std::move(hits), model->cage.numFaces(), model->numFaces()};
  }

  std::shared_ptr<const Model> model; // must outlive `built`
  int level;
  BuiltScene built;
};

/* A scene from a file, without a model. */
struct LoadedScene {
  const TracedScene& traced() const { return saved; }

  LoadedScene(const std::string& path, unsigned threads) : path(path), saved(path, threads) {}

  std::string path;
  SavedScene saved;
};

void requireNotNegative(float value, const char* argument) {
  if (!(value >= 0.0f) || !std::isfinite(value))
    throwValueError(argument, "is " + std::to_string(value) + ": expected a finite number of at least 0");
}

unsigned threadsOf(int threads) {
  if (threads < 0) throwValueError("threads", "is " + std::to_string(threads) + ": expected 0 (all) or more");
  return threadCount(threads);
}

/* --- building ------------------------------------------------------------------ */

/* "cleaf^3", or "cleaf" and a frame level: a number, "auto", or None. */
Representation readRepresentation(const std::string& name, const py::object& frameLevel) {
  const std::vector<Representation> one = parseRepresentations(
      name, frameLevel.is_none() ? Representation().frameLevel : parseFrameLevel(py::str(frameLevel)));
  if (one.size() != 1) throwValueError("representation", "'" + name + "' names several representations: expected one");
  return one.front();
}

void requireMemory(const Model& model, const Representation& representation, int level) {
  const BuildSize size(model, level);
  const size_t needed = estimatedPeakBytes(representation.kind, size), available = availableMemory();
  if (needed <= available) return;
  char text[200];
  std::snprintf(text, sizeof(text),
                "not enough memory: %s on %.1f million quads needs about %.1f GiB, but %.1f GiB are free",
                representation.label().c_str(), double(size.quads) * 1e-6, double(needed) / (1 << 30),
                double(available) / (1 << 30));
  PyErr_SetString(PyExc_MemoryError, text);
  throw py::error_already_set();
}

PixelBound readPixelBound(float pixels, const std::optional<Camera>& camera) {
  requireNotNegative(pixels, "max_pixel_error");
  if (pixels == 0.0f) return {};
  if (!camera) throwValueError("max_pixel_error", "is given without a camera: expected both");
  return {pixels, camera->eye(), camera->footprint()};
}

std::shared_ptr<Scene> build(const std::shared_ptr<Model>& model, const std::string& name, int level,
                             const py::object& frameLevel, const std::optional<float>& maxError, float maxPixelError,
                             const std::optional<Camera>& camera, int threads, const std::string& isa,
                             const std::string& device, const py::object& progress) {
  const Representation representation = readRepresentation(name, frameLevel);
  if (maxError) requireNotNegative(*maxError, "max_error");
  BuildSettings settings;
  settings.level = level;
  settings.threads = threads;
  if (maxError) settings.maxError = *maxError;
  settings.pixelBound = readPixelBound(maxPixelError, camera);
  settings.isa = isa;
  settings.device = device;
  validateBuild(settings);
  requireMemory(*model, representation, level);
  auto scene = interruptible(progress, [&] { return std::make_shared<Scene>(model, representation, settings); });
  warn(seamWarnings(*model, scene->built.report().seams));
  return scene;
}

/* --- tracing ------------------------------------------------------------------- */

Hits intersect(const Scene& scene, const py::object& origins, const py::object& directions, const py::object& tnear,
               const py::object& tfar, const py::object& time, int threads) {
  const unsigned n = threadsOf(threads);
  Rays rays = readRays(origins, directions, tnear, tfar, time);
  return interruptible(py::none(),
                       [&] { return scene.hitsOf(std::move(rays.shape), traceClosest(scene.built, rays.rays, n)); });
}

std::vector<char> anyHits(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads) {
  constexpr size_t chunk = 4096;
  std::vector<char> hit(rays.size());
  parallelFor(rays.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    std::vector<RTCRay> batch(end - begin);
    for (size_t i = begin; i < end; i++) load(rays[i], batch[i - begin]);
    scene.tracer().occluded(batch.data(), batch.size());
    for (size_t i = begin; i < end; i++) hit[i] = batch[i - begin].tfar < 0.0f && !(rays[i].tfar < 0.0f);
  });
  return hit;
}

/* Here and below, Traced is Scene or LoadedScene. */
template<typename Traced>
py::array_t<bool> occluded(const Traced& scene, const py::object& origins, const py::object& directions,
                           const py::object& tnear, const py::object& tfar, const py::object& time, int threads) {
  const unsigned n = threadsOf(threads);
  const Rays rays = readRays(origins, directions, tnear, tfar, time);
  const std::vector<char> hit = interruptible(py::none(), [&] {
    const std::vector<char> hits = anyHits(scene.traced(), rays.rays, n);
    scene.traced().check();
    return hits;
  });
  return arrayOf<bool>(rays.shape, [&](size_t i) { return hit[i] != 0; });
}

template<typename Traced>
double traceSeconds(const Traced& scene, const py::object& origins, const py::object& directions,
                    const std::string& query, const std::string& mode, bool coherent, int threads, unsigned passes) {
  TraceSettings settings;
  settings.query = parseQuery(query);
  settings.mode = parseTraceMode(mode);
  settings.coherent = coherent;
  settings.threads = threadsOf(threads);
  settings.passes = passes;
  if (passes < 1) throwValueError("passes", "is 0: expected 1 or more");
  const Rays rays = readRays(origins, directions);
  return interruptible(py::none(), [&] {
    const double seconds = timeTrace(scene.traced(), rays.rays, settings).seconds;
    scene.traced().check();
    return seconds;
  });
}

py::tuple closestPointsOf(const Scene& scene, const py::object& points, const py::object& radius,
                          const py::object& time, int threads) {
  const Representation& representation = scene.built.representation();
  if (!representation.isExact())
    throw Error("finding closest points: " + representation.label() +
                " stores no triangles that can be searched: expected cTILE or cVERT");
  return closestPoints(scene.built, scene.model->cage.numFaces(), scene.model->numFaces(), points, radius, time,
                       threadsOf(threads));
}

Camera cameraOf(const Scene& scene, const std::string& view, std::pair<int, int> size) {
  choice(view, "view", {"full", "close"});
  const ImageSize image = imageSize(size);
  const auto choose = [&] { return chooseCamera(view, *scene.model, scene.built, image, threadCount(0)); };
  return interruptible(py::none(), choose);
}

/* --- files ----------------------------------------------------------------------- */

void save(const Scene& scene, const std::filesystem::path& path) {
  if (!scene.built.representation().isCompressed())
    throwValueError("path", "only compressed scenes can be saved: expected another representation than " +
                                scene.built.representation().label());
  interruptible(py::none(), [&] {
    scene.built.save(path.string());
    return 0;
  });
}

std::shared_ptr<LoadedScene> loadFile(const std::filesystem::path& path, int threads) {
  const unsigned n = threadsOf(threads);
  return interruptible(py::none(), [&] { return std::make_shared<LoadedScene>(path.string(), n); });
}

Hits intersectLoaded(const LoadedScene& scene, const py::object& origins, const py::object& directions,
                     const py::object& tnear, const py::object& tfar, const py::object& time, int threads) {
  const unsigned n = threadsOf(threads);
  Rays rays = readRays(origins, directions, tnear, tfar, time);
  return interruptible(py::none(), [&] {
    std::vector<SurfaceHit> hits = traceClosest(scene.saved, rays.rays, n);
    scene.saved.check();
    const size_t facesPerCopy = scene.saved.facesPerCopy(), faces = facesPerCopy * scene.saved.geometries().size();
    return Hits{std::move(rays.shape), std::move(hits), facesPerCopy, faces};
  });
}

py::tuple closestPointsOfLoaded(const LoadedScene& scene, const py::object& points, const py::object& radius,
                                const py::object& time, int threads) {
  const size_t facesPerCopy = scene.saved.facesPerCopy(), faces = facesPerCopy * scene.saved.geometries().size();
  return closestPoints(scene.saved, facesPerCopy, faces, points, radius, time, threadsOf(threads));
}

Camera cameraOfLoaded(const LoadedScene& scene, const std::string& view, std::pair<int, int> size) {
  choice(view, "view", {"full", "close"});
  const ImageSize image = imageSize(size);
  return interruptible(py::none(), [&] {
    const Model box = boxModel(scene.path, scene.saved.bounds());
    const Camera camera = chooseCamera(view, box, scene.saved, image, threadCount(0));
    scene.saved.check();
    return camera;
  });
}

/* --- statistics ---------------------------------------------------------------- */

py::object statistics(const Scene& scene) {
  const BuildReport& report = scene.built.report();
  nlohmann::ordered_json j{{"representation", scene.built.representation().label()},
                           {"level", scene.level},
                           {"quads", report.quads},
                           {"bytes_per_quad", report.bytesPerQuad()},
                           {"live_bytes", report.liveBytes},
                           {"peak_bytes", report.peakBytes},
                           {"build_seconds", report.seconds},
                           {"distance_from_mesh", report.distanceFromMesh()},
                           {"seam_gap", report.seams.distance},
                           {"seam_gap_quads", report.seams.quads}};
  if (scene.built.representation().isCompressed()) j["compression"] = compressionJson(report.compression);
  return objectOf(j);
}

/* --- errors -------------------------------------------------------------------- */

void requireHitsOf(const Scene& scene, const Hits& hits, const char* argument) {
  if (hits.faces != scene.model->numFaces())
    throwValueError(argument, "are of a model of " + std::to_string(hits.faces) + " faces: expected " +
                                  std::to_string(scene.model->numFaces()));
}

void requirePositive(float footprint) {
  if (!(footprint > 0.0f) || !std::isfinite(footprint))
    throwValueError("pixel_size", "is " + std::to_string(footprint) + ": expected a finite number above 0");
}

py::array_t<float> pixelErrorsOf(const Hits& hits, const Hits& reference, float footprint) {
  requireRays(reference, "reference", hits.hits.size(), "hits");
  requirePositive(footprint);
  const std::vector<float> errors = pixelErrors(reference.hits, hits.hits, footprint);
  return arrayOf<float>(hits.shape, [&](size_t i) { return errors[i] < 0.0f ? NAN : errors[i]; });
}

py::object errorsOf(const Scene& scene, const Hits& hits, const Hits& reference, float footprint) {
  requireHitsOf(scene, hits, "hits");
  requireHitsOf(scene, reference, "reference");
  requireRays(reference, "reference", hits.hits.size(), "hits");
  requirePositive(footprint);
  return objectOf(errorsJson(compareHits(reference.hits, hits.hits, footprint, scene.built.layout())));
}

py::object trueErrorsOf(const Scene& scene, const Hits& hits, const py::object& origins, const py::object& directions,
                        float footprint, size_t count, uint32_t seed, int threads, const py::object& progress) {
  requireHitsOf(scene, hits, "hits");
  requirePositive(footprint);
  const unsigned n = threadsOf(threads);
  const Rays rays = readRays(origins, directions);
  requireRays(hits, "hits", rays.rays.size(), "origins and directions");
  return objectOf(errorsJson(interruptible(progress, [&] {
    const TrueSurfaces surfaces(*scene.model);
    const TrueView view{*scene.model, surfaces, rays.rays, sampleHits(hits.hits, count, seed), footprint};
    return compareToTrueSurface(view, hits.hits, scene.built.layout(), n);
  })));
}

/* --- stored surface --------------------------------------------------------------- */

py::array_t<float> trianglesOf(const Scene& scene, const Hits& hits, float time) {
  requireHitsOf(scene, hits, "hits");
  requireTime(time);
  Shape shape = hits.shape;
  shape.insert(shape.end(), {3, 3});
  py::array_t<float> array(shape);
  Vec3f* const out = reinterpret_cast<Vec3f*>(array.mutable_data());
  interruptible(py::none(), [&] {
    for (size_t i = 0; i < hits.hits.size(); i++)
      if (!scene.built.triangleOf(hits.hits[i], time, out + 3 * i)) std::fill_n(out + 3 * i, 3, Vec3f{NAN, NAN, NAN});
    return 0;
  });
  return array;
}

py::dict storedMesh(const Scene& scene, float time) {
  requireTime(time);
  const StoredMesh mesh = interruptible(py::none(), [&] { return scene.built.storedMesh(time); });
  py::dict result;
  const auto coordinate = [&](size_t i) { return (&mesh.vertices[i / 3].x)[i % 3]; };
  const auto corner = [&](size_t i) { return mesh.quads[i / 4][i % 4]; };
  result["vertices"] = arrayOf<float>({py::ssize_t(mesh.vertices.size()), 3}, coordinate);
  result["quads"] = arrayOf<unsigned>({py::ssize_t(mesh.quads.size()), 4}, corner);
  result["primID"] = arrayOf<unsigned>({py::ssize_t(mesh.faces.size())}, [&](size_t i) { return mesh.faces[i]; });
  return result;
}

/* --- docstrings ---------------------------------------------------------------- */

/* Representations for which a predicate is true, "cgrid, cvoxel". */
std::string wordsOf(bool (Representation::*is)() const, const std::string& quote) {
  std::string words;
  for (RepresentationKind kind : representationKinds())
    if ((Representation{kind}.*is)()) words += (words.empty() ? "" : ", ") + quote + optionNameOf(kind) + quote;
  return words;
}

std::string buildText() {
  return R"(Builds a model in one representation and returns a Scene.

model: a Model, or a Cage, which is not displaced.
representation: a compressed one: )" +
         wordsOf(&Representation::isCompressed, "\"") + R"(; or "grid", Embree's own, or
  "naive", its triangles, or "naive-compact", these in Embree's compact mode. A frame level may follow: "cleaf^3".
  "cleaf" stores faces that its leaves approximate badly as "cvert" does; "cleaf-only" has leaves for all
  faces, as in the paper.
level: )" +
         levelRange() + R"(, 2**level x 2**level quads per face of 4 vertices. Other faces have a quarter as many per
  corner, at least 1.
frame_level: )" +
         levelRange() + R"(, for 4**frame_level frames per face, or "auto" (the default); only for
  )" + wordsOf(&Representation::hasFrames, "") +
         R"(.
max_error: bound in world units on the spacing of the lattice of ctile and cvert, where 0 stores vertices exactly, and
  on the thickness of leaves if frame_level is "auto". None selects the library's default.
max_pixel_error: bound on the spacing of that lattice in pixels of camera, 0 for none.
threads: for building, 0 for all.
isa: widest instruction set to use: "sse2", "sse4.2", "avx", "avx2" or "avx512"; default the host's best.
device: device that traces: "cpu", "vulkan", or "ray-query" (ray queries of a Vulkan driver). Append :N or :NAME to the
  last two to choose a device by its index or a part of its name.
progress: called with the name of a phase and the fraction done, 0 to 1. An exception that it raises stops the build.

Ctrl-C (KeyboardInterrupt) stops the build. Other Python threads keep running; if they call this module to build or to
trace, they wait until it is their turn. Raises ValueError or TypeError for invalid arguments, MemoryError if there is
not enough memory, and Error for other reasons, with Embree's message.)";
}

constexpr const char* intersectText = R"(Finds the closest hit of each ray and returns Hits.

origins: (..., 3), world units.
directions: (..., 3), of any length; distances are multiples of the length.
tnear, tfar: (...), range of distances in which hits are found.
time: (...), 0 to 1, for models that move: 0 is the first time step, 1 the last.
threads: 0 for all.

Arguments are converted to float32 and broadcast by NumPy's rules: one origin and a picture of directions return a
picture of hits. Ctrl-C stops the call. Calls by several Python threads run one after the other.

Raises ValueError or TypeError for invalid arguments, and Error if a block of a loaded file is damaged.)";

constexpr const char* occludedText =
    R"(Returns (...) bool: True if the ray hits anything. Arguments and errors as in intersect.)";

constexpr const char* closestText = R"(Finds the closest point of the surface for each point.

points: (..., 3), world units.
radius: (...), largest distance, may be inf.
time: (...), 0 to 1, for models that move.
threads: 0 for all.

Returns two results: positions, (..., 3) float32, the closest points in world units, NaN where none is within the
radius; and Hits, in which t is the distance, inf where there is none. Arguments are broadcast by NumPy's rules. Only
for ctile and cvert, whose stored triangles are searched. Ctrl-C stops the call.

Raises ValueError or TypeError for invalid arguments, and Error for other representations, or if a block of a loaded
file is damaged.)";

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

constexpr const char* statisticsText = R"(Returns statistics of the build as a dict.

Keys: representation, level, quads, bytes_per_quad, live_bytes (held after the build, including the cage), peak_bytes
(held during the build), build_seconds, distance_from_mesh (world units: a bound on the distance of hits from the mesh
of this level), seam_gap and seam_gap_quads (the largest distance between the two sides of a seam of texture
coordinates before their mean closed it, in units of the cage and in quads), and for compressed scenes compression, a
dict of bytes and counts. Names are those of `cbvh_render --json`.)";

constexpr const char* trianglesText = R"(Returns the stored triangle of each hit, (..., 3, 3) float32.

hits: hits in this scene.
time: time of the hits' rays, if the model moves.

Vertices are in world units, NaN for a miss or if no triangle is stored. Only for cvert and cgrid; raises Error for
other representations.)";

constexpr const char* storedMeshText = R"(Returns the whole stored surface as a dict of arrays.

time: 0 to 1, for models that move.

Keys: vertices, (n, 3) float32 in world units; quads, (m, 4) uint32, vertices in order around each quad; primID, (m,)
uint32, the face of each quad. A quad 00, 10, 11, 01 consists of the triangles 00, 10, 01 and 01, 10, 11. Parts
have up to 16 x 16 quads, in cgrid up to 256 x 256; vertices at their borders are repeated, as the same floats, in
cgrid only within a face. Only for cvert and cgrid; raises Error for other representations.)";

constexpr const char* saveText = R"(Saves a compressed scene to a file, which load() and cbvh_render --load open.

path: of the file, str or os.PathLike. An existing file is replaced when the new one is complete.

Raises ValueError if the scene is not compressed, and Error if the file cannot be written.)";

constexpr const char* loadText =
    R"(Opens a file that Scene.save or `cbvh_render --save` wrote, and returns a LoadedScene.

path: of the file, str or os.PathLike. The file must not be modified while it is open.
threads: of the device, 0 for all.

The scene has no model, but the same hits to the bit. The file is mapped: parts that no ray reaches stay on disk. Raises
Error with the reason for a file that is truncated, altered, of another version, or not such a file.)";

constexpr const char* errorsText =
    R"(Compares hits with a reference and returns a dict with the names of `cbvh_render --json`.

hits: hits in this scene.
reference: hits of the same rays in another representation of the same model.
pixel_size: width of a pixel at distance 1 (Camera.pixel_size); directions must have unit length.

rmse_pixels, median_pixels, p99_pixels and max_pixels describe distances between hit points. inlier_rmse_pixels and
bias_pixels (above 0: behind the reference) exclude distances beyond 5 pixels, which usually mean another sheet of the
surface. false_hits and misses count rays that hit in only one of both. Normals are in degrees, u and v in quads.)";

constexpr const char* trueErrorsText =
    R"(Compares hits with the true surface and returns a dict with the names of `cbvh_render --json`.

hits: hits in this scene of the rays origins and directions, which must have unit length.
pixel_size: width of a pixel at distance 1 (Camera.pixel_size).
count, seed: number and seed of the hits that are chosen at random.
threads: 0 for all.
progress: called with the name of a phase and the fraction done, 0 to 1.

The true surface is OpenSubdiv's limit surface with the unfiltered displacement. The error is that of tessellation and
compression together.)";

constexpr const char* pixelErrorsText =
    R"(Returns the distance between the hit points of each ray in pixels, (...) float32.

hits, reference: hits of the same rays, whose directions must have unit length.
pixel_size: width of a pixel at distance 1 (Camera.pixel_size).

The distance is NaN unless both hit.)";

} // namespace

void defineScene(py::module_& module) {
  using py::arg;
  const py::float_ zero(0.0), infinity(INFINITY);
  py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene", "A model built in one representation, see build().")
      .def("intersect", &intersect, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("time") = zero, arg("threads") = 0, intersectText)
      .def("occluded", &occluded<Scene>, arg("origins"), arg("directions"), arg("tnear") = zero, arg("tfar") = infinity,
           py::kw_only(), arg("time") = zero, arg("threads") = 0, occludedText)
      .def("closest_points", &closestPointsOf, arg("points"), arg("radius") = infinity, py::kw_only(),
           arg("time") = zero, arg("threads") = 0, closestText)
      .def("trace_seconds", &traceSeconds<Scene>, arg("origins"), arg("directions"), py::kw_only(),
           arg("query") = "closest", arg("mode") = "single", arg("coherent") = false, arg("threads") = 1,
           arg("passes") = 1, secondsText)
      .def("camera", &cameraOf, arg("view") = "full", arg("size") = std::pair<int, int>(1024, 1024), cameraText)
      .def("statistics", &statistics, statisticsText)
      .def("triangles", &trianglesOf, arg("hits"), py::kw_only(), arg("time") = 0.0f, trianglesText)
      .def("stored_mesh", &storedMesh, py::kw_only(), arg("time") = 0.0f, storedMeshText)
      .def("save", &save, arg("path"), saveText)
      .def("compare", &errorsOf, arg("hits"), arg("reference"), arg("pixel_size"), errorsText)
      .def("true_errors", &trueErrorsOf, arg("hits"), arg("origins"), arg("directions"), arg("pixel_size"),
           py::kw_only(), arg("count") = 2000, arg("seed") = 1, arg("threads") = 0, arg("progress") = py::none(),
           trueErrorsText)
      .def_property_readonly(
          "bounds", [](const Scene& s) { return arrayOf(s.built.bounds()); },
          "(2, 3) float32: lower and upper corner of the surface's bounding box, world units.")
      .def_property_readonly(
          "model", [](const Scene& s) { return std::const_pointer_cast<Model>(s.model); }, "The Model.")
      .def_property_readonly(
          "representation", [](const Scene& s) { return s.built.representation().label(); },
          "Label; with a frame level as in the paper: 'cLEAF^2'.")
      .def_readonly("level", &Scene::level, "2**level x 2**level quads per face.")
      .def("__repr__", [](const Scene& s) {
        char bytes[32];
        std::snprintf(bytes, sizeof(bytes), "%.2f", s.built.report().bytesPerQuad());
        return stringOf("<Scene '" + s.model->name + "' in " + s.built.representation().label() + " at level " +
                        std::to_string(s.level) + ": " + std::to_string(s.built.report().quads) + " quads, " + bytes +
                        " bytes each>");
      });

  py::class_<LoadedScene, std::shared_ptr<LoadedScene>>(module, "LoadedScene",
                                                        "Compressed geometries of a file, see load().")
      .def("intersect", &intersectLoaded, arg("origins"), arg("directions"), arg("tnear") = zero,
           arg("tfar") = infinity, py::kw_only(), arg("time") = zero, arg("threads") = 0, intersectText)
      .def("occluded", &occluded<LoadedScene>, arg("origins"), arg("directions"), arg("tnear") = zero,
           arg("tfar") = infinity, py::kw_only(), arg("time") = zero, arg("threads") = 0, occludedText)
      .def("closest_points", &closestPointsOfLoaded, arg("points"), arg("radius") = infinity, py::kw_only(),
           arg("time") = zero, arg("threads") = 0, closestText)
      .def("trace_seconds", &traceSeconds<LoadedScene>, arg("origins"), arg("directions"), py::kw_only(),
           arg("query") = "closest", arg("mode") = "single", arg("coherent") = false, arg("threads") = 1,
           arg("passes") = 1, secondsText)
      .def("camera", &cameraOfLoaded, arg("view") = "full", arg("size") = std::pair<int, int>(1024, 1024), cameraText)
      .def_property_readonly(
          "quads", [](const LoadedScene& s) { return s.saved.quads(); }, "Number of quads of all geometries.")
      .def_property_readonly(
          "geometries", [](const LoadedScene& s) { return s.saved.geometries().size(); }, "Number of geometries.")
      .def_property_readonly(
          "open_seconds", [](const LoadedScene& s) { return s.saved.seconds(); },
          "Time for opening the file and committing the scene, in seconds.")
      .def_property_readonly(
          "bounds", [](const LoadedScene& s) { return arrayOf(s.saved.bounds()); },
          "(2, 3) float32: lower and upper corner of the surface's bounding box, world units.")
      .def("__repr__", [](const LoadedScene& s) {
        const size_t n = s.saved.geometries().size();
        return stringOf("<LoadedScene '" + s.path + "': " + std::to_string(n) +
                        (n == 1 ? " geometry, " : " geometries, ") + std::to_string(s.saved.quads()) + " quads>");
      });
  module.def("load", &loadFile, arg("path"), py::kw_only(), arg("threads") = 0, loadText);
  module.def("build", &build, arg("model"), arg("representation") = optionNameOf(preferredKind), arg("level") = 6,
             py::kw_only(), arg("frame_level") = py::none(), arg("max_error") = py::none(),
             arg("max_pixel_error") = 0.0f, arg("camera") = py::none(), arg("threads") = 0, arg("isa") = "",
             arg("device") = "cpu", arg("progress") = py::none(), buildText().c_str());
  module.def("pixel_errors", &pixelErrorsOf, arg("hits"), arg("reference"), arg("pixel_size"), pixelErrorsText);
}

} // namespace programs::python
