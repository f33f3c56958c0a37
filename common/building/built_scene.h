// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/edge_rates.h"
#include "building/embree_device.h"
#include "building/representation.h"
#include "building/stored_surface.h"
#include "building/subdivision_geometry.h"
#include "building/traced_scene.h"
#include "building/vulkan_tracer.h"
#include "surface/model.h"

#include <embree3/rtcore_compression.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace programs {

/* Largest spacing of cVERT's lattice, in pixels of a camera. */
struct PixelBound {
  float pixels = 0; // 0 for none
  Vec3f eye;
  float footprint = 0; // width of a pixel at a distance of 1
};

struct BuildSettings {
  int level = 6;
  std::shared_ptr<const EdgeRates> rates; // replaces `level` if set; not for triangles or meshes
  int threads = 0;                        // 0 for all

  /* cVERT: the coarsest lattice spacing, 0 for lossless. cLEAF and cVOXEL with an automatic frame level: the largest
   * thickness of leaves, 0 for no bound. Negative: the library's default, or Model::spacing if a mesh has one. */
  float maxError = -1;

  PixelBound pixelBound;
  bool filters = false;       // call the filter functions of intersect contexts
  std::string isa;            // Embree's name of the widest instruction set, empty for the best
  std::string device = "cpu"; // tracing device: "cpu", "vulkan", "ray-query", "vulkan:NAME" or "ray-query:NAME"
  std::string name;           // for progress; empty for the representation's label
};

/* Throws Error that names --level, --threads, --isa or --device and its value. */
void validateBuild(const BuildSettings& settings);

std::string deviceConfig(const Representation& representation, const BuildSettings& settings);
RTCCompressionArguments compressionArguments(const BuildSettings& settings);

/* Fraction of quads that cLEAF stores as cVERT, in [0,1]. */
inline double fallbackQuadFraction(const RTCCompressionStatistics& s) {
  return s.numQuads ? double(s.numFallbackQuads) / double(s.numQuads) : 0.0;
}

struct BuildReport {
  double seconds = 0;        // for committing geometries and scene
  size_t liveBytes = 0;      // after the commit, including buffers and cage
  size_t peakBytes = 0;      // maximum during the commit
  size_t largePageBytes = 0; // of the process, by which large pages grew during the commit
  size_t quads = 0;
  RTCCompressionStatistics compression{};    // all zero for NAIVE and GRID
  SeamGap seams;                             // closed by the displacement
  std::optional<VulkanSceneReport> onDevice; // set if a Vulkan device traces

  /* The thickness of leaves, or the movement of vertices plus the width of gaps between faces. */
  float distanceFromMesh() const {
    return std::max(compression.maxLeafThickness, compression.maxVertexDeviation + compression.maxBorderMismatch);
  }

  double bytesPerQuad() const { return quads ? double(liveBytes) / double(quads) : 0.0; }

  double fallbackFraction() const { return fallbackQuadFraction(compression); }
};

class BuiltScene : public TracedScene {
public:
  /* Shows progress. The model must outlive the scene. Throws Error with Embree's message. */
  BuiltScene(const Model& model, const Representation& representation, const BuildSettings& settings);

  RTCScene handle() const override { return scene.get(); }
  const SceneTracer& tracer() const override {
    return vulkanTracer ? static_cast<const SceneTracer&>(*vulkanTracer) : *embreeTracer;
  }
  const VulkanTracer* vulkan() const override { return vulkanTracer.get(); }

  const Representation& representation() const { return builtAs; }
  const BuildReport& report() const { return built; }
  const PatchLayout& layout() const { return patches; }
  FaceNumbers faces() const { return FaceNumbers(std::vector<size_t>(numGeometries, facesPerCopy)); }

  /* Saves a compressed scene (saved_scene.h). Replaces the file only on success. Throws Error. */
  void save(const std::string& path) const;

  /* Throws Error if Embree has reported an error. */
  void check() const override { device->check("tracing"); }

  /* Hits on NAIVE's triangles are converted to faces and (u,v). */
  SurfaceHit surfaceHit(const RTCRayHit& ray) const override;

  /* Throws Error except for cTILE, cVERT and cGRID. `operation` names the operation in the message. */
  void requireTriangles(const char* operation) const;

  /* Throws Error as requireTriangles. */
  StoredMesh storedMesh(float time = 0) const;

private:
  void buildSubdivision(const Model& model, const BuildSettings& settings);
  void buildTriangles(const Model& model, const BuildSettings& settings);
  void buildMesh(const Model& model, const BuildSettings& settings);
  void readStatistics();
  void fillTriangles(RTCGeometry triangles, const PatchLayout& layout, const BuildSettings& settings);
  void commit(const char* operation);

  Representation builtAs;
  std::string name;
  PatchLayout patches;
  std::shared_ptr<const EdgeRates> rates; // referenced by contexts
  size_t facesPerCopy, quadsPerCopy, numGeometries;
  std::vector<DisplacementContext> contexts;
  std::unique_ptr<SeamGaps> gaps = std::make_unique<SeamGaps>(); // contexts refer to it
  std::unique_ptr<EmbreeDevice> device;
  SceneHandle scene; // released before its device
  std::unique_ptr<EmbreeTracer> embreeTracer;
  std::unique_ptr<VulkanTracer> vulkanTracer; // released before its scene
  bool splitsQuads = false;                   // true if hits are on NAIVE's triangles, two per quad
  BuildReport built;
};

/* Vertices of all patches of all copies, in the order of the model's layout, at the first time step: GRID's vertices to
 * the bit. Throws Error. */
std::vector<Vec3f> tessellate(const Model& model, const BuildSettings& settings);

} // namespace programs
