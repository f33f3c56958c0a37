// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "geometry_scene.h"
#include "interruptible.h"
#include "json_objects.h"

#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "basics/seconds.h"
#include "building/built_scene.h"
#include "building/saved_scene.h"
#include "programs/compression_json.h"
#include "programs/view_options.h"

namespace programs::python {
namespace {

int reportProgress(void* phase, double done) {
  static_cast<Phase*>(phase)->update(done);
  return !cancelRequested();
}

bool reportSceneProgress(void* phase, double done) { return reportProgress(phase, done) != 0; }

BuildSettings settingsOf(unsigned threads, const std::string& isa) {
  BuildSettings settings;
  settings.threads = int(threads);
  settings.isa = isa;
  validateBuild(settings);
  return settings;
}

} // namespace

BuiltGeometries::BuiltGeometries(const Representation& representation, unsigned threads, const std::string& isa)
  : device(std::make_unique<EmbreeDevice>(deviceConfig(representation, settingsOf(threads, isa)))),
    scene(rtcNewScene(device->handle())) {}

void BuiltGeometries::add(const Geometry& geometry, const std::string& name) {
  const auto* input = dynamic_cast<const SurfaceGeometry*>(&geometry);
  if (!input) {
    addModel(dynamic_cast<const ModelGeometry&>(geometry));
    return;
  }
  const SurfaceHandle surface = build(*input, name);
  const GeometryHandle built(rtcNewGeometryFromSurface(device->handle(), surface.get()));
  check("adding a surface");
  attach(built.get(), geometry.numPrimitives());
}

SurfaceHandle BuiltGeometries::build(const SurfaceGeometry& geometry, const std::string& name) const {
  const std::string operation = "building " + name;
  CbvhSurface made = nullptr;
  cbvhNewSurface(context().get(), &made);
  SurfaceHandle surface(made);
  check(operation.c_str());
  if (geometry.maxError && *geometry.maxError == 0.0f) cbvhSetSurfaceLossless(surface.get(), 1);
  else if (geometry.maxError) {
    CbvhAccuracy accuracy = CbvhAccuracy();
    accuracy.maxError = *geometry.maxError;
    cbvhSetSurfaceAccuracy(surface.get(), &accuracy);
  }
  std::vector<Vec3f> scratch;
  geometry.setInput(surface.get(), scratch);
  check(operation.c_str());
  {
    Phase phase(name);
    cbvhCommitSurface(surface.get(), reportProgress, &phase);
  }
  check(operation.c_str());
  return surface;
}

/* The commit of the scene tessellates the model. */
void BuiltGeometries::addModel(const ModelGeometry& geometry) {
  const Model& model = *geometry.model;
  models.push_back(geometry.model);
  contexts.push_back(std::make_unique<DisplacementContext>());
  setDisplacement(*contexts.back(), model, 0, geometry.level, nullptr);
  RTCCompressionArguments arguments = compressionArguments(BuildSettings());
  if (geometry.maxError) arguments.maxError = *geometry.maxError;
  const SharedTopology topology(*device, model.cage, model.poses);
  attach(topology.makeGeometry(model.copies[0], *contexts.back(), &arguments, model.shapeOf(0)).get(),
         geometry.numPrimitives());
}

void BuiltGeometries::attach(RTCGeometry geometry, size_t faces) {
  rtcAttachGeometryByID(scene.get(), geometry, unsigned(facesOfGeometries.size()));
  check("attaching a geometry");
  facesOfGeometries.push_back(faces);
  throwIfCanceled();
}

void BuiltGeometries::commit() {
  numbers = FaceNumbers(facesOfGeometries);
  {
    Phase phase("scene");
    rtcSetSceneProgressMonitorFunction(scene.get(), reportSceneProgress, &phase);
    rtcCommitScene(scene.get());
    rtcSetSceneProgressMonitorFunction(scene.get(), nullptr, nullptr);
  }
  check("committing the scene");
  embreeTracer = std::make_unique<EmbreeTracer>(scene.get());
}

SurfaceHit BuiltGeometries::surfaceHit(const RTCRayHit& ray) const { return surfaceHitOf(ray, numbers); }

RTCCompressionStatistics BuiltGeometries::compression() const { return compressionOf(*device, scene.get()); }

void BuiltGeometries::save(const std::string& path) const {
  saveGeometries(*device, scene.get(), facesOfGeometries.size(), path);
}

Representation readExactRepresentation(const std::string& name) {
  for (const RepresentationKind kind : {RepresentationKind::CTile, RepresentationKind::CVert})
    if (optionNameOf(kind) == name) return {kind};
  throwValueError("representation", "is '" + name + "': expected 'ctile' or 'cvert'; build() has others for models");
}

SavedScene::Form readForm(const std::string& representation) {
  const bool isTiled = readExactRepresentation(representation).kind == RepresentationKind::CTile;
  return isTiled ? SavedScene::Form::Tiles : SavedScene::Form::Mapped;
}

namespace {

class GeometryScene : public Scene {
public:
  GeometryScene(std::unique_ptr<const BuiltGeometries> scene, std::string representation, double seconds)
    : Scene(scene->faces()),
      built(std::move(scene)),
      representation(std::move(representation)),
      seconds(seconds) {}

  const TracedScene& traced() const override { return *built; }

  Camera camera(const std::string& view, ImageSize size) const override {
    return chooseCamera(view, boxModel("scene", built->bounds()), *built, size, threadCount(0));
  }

  void save(const std::string& path) const override { built->save(path); }

  py::object statistics() const override {
    const RTCCompressionStatistics compression = built->compression();
    const double bytes = double(built->liveBytes());
    return objectOf(
        nlohmann::ordered_json{{"representation", representation},
                               {"quads", compression.numQuads},
                               {"bytes_per_quad", compression.numQuads ? bytes / double(compression.numQuads) : 0.0},
                               {"live_bytes", built->liveBytes()},
                               {"peak_bytes", built->peakBytes()},
                               {"build_seconds", seconds},
                               {"compression", compressionJson(compression)}});
  }

  std::string repr() const override {
    return "<Scene in " + representation + ": " + countText(faces()->numGeometries(), "geometry") + ", " +
           countText(built->compression().numQuads, "quad") + ">";
  }

private:
  std::unique_ptr<const BuiltGeometries> built;
  std::string representation;
  double seconds;
};

/* Accepts models and cages, too. */
std::vector<std::shared_ptr<const Geometry>> readGeometries(const py::iterable& items) {
  const py::object subdivision = py::type::of<ModelGeometry>();
  std::vector<std::shared_ptr<const Geometry>> result;
  for (const py::handle item : items) {
    if (py::isinstance<Geometry>(item)) result.push_back(item.cast<std::shared_ptr<Geometry>>());
    else if (py::isinstance<Model>(item) || py::isinstance<Cage>(item))
      result.push_back(subdivision(item).cast<std::shared_ptr<Geometry>>());
    else
      throw py::type_error("geometries: item " + std::to_string(result.size()) + " is a " +
                           std::string(py::str(py::type::of(item).attr("__name__"))) +
                           ": expected a Grid, Mesh, Subdivision, Model or Cage");
  }
  if (result.empty()) throwValueError("geometries", "is empty: expected at least one geometry");
  return result;
}

} // namespace

std::shared_ptr<Scene> buildGeometries(const py::iterable& geometries, const std::string& representation, int threads,
                                       const std::string& isa, const py::object& progress) {
  const std::vector<std::shared_ptr<const Geometry>> items = readGeometries(geometries);
  const Representation kind = readExactRepresentation(representation);
  const unsigned n = threadsOf(threads);
  return interruptibleBuild(progress, [&]() -> std::shared_ptr<Scene> {
    auto scene = std::make_unique<BuiltGeometries>(kind, n, isa);
    const double seconds = secondsOf([&] {
      for (size_t i = 0; i < items.size(); i++)
        scene->add(*items[i], "geometry " + std::to_string(i) + ", " + items[i]->description());
      scene->commit();
    });
    return std::make_shared<GeometryScene>(std::move(scene), kind.label(), seconds);
  });
}

const char* const buildGeometriesText = R"(Builds geometries into one scene.

geometries: any mixture of Grid, Mesh, Subdivision, Model and Cage. Hits have the index in this sequence as geomID.
representation: "ctile", or "cvert", which is smaller and slower.
threads: for building, 0 for all.
isa: widest instruction set to use: "sse2", "sse4.2", "avx", "avx2" or "avx512"; default the host's best.
progress: called with the name of a phase and the fraction done, 0 to 1. An exception that it raises stops the build.

The arrays of the geometries are read during the call, and are not needed afterwards. Ctrl-C (KeyboardInterrupt) stops
the build. Other Python threads keep running, and may trace. Builds of several threads run one after the other.

Raises ValueError or TypeError for invalid arguments, and Error for other reasons, with Embree's message.)";

} // namespace programs::python
