// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A model built in one representation, with what that took. */

#include "building/edge_rates.h"
#include "building/embree_device.h"
#include "building/representation.h"
#include "building/subdivision_geometry.h"
#include "building/traced_scene.h"
#include "building/vulkan_tracer.h"
#include "surface/model.h"

#include <embree3/rtcore_compression.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

/* A surface as it is stored: quads of vertices, each with the triangles 00, 10, 01 and 01, 10, 11. */
struct StoredMesh
{
  std::vector<Vec3f> vertices;                  // where blocks meet, twice, as the same floats
  std::vector<std::array<unsigned, 4>> quads;   // 00, 10, 11, 01: around the quad
  std::vector<unsigned> faces;                  // of quads, as hits have them; of two triangles the first
};

/* A bound on what cVERT moves vertices by, in pixels of a camera. */
struct PixelBound
{
  float pixels = 0;     // 0 for none
  Vec3f eye;
  float footprint = 0;  // width of a pixel at a distance of 1
};

struct BuildSettings
{
  int level = 6;
  std::shared_ptr<const EdgeRates> rates; // in place of it, of a model's edges; not for NAIVE nor meshes
  int threads = 0;     // of Embree's build, 0 for all
  // Largest spacing of cVERT, 0: lossless; largest thickness of leaves where frame levels are automatic, 0: no bound. Negative: the library's
  // default.
  float maxError = -1;
  PixelBound pixelBound;
  bool filters = false;    // of contexts are called
  std::string isa;     // Embree's name of the widest instruction set to use, empty for the host's best
  std::string device = "cpu"; // that traces: "cpu", "vulkan", "ray-query", "vulkan:NAME" or "ray-query:NAME"
  std::string name;    // in lines of progress, empty for the representation's label
};

/* Throws Error that names the option, --level, --threads, --isa or --device, and its value. */
void validateBuild(const BuildSettings& settings);

/* What a device and its geometries are told of them. */
std::string deviceConfig(const Representation& representation, const BuildSettings& settings);
RTCCompressionArguments compressionArguments(const BuildSettings& settings);

/* The part of a scene's quads in blocks that cLEAF stores exactly, as cVERT: 0 to 1. */
inline double exactQuadShare(const RTCCompressionStatistics& s)
{
  return s.numQuads ? double(s.numExactQuads) / double(s.numQuads) : 0.0;
}

struct BuildReport
{
  double seconds = 0;    // commit of geometry and scene
  size_t liveBytes = 0;  // held by the device after the commit, buffers and cage included
  size_t peakBytes = 0;  // most held at any time of the commit
  size_t quads = 0;
  RTCCompressionStatistics compression{}; // all zero for NAIVE and GRID
  std::optional<VulkanSceneReport> onDevice; // where a Vulkan device traces

  /* How far the surface may be from the mesh that it stands for: the thickness of its leaves, or the way
   * that its vertices were moved, and, where faces tear the mesh, that one face's were to another's. */
  float distanceFromMesh() const
  {
    return std::max(compression.maxLeafThickness, compression.maxVertexDeviation + compression.maxBorderGap);
  }

  double bytesPerQuad() const { return quads ? double(liveBytes) / double(quads) : 0.0; }

  /* The part of cLEAF's quads that is stored exactly, as cVERT: 0 to 1. */
  double exactShare() const { return exactQuadShare(compression); }
};

class BuiltScene : public TracedScene
{
public:
  /* Builds. Shows progress, and stops with Cancelled on Ctrl-C.
   * The model outlives the scene. Errors: throws Error with Embree's message. */
  BuiltScene(const Model& model, const Representation& representation, const BuildSettings& settings);

  RTCScene handle() const override { return scene.get(); }
  const SceneTracer& tracer() const override { return vulkanTracer ? static_cast<const SceneTracer&>(*vulkanTracer) : *embreeTracer; }
  const VulkanTracer* vulkan() const override { return vulkanTracer.get(); }

  const Representation& representation() const { return what; }
  const BuildReport& report() const { return built; }
  const PatchLayout& layout() const { return patches; }

  /* Saves all of a compressed scene to a file (saved_scene.h), or leaves what was there. Throws Error. */
  void save(const std::string& path) const;

  /* Translates what Embree reports; NAIVE's triangles become faces and (u,v). */
  SurfaceHit surfaceHit(const RTCRayHit& ray) const override;

  /* The vertices of the triangle that a hit is on, as they are stored; false where there is none. time: of the ray, of a model that moves.
   * Of cVERT and cGRID; throws Error of others. */
  bool triangleOf(const SurfaceHit& hit, float time, Vec3f vertices[3]) const;

  /* All that is stored, likewise. */
  StoredMesh storedMesh(float time = 0) const;

private:
  void buildSubdivision(const Model& model, const BuildSettings& settings);
  void buildTriangles(const Model& model, const BuildSettings& settings);
  void buildMesh(const Model& model, const BuildSettings& settings);
  void askForStatistics();
  void fillTriangles(RTCGeometry triangles, const PatchLayout& layout, const BuildSettings& settings);
  void commit(const char* doing);

  Representation what;
  std::string name; // in lines of progress
  PatchLayout patches;
  std::shared_ptr<const EdgeRates> rates; // of contexts
  size_t facesOfCopy, quadsOfCopy, numGeometries;
  std::vector<DisplacementContext> contexts; // one a copy
  std::unique_ptr<EmbreeDevice> device;
  SceneHandle scene; // released before its device
  std::unique_ptr<EmbreeTracer> embreeTracer;
  std::unique_ptr<VulkanTracer> vulkanTracer; // released before its scene
  BuildReport built;
};

/* Vertices of all patches of all copies, in the order of the model's layout: those that
 * GRID holds, to the bit, at the first time step. Throws Error, Cancelled. */
std::vector<Vec3f> tessellate(const Model& model, const BuildSettings& settings);

} // namespace cbvh
