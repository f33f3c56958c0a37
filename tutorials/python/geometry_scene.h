// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Scenes of geometries of any kind. */

#include "geometry.h"
#include "scene.h"

#include "building/embree_device.h"
#include "building/representation.h"
#include "building/saved_scene.h"
#include "building/subdivision_geometry.h"
#include "building/surface_handles.h"
#include "building/traced_scene.h"

#include <memory>
#include <string>
#include <vector>

namespace programs::python {

/* Builds compressed geometries one by one, and then traces them together. Throws Error and Canceled. Uses no Python. */
class BuiltGeometries : public TracedScene {
public:
  BuiltGeometries(const Representation& representation, unsigned threads, const std::string& isa);

  /* Adds a geometry, whose ID is the number of those before. Its arrays are read during the call. */
  void add(const Geometry& geometry, const std::string& name);

  /* Builds a surface without adding it. */
  SurfaceHandle build(const SurfaceGeometry& geometry, const std::string& name) const;

  ContextHandle context() const { return contextOf(device->handle()); }

  /* Throws Error if an error occurred since the last call. */
  void check(const char* operation) const { device->check(operation); }

  /* Call it once, after all geometries were added. */
  void commit();

  RTCScene handle() const override { return scene.get(); }
  const SceneTracer& tracer() const override { return *embreeTracer; }
  SurfaceHit surfaceHit(const RTCRayHit& ray) const override;
  void check() const override { check("tracing"); }

  const FaceNumbers& faces() const { return numbers; }
  RTCCompressionStatistics compression() const;
  void save(const std::string& path) const;
  size_t liveBytes() const { return device->memory().live(); }
  size_t peakBytes() const { return device->memory().peak(); }

private:
  void addModel(const ModelGeometry& geometry);
  void attach(RTCGeometry geometry, size_t faces);

  std::unique_ptr<EmbreeDevice> device;
  SceneHandle scene; // released before its device
  std::unique_ptr<EmbreeTracer> embreeTracer;
  std::vector<std::shared_ptr<const Model>> models; // displacements refer to them
  std::vector<std::unique_ptr<DisplacementContext>> contexts;
  std::vector<size_t> facesOfGeometries;
  FaceNumbers numbers;
};

/* Implements the constructor of Scene. */
std::shared_ptr<Scene> buildGeometries(const py::iterable& geometries, const std::string& representation, int threads,
                                       const std::string& isa, const py::object& progress);
extern const char* const buildGeometriesText;

/* "ctile" or "cvert". Raises ValueError for other words. */
Representation readExactRepresentation(const std::string& name);
SavedScene::Form readForm(const std::string& representation);

} // namespace programs::python
