// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/progress.h"
#include "building/edge_rates.h"
#include "building/embree_device.h"
#include "surface/model.h"
#include "surface/seam_gaps.h"

#include <embree3/rtcore_compression.h>

#include <atomic>
#include <vector>

namespace programs {

/* Progress by displaced points, because stock Embree calls its progress monitor only after the tessellation. */
class TessellationProgress {
public:
  TessellationProgress(Phase& phase, size_t quads) : phase(phase), quads(quads) {}

  /* Adds displaced points. Thread-safe. */
  void add(size_t points);

private:
  Phase& phase;
  const size_t quads;
  std::atomic<size_t> done{0};
};

/* Data that the displacement function of a geometry reads and writes; must outlive the geometry. */
struct DisplacementContext {
  const Displacement* displacement = nullptr; // null for none
  int level = 0;
  const EdgeRates* rates = nullptr;      // replaces `level` if set
  const EdgeRates::Copy* copy = nullptr; // of `rates`, for this geometry; set if `rates` is
  Placement placement;                   // set by SharedTopology::makeGeometry

  /* If `captured` is set, it receives the vertices that Embree tessellates at the first time step, 3 floats each, in
   * the order of `layout`. Then `layout` must be set, and all edges must have the rate of `level`. */
  const PatchLayout* layout = nullptr;
  float* captured = nullptr;

  TessellationProgress* progress = nullptr;
  SeamGaps* gaps = nullptr; // receives the gaps that are closed at seams, if set
};

/* Sets the displacement of a copy. `rates` may be null, and otherwise replace the level. Model and rates must
 * outlive the context. */
void setDisplacement(DisplacementContext& context, const Model& model, size_t copy, int level, const EdgeRates* rates);

struct BufferRelease {
  void operator()(RTCBuffer buffer) const { rtcReleaseBuffer(buffer); }
};
using BufferHandle = std::unique_ptr<RTCBufferTy, BufferRelease>;

/* Buffers that all copies of a cage share. The device, the cage and its poses (vertices at later time steps) must
 * outlive the object; geometries keep the buffers. */
class SharedTopology {
  static inline const std::vector<std::vector<Vec3f>> noPoses;

public:
  /* Throws Error. */
  SharedTopology(EmbreeDevice& device, const Cage& cage, const std::vector<std::vector<Vec3f>>& poses = noPoses);

  /* Returns a committed geometry, not yet attached to a scene.
   *
   * `context` holds displacement, level (the edge rate is 2^level) or rates, and capture; the call stores `placement`
   * in it. `compression` is read during the call; null selects the device's settings. `shape` holds the vertices of a
   * copy that has its own, see Model. Throws Error. */
  GeometryHandle makeGeometry(const Placement& placement, DisplacementContext& context,
                              const RTCCompressionArguments* compression = nullptr,
                              const std::vector<Vec3f>* shape = nullptr) const;

private:
  struct Buffer {
    RTCBufferType type;
    RTCFormat format;
    size_t stride, count;
    BufferHandle handle;
  };
  void setVertices(RTCGeometry geometry, unsigned step, const Placement& placement, const std::vector<Vec3f>& positions,
                   const std::vector<Vec3f>* shape) const;
  template<typename T>
  void add(RTCBufferType type, RTCFormat format, const std::vector<T>& data);

  EmbreeDevice& device;
  const Cage& cage;
  const std::vector<std::vector<Vec3f>>& poses;
  std::vector<Buffer> buffers;
};

} // namespace programs
