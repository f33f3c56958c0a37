// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed scenes in files: saved, and opened without the model that they were made of. */

#include "building/embree_device.h"
#include "building/traced_scene.h"

#include <embree3/rtcore_compressed_files.h>

#include <memory>
#include <string>
#include <vector>

namespace cbvh {

struct FileWriterRelease
{
  void operator()(RTCCompressedFileWriter writer) const { rtcReleaseCompressedFileWriter(writer); }
};
using FileWriterHandle = std::unique_ptr<RTCCompressedFileWriterTy, FileWriterRelease>;

class SavedScene : public TracedScene
{
public:
  /* Opens a file and commits a scene of all that is in it. isa: Embree's name of the widest instruction set to use, empty
   * for the host's best. Throws Error with the reason, Cancelled. */
  SavedScene(const std::string& path, unsigned threads, const std::string& isa = "");

  RTCScene handle() const override { return scene.get(); }
  const SceneTracer& tracer() const override { return *embreeTracer; }
  const std::vector<RTCCompressedFileGeometry>& geometries() const { return descriptions; }
  size_t quads() const;
  size_t bytes() const; // in the file, of all geometries

  /* As BuiltScene: the faces of geometry i begin at i times the number that the one with most of them has. */
  SurfaceHit surfaceHit(const RTCRayHit& ray) const override;
  unsigned facesOfCopy() const { return mostFaces; }

  /* From before the file was opened until the scene was there; the device was there before. */
  double seconds() const { return opening; }
  double processorSeconds() const { return openingOnProcessors; } // which others do not slow down

  /* What the device has allocated: trees, without what is mapped. */
  size_t liveBytes() const { return device->memory().live(); }

  void check() const override { device->check("tracing"); }

private:
  std::unique_ptr<EmbreeDevice> device;
  SceneHandle scene; // released before its device
  std::unique_ptr<EmbreeTracer> embreeTracer;
  std::vector<RTCCompressedFileGeometry> descriptions;
  std::vector<RTCCompressionStatistics> statistics;
  unsigned mostFaces = 1;
  double opening = 0, openingOnProcessors = 0;
};

} // namespace cbvh
