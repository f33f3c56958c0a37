// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Cages as Embree subdivision geometries at a uniform edge rate. */

#include "basics/progress.h"
#include "building/edge_rates.h"
#include "building/embree_device.h"
#include "surface/model.h"

#include <embree3/rtcore_compression.h>

#include <atomic>
#include <vector>

namespace cbvh {

/* Shows how far the tessellation of a scene is. Builders of stock Embree tessellate before
 * their progress monitors hear anything. */
class TessellationProgress
{
public:
  TessellationProgress(Phase& phase, size_t quads) : phase(phase), quads(quads) {}

  /* points: that were displaced since the last call. Called by any thread. */
  void add(size_t points);

private:
  Phase& phase;
  const size_t quads;
  std::atomic<size_t> done{0};
};

/* What the displacement function of a geometry needs; outlives the geometry. */
struct DisplacementContext
{
  const Displacement* displacement = nullptr;
  int level = 0;          // of the subdivision
  const EdgeRates* rates = nullptr;      // if set, in place of it,
  const EdgeRates::Copy* copy = nullptr; // and which of them
  Placement placement;    // of the copy, and so of its displacement

  /* If set, every vertex that Embree tessellates is also written here, in the order
   * of the layout: the tessellation that GRID stores, to the bit. */
  const PatchLayout* layout = nullptr;
  float* captured = nullptr; // 3 floats a vertex

  TessellationProgress* progress = nullptr; // if set, hears of what is displaced
};

/* Names the displacement of a copy of a model. rates: of all copies, null for the level. Both outlive the context. */
void setSurface(DisplacementContext& context, const Model& model, size_t copy, int level, const EdgeRates* rates);

struct BufferRelease
{
  void operator()(RTCBuffer buffer) const { rtcReleaseBuffer(buffer); }
};
using BufferHandle = std::unique_ptr<RTCBufferTy, BufferRelease>;

/* What all copies of a cage have in common, in buffers of a device. The cage outlives
 * it, and so do its poses: positions of its vertices at later time steps. */
class SharedTopology
{
  static inline const std::vector<std::vector<Vec3f>> noPoses;

public:
  /* Throws Error. */
  SharedTopology(EmbreeDevice& device, const Cage& cage, const std::vector<std::vector<Vec3f>>& poses = noPoses);

  /* Makes a geometry at a place, committed, not yet attached to a scene.
   *
   * context: displacement, level (the edge rate is 2^level) or rates, and capture;
   * compression: read during the call, null for the device's settings; shape: of a copy that is not the cage's, see Model.
   * Errors: throws Error. */
  GeometryHandle makeGeometry(const Placement& placement, DisplacementContext& context,
                              const RTCCompressionArguments* compression = nullptr, const std::vector<Vec3f>* shape = nullptr) const;

private:
  struct Buffer
  {
    RTCBufferType type;
    RTCFormat format;
    size_t stride, count;
    BufferHandle handle;
  };
  void setVertices(RTCGeometry geometry, unsigned step, const Placement& placement, const std::vector<Vec3f>& positions, const std::vector<Vec3f>* shape) const;
  template<typename T>
  void add(RTCBufferType type, RTCFormat format, const std::vector<T>& data);

  EmbreeDevice& device;
  const Cage& cage;
  const std::vector<std::vector<Vec3f>>& poses;
  std::vector<Buffer> buffers;
};

} // namespace cbvh
