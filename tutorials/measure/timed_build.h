// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene with one geometry, built `repeat` times; the last build remains. Throws Error. */

#include "basics/seconds.h"
#include "building/subdivision_geometry.h"
#include "programs/compared_scenes.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <functional>
#include <memory>
#include <vector>

namespace programs {

using CommitGeometry = std::function<GeometryHandle(const RTCCompressionArguments&)>;

using PrepareGeometry = std::function<CommitGeometry(EmbreeDevice&)>;

/* For a geometry whose buffers are set. */
inline CommitGeometry commitOf(GeometryHandle input) {
  const std::shared_ptr<RTCGeometryTy> geometry(input.release(), GeometryRelease());
  return [geometry](const RTCCompressionArguments& args) {
    rtcSetGeometryCompression(geometry.get(), &args);
    rtcCommitGeometry(geometry.get());
    rtcRetainGeometry(geometry.get());
    return GeometryHandle(geometry.get());
  };
}

/* For a displaced cage, at all poses of its model, which must outlive the result. */
inline PrepareGeometry prepareCage(const Model& model, int level) {
  return [&model, level](EmbreeDevice& device) -> CommitGeometry {
    const auto topology = std::make_shared<SharedTopology>(device, model.cage, model.poses);
    const auto context = std::make_shared<DisplacementContext>();
    context->displacement = model.displacement.get();
    context->level = level;
    return [=](const RTCCompressionArguments& args) { return topology->makeGeometry(Placement(), *context, &args); };
  };
}

class TimedBuild {
public:
  TimedBuild(const PrepareGeometry& prepare, const ComparedScenes& compared, RTCCompression compression,
             float maxError = -1, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
    : device(compared.deviceConfig()) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = compression;
    args.maxError = maxError;
    for (unsigned i = 0; i < compared.repeat; i++) {
      scene.reset();
      geometry.reset();
      commit = nullptr;
      const size_t empty = device.memory().live();
      commit = prepare(device);
      const size_t before = device.memory().live();
      inputBytes = before - empty;
      device.memory().resetPeak();
      seconds.push_back(secondsOf([&] {
        processorSeconds.push_back(processorSecondsOf(CLOCK_PROCESS_CPUTIME_ID, [&] {
          geometry = commit(args);
          scene.reset(rtcNewScene(device.handle()));
          rtcSetSceneFlags(scene.get(), flags);
          rtcAttachGeometry(scene.get(), geometry.get());
          rtcCommitScene(scene.get());
        }));
      }));
      device.check("committing");
      bytes = device.memory().live() - before;
      peak = device.memory().peak() - before;
    }
    rtcGetSceneCompressionStatistics(scene.get(), &statistics);
    device.check("reading statistics");
  }

  RTCScene handle() const { return scene.get(); }

  EmbreeDevice device;

private:
  CommitGeometry commit;

public:
  GeometryHandle geometry;
  std::vector<double> seconds, processorSeconds; // of commits; processor time of all threads
  size_t inputBytes = 0;                         // the application's buffers
  size_t bytes = 0, peak = 0;                    // without these
  RTCCompressionStatistics statistics{};

private:
  SceneHandle scene; // released before its device
};

} // namespace programs
