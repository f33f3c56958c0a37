// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/built_scene.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "basics/setting_name.h"
#include "building/memory.h"
#include "surface/mesh.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <set>

namespace programs {
namespace {

bool onProgress(void* phase, double fraction) {
  static_cast<Phase*>(phase)->update(fraction);
  return !cancelRequested();
}

/* `contexts` are empty if Embree calls its progress monitor while it tessellates. */
void commitScene(EmbreeDevice& device, RTCScene scene, const std::string& name, size_t quads,
                 std::vector<DisplacementContext>& contexts) {
  Phase phase(name);
  TessellationProgress tessellation(phase, quads);
  for (DisplacementContext& context : contexts) context.progress = &tessellation;
  rtcSetSceneProgressMonitorFunction(scene, onProgress, &phase);
  rtcCommitScene(scene);
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  for (DisplacementContext& context : contexts) context.progress = nullptr;
  device.check("committing the scene");
}

/* Sets up one context per copy and keeps captures that are already set. Contexts must outlive the scene. `poses` is
 * empty for a static scene. */
void attachCopies(EmbreeDevice& device, RTCScene scene, const Model& model,
                  const std::vector<std::vector<Vec3f>>& poses, int level, const EdgeRates* rates,
                  std::vector<DisplacementContext>& contexts, SeamGaps* gaps,
                  const RTCCompressionArguments* compression = nullptr) {
  contexts.resize(model.copies.size());
  const SharedTopology topology(device, model.cage, poses);
  for (size_t i = 0; i < contexts.size(); i++) {
    setDisplacement(contexts[i], model, i, level, rates);
    contexts[i].gaps = gaps;
    rtcAttachGeometry(scene, topology.makeGeometry(model.copies[i], contexts[i], compression, model.shapeOf(i)).get());
    throwIfCanceled();
  }
}

/* Builds GRID at the first time step, passes the vertices to `captures` (one per copy), and frees the scene. */
void captureVertices(const Model& model, const BuildSettings& settings, std::vector<DisplacementContext>& captures,
                     const std::string& phase, SeamGaps* gaps) {
  EmbreeDevice device(deviceConfig({RepresentationKind::Grid}, settings));
  const SceneHandle scene(rtcNewScene(device.handle()));
  attachCopies(device, scene.get(), model, {}, settings.level, nullptr, captures, gaps);
  commitScene(device, scene.get(), phase, model.layout(settings.level).numQuads(), captures);
}

} // namespace

std::string deviceConfig(const Representation& representation, const BuildSettings& settings) {
  std::string config = representation.deviceConfig();
  auto add = [&](const std::string& item) { config += (config.empty() ? "" : ",") + item; };
  add("threads=" + std::to_string(threadCount(settings.threads)));
  if (representation.isCompressed() && settings.maxError >= 0.0f) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.9g", double(settings.maxError));
    add(std::string("cbvh_max_error=") + text);
  }
  if (!settings.isa.empty()) add("isa=" + settings.isa);
  return config;
}

RTCCompressionArguments compressionArguments(const BuildSettings& settings) {
  const PixelBound& bound = settings.pixelBound;
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.flags = RTC_COMPRESSION_FLAG_SMALL_MESHES;
  if (bound.pixels > 0.0f) {
    args.maxPixelError = bound.pixels;
    args.pixelSize = bound.footprint;
    const float eye[3] = {bound.eye.x, bound.eye.y, bound.eye.z};
    std::copy(eye, eye + 3, args.cameraPosition);
  }
  return args;
}

void validateBuild(const BuildSettings& settings) {
  if (settings.level < 0 || settings.level > maxLevel)
    throw Error(settingName("level") + " " + std::to_string(settings.level) + " is out of range: expected " +
                levelRange());
  if (settings.threads < 0)
    throw Error(settingName("threads") + " " + std::to_string(settings.threads) +
                " is negative: expected a number of threads, or 0 for all");
  if (!std::set<std::string>{"", "sse2", "sse4.2", "avx", "avx2", "avx512"}.count(settings.isa))
    throw Error("unknown " + settingName("isa") + " '" + settings.isa +
                "': expected sse2, sse4.2, avx, avx2 or avx512");
  validateTraceDevice(settings.device);
}

BuiltScene::BuiltScene(const Model& model, const Representation& representation, const BuildSettings& settings)
  : builtAs(representation),
    name(settings.name.empty() ? builtAs.label() : settings.name),
    patches(model.layout(settings.level)),
    rates(settings.rates),
    facesPerCopy(model.cage.numFaces()),
    quadsPerCopy(patches.numQuads() / model.copies.size()),
    numGeometries(model.copies.size()) {
  BuildSettings own = settings;
  if (model.isMesh && own.maxError < 0.0f && model.spacing > 0.0f)
    own.maxError = model.spacing; // lattice vertices stay exact
  device = std::make_unique<EmbreeDevice>(deviceConfig(representation, own));
  scene.reset(rtcNewScene(device->handle()));
  rtcSetSceneFlags(scene.get(),
                   RTCSceneFlags(representation.sceneFlags() |
                                 (settings.filters ? RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION : RTC_SCENE_FLAG_NONE)));
  device->check("creating a scene");
  if (model.isMesh) buildMesh(model, settings);
  else if (representation.isTriangulated() && rates)
    throw Error(optionNameOf(builtAs.kind) + " supports only one " + settingName("level") +
                " for all edges: expected another representation, or no rates by the view");
  else if (representation.isTriangulated()) buildTriangles(model, settings);
  else buildSubdivision(model, settings);
  built.quads = rates ? rates->quads : patches.numQuads();
  built.seams = gaps->maximum();
  embreeTracer = std::make_unique<EmbreeTracer>(scene.get());
  if (settings.device != "cpu") {
    Phase phase(name + ": upload to the device");
    vulkanTracer = VulkanTracer::create(settings.device, scene.get());
    device->check("uploading a scene to a Vulkan device");
    built.onDevice = vulkanTracer->report();
  }
}

void BuiltScene::commit(const char* operation) {
  const size_t inLargePages = bytesInLargePages();
  const auto start = std::chrono::steady_clock::now();
  std::vector<DisplacementContext> none; // compressed scenes report progress themselves
  commitScene(*device, scene.get(), name + ": " + operation, rates ? rates->quads : patches.numQuads(),
              builtAs.isCompressed() ? none : contexts);
  built.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  built.liveBytes = device->memory().live();
  built.peakBytes = device->memory().peak();
  built.largePageBytes += std::max(bytesInLargePages(), inLargePages) - inLargePages;
}

void BuiltScene::buildSubdivision(const Model& model, const BuildSettings& settings) {
  const auto start = std::chrono::steady_clock::now();
  const RTCCompressionArguments arguments = compressionArguments(settings);
  attachCopies(*device, scene.get(), model, model.poses, settings.level, rates.get(), contexts, gaps.get(),
               builtAs.isCompressed() ? &arguments : nullptr);
  built.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  commit("build");
  readStatistics();
}

void BuiltScene::readStatistics() {
  if (!builtAs.isCompressed()) return;
  rtcGetSceneCompressionStatistics(scene.get(), &built.compression);
  device->check("reading the compression statistics");
}

/* In quad geometries, triangles repeat their last vertex. GRID and NAIVE-compact differ by the scene's flags. */
void BuiltScene::buildMesh(const Model& model, const BuildSettings& settings) {
  if (builtAs.kind != RepresentationKind::Grid && builtAs.kind != RepresentationKind::NaiveCompact &&
      !builtAs.isExact())
    throw Error(
        settingName("mesh") + ": meshes have no " + builtAs.label() +
        ": expected grid (Embree's own quads or triangles), naive-compact (these in Embree's compact mode), cvert "
        "or ctile");
  const Cage& mesh = model.cage;
  bool isTriangleMesh = true;
  for (size_t face = 0; face < mesh.numFaces(); face++) isTriangleMesh &= isTriangle(mesh, face);
  const RTCGeometryType type = isTriangleMesh ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD;
  GeometryHandle geometry(rtcNewGeometry(device->handle(), type));
  std::copy(mesh.positions.begin(), mesh.positions.end(),
            newBuffer<Vec3f>(*device, geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions.size(),
                             "allocating the vertices of a mesh"));
  const auto fill = [&](auto* faces) {
    for (size_t face = 0; face < mesh.numFaces(); face++)
      std::copy_n(&mesh.faceIndices[4 * face], faces->size(), faces[face].begin());
  };
  const char* const operation = "allocating the faces of a mesh";
  if (isTriangleMesh)
    fill(newBuffer<std::array<uint32_t, 3>>(*device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                            mesh.numFaces(), operation));
  else
    fill(newBuffer<std::array<uint32_t, 4>>(*device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4,
                                            mesh.numFaces(), operation));
  if (builtAs.isCompressed()) {
    const RTCCompressionArguments arguments = compressionArguments(settings);
    rtcSetGeometryCompression(geometry.get(), &arguments);
    device->check("enabling compression");
  }
  const auto start = std::chrono::steady_clock::now();
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene.get(), geometry.get());
  device->check("committing a mesh");
  built.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  commit("build");
  readStatistics();
  if (builtAs.isCompressed() && built.compression.numQuads == 0)
    std::fprintf(stderr, "%s: nothing of the mesh is compressed: Embree's own kernel traces it\n", name.c_str());
}

/* NAIVE's vertices are GRID's: captureVertices builds GRID and frees it. Each quad becomes two triangles, split as in
 * GRID from (1,0) to (0,1):
 *
 *     01 --- 11
 *      | \ B |        A = 00, 10, 01    B = 01, 10, 11    (first digit u)
 *      | A \ |
 *     00 --- 10
 *
 * Every patch has its own vertices; every copy is a geometry. */
void BuiltScene::buildTriangles(const Model& model, const BuildSettings& settings) {
  splitsQuads = true;
  const PatchLayout layout(model.cage, settings.level);
  if (!model.poses.empty())
    throw Error("the triangles of NAIVE do not move: expected a model without motion, or another representation");
  for (const Patch& patch : layout.patches())
    if (settings.level == 0 && !layout.isQuadFace(patch.face))
      throw Error("NAIVE at level 0: face " + std::to_string(patch.face + 1) +
                  " is not a quad: expected only quads, or level 1");

  std::vector<GeometryHandle> copies;
  std::vector<DisplacementContext> captures(model.copies.size());
  for (DisplacementContext& capture : captures) {
    copies.emplace_back(rtcNewGeometry(device->handle(), RTC_GEOMETRY_TYPE_TRIANGLE));
    capture.layout = &layout;
    capture.captured = static_cast<float*>(rtcSetNewGeometryBuffer(
        copies.back().get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), layout.numVertices()));
    device->check("allocating the vertices of NAIVE");
  }
  captureVertices(model, settings, captures, name + ": tessellation", gaps.get());
  for (const GeometryHandle& copy : copies) fillTriangles(copy.get(), layout, settings);

  const auto start = std::chrono::steady_clock::now();
  for (const GeometryHandle& copy : copies) {
    rtcCommitGeometry(copy.get());
    rtcAttachGeometry(scene.get(), copy.get());
  }
  device->check("committing the triangles of NAIVE");
  built.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  commit("build");
}

void BuiltScene::fillTriangles(RTCGeometry triangles, const PatchLayout& layout, const BuildSettings& settings) {
  uint32_t* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), 2 * layout.numQuads()));
  device->check("allocating the triangles of NAIVE");
  parallelFor(layout.patches().size(), 64, threadCount(settings.threads), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) {
      const Patch& patch = layout.patches()[i];
      uint32_t* out = indices + 6 * patch.firstQuad;
      const uint32_t row = patch.resolution + 1;
      for (uint32_t y = 0; y < patch.resolution; y++)
        for (uint32_t x = 0; x < patch.resolution; x++) {
          const uint32_t v00 = uint32_t(patch.firstVertex) + y * row + x;
          const uint32_t v10 = v00 + 1, v01 = v00 + row, v11 = v01 + 1;
          for (uint32_t index : {v00, v10, v01, v01, v10, v11}) *out++ = index;
        }
    }
  });
}

SurfaceHit BuiltScene::surfaceHit(const RTCRayHit& ray) const {
  SurfaceHit result;
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return result;
  result.t = ray.ray.tfar;
  result.u = ray.hit.u;
  result.v = ray.hit.v;
  result.face = unsigned(ray.hit.geomID * facesPerCopy + ray.hit.primID);
  result.normal = {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z};
  if (!splitsQuads) return result;

  const size_t quad = ray.hit.geomID * quadsPerCopy + ray.hit.primID / 2;
  const auto& all = patches.patches();
  const Patch& patch =
      *(std::upper_bound(all.begin(), all.end(), quad, [](size_t q, const Patch& p) { return q < p.firstQuad; }) - 1);
  const unsigned local = unsigned(quad - patch.firstQuad);
  const unsigned x = local % patch.resolution, y = local / patch.resolution;
  /* Triangle A: (u,v) = barycentric (a,b). Triangle B: vertices (0,1), (1,0), (1,1). */
  const float a = ray.hit.u, b = ray.hit.v;
  const float du = ray.hit.primID & 1 ? a + b : a;
  const float dv = ray.hit.primID & 1 ? 1.0f - a : b;
  result.face = patch.face;
  result.u = (float(x) + du) / float(patch.resolution);
  result.v = (float(y) + dv) / float(patch.resolution);
  if (!patches.isQuadFace(patch.face)) {
    const Vec2f uv = encodeSubPatch(patch.subPatch, result.u, result.v);
    result.u = uv.x;
    result.v = uv.y;
  }
  return result;
}

std::vector<Vec3f> tessellate(const Model& model, const BuildSettings& settings) {
  const PatchLayout layout(model.cage, settings.level);
  std::vector<Vec3f> vertices(layout.numVertices() * model.copies.size());
  std::vector<DisplacementContext> captures(model.copies.size());
  for (size_t i = 0; i < captures.size(); i++) {
    captures[i].layout = &layout;
    captures[i].captured = &vertices[i * layout.numVertices()].x;
  }
  captureVertices(model, settings, captures, "tessellation", nullptr);
  return vertices;
}

} // namespace programs
