// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A displacement that records the exact vertices that it produces, as targets for rays. */

#include "support/scene.h"

#include <mutex>

namespace programs::test {

class VertexRecorder : public Displacement {
public:
  virtual ~VertexRecorder() = default;

  // Adds a surface with this displacement to a scene, commits it, and records its vertices. Does not record if it
  // displaces other surfaces.
  void build(RTCDevice device, RTCScene scene, const Cage& cage, SurfaceSettings settings) {
    settings.displacement = this;
    RTCGeometry geometry = newSurface(device, cage, settings);
    rtcSetGeometryDisplacementFunction(geometry, applyAndRecord);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
  }

protected:
  // Receives displaced vertices. Called by one thread at a time.
  virtual void record(const RTCDisplacementFunctionNArguments& vertices) = 0;

private:
  static void applyAndRecord(const RTCDisplacementFunctionNArguments* args) {
    apply(args);
    VertexRecorder& self = *static_cast<VertexRecorder*>((Displacement*)args->geometryUserPtr);
    std::lock_guard<std::mutex> lock(self.mutex);
    self.record(*args);
  }

  std::mutex mutex;
};

} // namespace programs::test
