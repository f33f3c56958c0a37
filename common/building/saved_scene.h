// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed scenes in files, opened without the model. */

#include "building/embree_device.h"
#include "building/face_numbers.h"
#include "building/traced_scene.h"

#include <embree3/cbvh.h>
#include <embree3/rtcore_compression.h>

#include <memory>
#include <string>
#include <vector>

namespace programs {

/* Saves geometries 0 to numGeometries - 1 of a committed scene. Replaces the file only on success. Shows progress.
 * Throws Error. */
void saveGeometries(EmbreeDevice& device, RTCScene scene, size_t numGeometries, const std::string& path);

RTCCompressionStatistics compressionOf(EmbreeDevice& device, RTCScene scene);

/* Converts the hit or the miss of a ray on compressed geometries. */
SurfaceHit surfaceHitOf(const RTCRayHit& ray, const FaceNumbers& faces);

class SavedScene : public TracedScene {
public:
  /* Form of the blocks of a file that stores cVERT. Files are mapped; tiles are in memory, have the same hits, and are
   * traced faster. The library keeps files mapped whose tiles would take more than half of the machine's memory. */
  enum class Form { Mapped, Tiles };

  /* Opens a file and commits a scene of all its geometries. `isa` as in BuildSettings. Throws Error. */
  SavedScene(const std::string& path, unsigned threads, const std::string& isa = "", Form form = Form::Mapped);

  RTCScene handle() const override { return scene.get(); }
  const SceneTracer& tracer() const override { return *embreeTracer; }
  const std::vector<CbvhFileSurfaceInfo>& geometries() const { return descriptions; }
  size_t quads() const;
  size_t bytes() const;

  SurfaceHit surfaceHit(const RTCRayHit& ray) const override { return surfaceHitOf(ray, numbers); }
  const FaceNumbers& faces() const { return numbers; }

  /* Statistics of all geometries together. Throws Error. */
  RTCCompressionStatistics compression() const { return compressionOf(*device, scene.get()); }

  /* Saves all geometries. Replaces the file only on success. Throws Error. */
  void save(const std::string& path) const { saveGeometries(*device, scene.get(), descriptions.size(), path); }

  /* Time from opening the file to the committed scene, without the device: wall-clock, and processor time of all
   * threads. */
  double seconds() const { return opening; }
  double processorSeconds() const { return openingProcessorSeconds; }

  /* Bytes of trees; excludes the mapped file. */
  size_t liveBytes() const { return device->memory().live(); }

  void check() const override { device->check("tracing"); }

private:
  std::unique_ptr<EmbreeDevice> device;
  SceneHandle scene; // released before its device
  std::unique_ptr<EmbreeTracer> embreeTracer;
  std::vector<CbvhFileSurfaceInfo> descriptions;
  std::vector<CbvhSurfaceStatistics> statistics;
  FaceNumbers numbers;
  double opening = 0, openingProcessorSeconds = 0;
};

} // namespace programs
