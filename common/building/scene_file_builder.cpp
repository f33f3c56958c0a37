// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/scene_file_builder.h"
#include "basics/hash.h"
#include "basics/input_files.h"
#include "basics/progress.h"
#include "building/subdivision_geometry.h"
#include "building/surface_handles.h"

#include <chrono>

namespace programs {
namespace {

class InputKey {
public:
  template<typename T>
  void add(const std::vector<T>& values) {
    add(values.size());
    addBytes(values.data(), values.size() * sizeof(T));
  }
  template<typename T>
  void add(T value) {
    addBytes(&value, sizeof(value));
  }
  void add(Vec3f v) { add(v.x), add(v.y), add(v.z); }

  unsigned long long key() const { return hash; }

private:
  void addBytes(const void* data, size_t bytes) { hash = hashOfBytes(data, bytes, hash); }

  uint64_t hash = emptyHash;
};

/* Samples the displacement at a few points of each face: inside, and on borders, which depend on how a map continues
 * and on the faces beside. */
void addDisplacement(InputKey& key, const Model& model, int level) {
  constexpr size_t n = 10;
  const float u[n] = {0.5f, 0.25f, 0.625f, 0.8125f, 0, 1, 0.25f, 0.75f, 0, 1};
  const float v[n] = {0.5f, 0.375f, 0.125f, 0.6875f, 0.25f, 0.75f, 0, 1, 0, 1};
  const Vec3f normals[n] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0},
                            {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (unsigned face = 0; model.displacement && face < model.cage.numFaces(); face++) {
    const SurfacePoints points{face, level, n, u, v};
    float offsets[n];
    Vec3f vectors[n];
    if (model.displacement->isAlongNormals()) {
      model.displacement->offsets(points, offsets);
      for (float offset : offsets) key.add(offset);
      continue;
    }
    model.displacement->vectors(points, normals, vectors);
    for (Vec3f vector : vectors) key.add(vector);
  }
}

} // namespace

unsigned long long inputKey(const Model& model, const Representation& representation, const BuildSettings& settings) {
  InputKey key;
  const std::string label = representation.label();
  key.add(std::vector<char>(label.begin(), label.end()));
  key.add(settings.level);
  key.add(settings.maxError);
  key.add(settings.pixelBound.pixels);
  key.add(settings.pixelBound.eye);
  key.add(settings.pixelBound.footprint);
  for (size_t i = 0; settings.rates && i < settings.rates->copies.size(); i++) key.add(settings.rates->copies[i].rates);
  key.add(model.cage.faceSizes);
  key.add(model.cage.faceIndices);
  key.add(model.cage.holes);
  key.add(model.cage.creaseEdges);
  key.add(model.cage.creaseSharpness);
  key.add(model.cage.cornerVertices);
  key.add(model.cage.cornerSharpness);
  key.add(model.cage.boundary);
  key.add(model.poses.size());
  for (Vec3f p : model.positions()) key.add(p);
  addDisplacement(key, model, settings.level);
  return key.key();
}

FileBuildReport buildToFile(const Model& model, const Representation& representation, const BuildSettings& settings,
                            const std::string& path) {
  requireNoInputFile(path);
  EmbreeDevice device(deviceConfig(representation, settings));
  RTCCompressionArguments arguments = compressionArguments(settings);
  arguments.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT; // compress when the geometry is committed
  const SharedTopology topology(device, model.cage, model.poses);
  const unsigned long long key = inputKey(model, representation, settings);
  CbvhFileWriter made = nullptr;
  cbvhResumeFileWriter(contextOf(device.handle()).get(), path.c_str(), key, &made);
  const FileWriterHandle writer(made);
  device.check("saving");
  FileBuildReport report;
  report.geometries = model.copies.size();
  report.found = cbvhGetFileWriterSurfaceCount(writer.get());
  const size_t quads = settings.rates ? settings.rates->quads : model.layout(settings.level).numQuads();
  const size_t left = report.geometries - report.found;
  report.quads = size_t(double(quads) * double(left) / double(report.geometries));
  SeamGaps gaps;
  const auto start = std::chrono::steady_clock::now();
  {
    const std::string resumed = report.found ? ", resumed at geometry " + std::to_string(report.found) : "";
    Phase phase(path + resumed, Phase::PercentAndTimeLeft);
    for (size_t i = report.found; i < report.geometries; i++) {
      DisplacementContext context;
      setDisplacement(context, model, i, settings.level, settings.rates.get());
      context.gaps = &gaps;
      const GeometryHandle geometry = topology.makeGeometry(model.copies[i], context, &arguments, model.shapeOf(i));
      cbvhAppendSurface(writer.get(), surfaceOf(geometry.get()).get());
      device.check("saving");
      phase.update(double(i + 1 - report.found) / double(left));
      throwIfCanceled();
    }
    cbvhCommitFileWriter(writer.get());
    device.check("saving");
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.peakBytes = device.memory().peak();
  report.seams = gaps.maximum();
  return report;
}

} // namespace programs
