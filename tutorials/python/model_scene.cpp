// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "classes.h"
#include "hits.h"
#include "interruptible.h"
#include "json_objects.h"
#include "ray_arrays.h"
#include "scene.h"
#include "warning.h"

#include "basics/error.h"
#include "basics/parallel.h"
#include "building/built_scene.h"
#include "building/memory.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"
#include "programs/compression_json.h"
#include "programs/errors_json.h"
#include "programs/view_options.h"
#include "programs/warnings.h"

#include <pybind11/stl.h>

#include <cmath>
#include <cstdio>
#include <optional>

namespace programs::python {
namespace {

/* A model in one representation, for comparing representations. */
class ModelScene : public Scene {
public:
  ModelScene(std::shared_ptr<const Model> model, const Representation& representation, const BuildSettings& settings)
    : Scene(FaceNumbers(std::vector<size_t>(model->copies.size(), model->cage.numFaces()))),
      model(std::move(model)),
      level(settings.level),
      built(*this->model, representation, settings) {}

  const TracedScene& traced() const override { return built; }

  void requireTriangles(const char* operation) const override { built.requireTriangles(operation); }
  void requireSearchable(const char* operation) const override {
    if (!built.representation().isExact())
      throw Error(std::string(operation) + ": " + built.representation().label() +
                  " stores no triangles that can be searched: expected cTILE or cVERT");
  }

  Camera camera(const std::string& view, ImageSize size) const override {
    return chooseCamera(view, *model, built, size, threadCount(0));
  }

  void save(const std::string& path) const override {
    const Representation& representation = built.representation();
    if (!representation.isCompressed())
      throw std::invalid_argument("path: only compressed scenes can be saved: expected another representation than " +
                                  representation.label());
    built.save(path);
  }

  py::object statistics() const override {
    const BuildReport& report = built.report();
    nlohmann::ordered_json j{{"representation", built.representation().label()},
                             {"level", level},
                             {"quads", report.quads},
                             {"bytes_per_quad", report.bytesPerQuad()},
                             {"live_bytes", report.liveBytes},
                             {"peak_bytes", report.peakBytes},
                             {"build_seconds", report.seconds},
                             {"distance_from_mesh", report.distanceFromMesh()},
                             {"seam_gap", report.seams.distance},
                             {"seam_gap_quads", report.seams.quads}};
    if (built.representation().isCompressed()) j["compression"] = compressionJson(report.compression);
    return objectOf(j);
  }

  std::string repr() const override {
    char bytes[32];
    std::snprintf(bytes, sizeof(bytes), "%.2f", built.report().bytesPerQuad());
    return "<ModelScene '" + model->name + "' in " + built.representation().label() + " at level " +
           std::to_string(level) + ": " + std::to_string(built.report().quads) + " quads, " + bytes + " bytes each>";
  }

  std::shared_ptr<const Model> model; // must outlive `built`
  int level;
  BuiltScene built;
};

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

std::shared_ptr<ModelScene> build(const std::shared_ptr<Model>& model, const std::string& name, int level,
                                  const py::object& frameLevel, const std::optional<float>& maxError,
                                  float maxPixelError, const std::optional<Camera>& camera, int threads,
                                  const std::string& isa, const std::string& device, const py::object& progress) {
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
  auto scene =
      interruptibleBuild(progress, [&] { return std::make_shared<ModelScene>(model, representation, settings); });
  warn(seamWarnings(*model, scene->built.report().seams));
  return scene;
}

/* --- errors -------------------------------------------------------------------- */

void requirePositive(float footprint) {
  if (!(footprint > 0.0f) || !std::isfinite(footprint))
    throwValueError("pixel_size", "is " + std::to_string(footprint) + ": expected a finite number above 0");
}

py::array_t<float> pixelErrorsOf(const Hits& hits, const Hits& reference, float footprint) {
  requireRays(reference, "reference", hits.hits.size(), "hits");
  requirePositive(footprint);
  const std::vector<float> errors = pixelErrors(reference.vector(), hits.vector(), footprint);
  return arrayOf<float>(hits.shape, [&](size_t i) { return errors[i] < 0.0f ? NAN : errors[i]; });
}

py::object errorsOf(const ModelScene& scene, const Hits& hits, const Hits& reference, float footprint) {
  requireHitsOf(scene, hits, "hits");
  requireHitsOf(scene, reference, "reference");
  requireRays(reference, "reference", hits.hits.size(), "hits");
  requirePositive(footprint);
  return objectOf(errorsJson(compareHits(reference.vector(), hits.vector(), footprint, scene.built.layout())));
}

py::object trueErrorsOf(const ModelScene& scene, const Hits& hits, const py::object& origins,
                        const py::object& directions, float footprint, size_t count, uint32_t seed, int threads,
                        const py::object& progress) {
  requireHitsOf(scene, hits, "hits");
  requirePositive(footprint);
  const unsigned n = threadsOf(threads);
  const std::vector<Ray> rays = readRays(origins, directions).rays();
  requireRays(hits, "hits", rays.size(), "origins and directions");
  const std::vector<SurfaceHit> found = hits.vector();
  return objectOf(errorsJson(interruptibleBuild(progress, [&] {
    const TrueSurfaces surfaces(*scene.model);
    const TrueView view{*scene.model, surfaces, rays, sampleHits(found, count, seed), footprint};
    return compareToTrueSurface(view, found, scene.built.layout(), n);
  })));
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
  return R"(Builds a model in one representation and returns a ModelScene.

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

Ctrl-C (KeyboardInterrupt) stops the build. Other Python threads keep running, and may trace. Builds of several threads
run one after the other. Raises ValueError or TypeError for invalid arguments, MemoryError if there is not enough
memory, and Error for other reasons, with Embree's message.)";
}

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

void defineModelScene(py::module_& module) {
  using py::arg;
  py::class_<ModelScene, Scene, std::shared_ptr<ModelScene>>(module, "ModelScene",
                                                             "A model built in one representation, see build().")
      .def("compare", &errorsOf, arg("hits"), arg("reference"), arg("pixel_size"), errorsText)
      .def("true_errors", &trueErrorsOf, arg("hits"), arg("origins"), arg("directions"), arg("pixel_size"),
           py::kw_only(), arg("count") = 2000, arg("seed") = 1, arg("threads") = 0, arg("progress") = py::none(),
           trueErrorsText)
      .def_property_readonly(
          "model", [](const ModelScene& s) { return std::const_pointer_cast<Model>(s.model); }, "The Model.")
      .def_property_readonly(
          "representation", [](const ModelScene& s) { return s.built.representation().label(); },
          "Label; with a frame level as in the paper: 'cLEAF^2'.")
      .def_readonly("level", &ModelScene::level, "2**level x 2**level quads per face.");
  module.def("build", &build, arg("model"), arg("representation") = optionNameOf(preferredKind), arg("level") = 6,
             py::kw_only(), arg("frame_level") = py::none(), arg("max_error") = py::none(),
             arg("max_pixel_error") = 0.0f, arg("camera") = py::none(), arg("threads") = 0, arg("isa") = "",
             arg("device") = "cpu", arg("progress") = py::none(), buildText().c_str());
  module.def("pixel_errors", &pixelErrorsOf, arg("hits"), arg("reference"), arg("pixel_size"), pixelErrorsText);
}

} // namespace programs::python
