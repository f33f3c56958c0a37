// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/saved_scene.h"
#include "building/built_scene.h"
#include "building/surface_handles.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/parallel.h"
#include "basics/progress.h"

#include <algorithm>
#include <chrono>
#include <ctime>

namespace programs {

void saveGeometries(EmbreeDevice& device, RTCScene scene, size_t numGeometries, const std::string& path) {
  requireNoInputFile(path);
  CbvhFileWriter made = nullptr;
  cbvhNewFileWriter(contextOf(device.handle()).get(), path.c_str(), &made);
  const FileWriterHandle writer(made);
  device.check("saving");
  Phase phase(path);
  for (size_t i = 0; i < numGeometries; i++) {
    cbvhAppendSurface(writer.get(), surfaceOf(rtcGetGeometry(scene, unsigned(i))).get());
    device.check("saving");
    phase.update(double(i + 1) / double(numGeometries));
    throwIfCanceled();
  }
  cbvhCommitFileWriter(writer.get());
  device.check("saving");
}

/* Here, so that programs that do not save also run with older libraries, which lack the functions above. */
void BuiltScene::save(const std::string& path) const { saveGeometries(*device, scene.get(), numGeometries, path); }

RTCCompressionStatistics compressionOf(EmbreeDevice& device, RTCScene scene) {
  RTCCompressionStatistics statistics{};
  statistics.structSize = sizeof(statistics);
  rtcGetSceneCompressionStatistics(scene, &statistics);
  device.check("reading the compression statistics");
  return statistics;
}

/* Opening a geometry reads its tree. */
SavedScene::SavedScene(const std::string& path, unsigned threads, const std::string& isa, Form form)
  : device(std::make_unique<EmbreeDevice>("threads=" + std::to_string(threads) + (isa.empty() ? "" : ",isa=" + isa) +
                                          (form == Form::Tiles ? ",subdiv_accel=cbvh.tile" : ""))) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t used = std::clock();
  CbvhFile opened = nullptr;
  cbvhOpenFile(contextOf(device->handle()).get(), path.c_str(), &opened);
  const FileHandle file(opened);
  device->check("opening a file");
  scene.reset(rtcNewScene(device->handle()));
  descriptions.resize(cbvhGetFileSurfaceCount(file.get()));
  statistics.resize(descriptions.size());
  parallelFor(descriptions.size(), 1, std::min(threads, unsigned(descriptions.size())), [&](size_t i, size_t) {
    cbvhGetFileSurfaceInfo(file.get(), i, &descriptions[i]);
    cbvhGetFileSurfaceStatistics(file.get(), i, &statistics[i]);
    CbvhSurface loaded = nullptr;
    cbvhLoadFileSurface(file.get(), i, &loaded);
    const SurfaceHandle surface(loaded);
    device->check("opening a file");
    if (!surface) return; // after an error that another thread's check() reported
    const GeometryHandle geometry(rtcNewGeometryFromSurface(device->handle(), surface.get()));
    rtcAttachGeometryByID(scene.get(), geometry.get(), unsigned(i));
  });
  std::vector<size_t> facesOfGeometries;
  for (const CbvhFileSurfaceInfo& geometry : descriptions) facesOfGeometries.push_back(geometry.numPrimitives);
  numbers = FaceNumbers(facesOfGeometries);
  rtcCommitScene(scene.get());
  device->check("opening a file");
  embreeTracer = std::make_unique<EmbreeTracer>(scene.get());
  openingProcessorSeconds = double(std::clock() - used) / CLOCKS_PER_SEC;
  opening = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

size_t SavedScene::quads() const {
  size_t sum = 0;
  for (const CbvhSurfaceStatistics& ofGeometry : statistics) sum += ofGeometry.numQuads;
  return sum;
}

size_t SavedScene::bytes() const {
  size_t sum = 0;
  for (const CbvhFileSurfaceInfo& geometry : descriptions) sum += geometry.bytes;
  return sum;
}

SurfaceHit surfaceHitOf(const RTCRayHit& ray, const FaceNumbers& faces) {
  SurfaceHit hit;
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  hit.t = ray.ray.tfar;
  hit.u = ray.hit.u;
  hit.v = ray.hit.v;
  hit.face = faces.number(ray.hit.geomID, ray.hit.primID);
  hit.normal = {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z};
  return hit;
}

} // namespace programs
