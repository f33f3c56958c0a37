// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "stored_surface.h"
#include "../blocks/required_blocks.h"
#include "../blocks/stored_clusters.h"

namespace embree::core {
namespace {
/*! True if the intersectors that api/factory.cpp selects for a device fuse multiply-adds, which changes vertices
 *  between time steps. */
bool fusesMultiplyAdds(const Device* device) {
#if defined(__AVX2__) || defined(__ARM_NEON) // the lowest ISA fuses
  return true;
#else
  const int features = device->enabled_cpu_features;
  bool isFused = false;
#if defined(EMBREE_TARGET_AVX2)
  isFused |= (features & AVX2) == AVX2;
#endif
#if defined(EMBREE_TARGET_AVX512)
  isFused |= (features & AVX512) == AVX512;
#endif
  return isFused;
#endif
}

cbvh::TraversalTime traversalTime(Geometry* geometry, float time) {
  return cbvh::TraversalTime{time, fusesMultiplyAdds(geometry->device)};
}

/*! References a geometry and its blocks, because closures may release or commit it. Throws without blocks. */
struct HeldBlocks {
  const Ref<Geometry> geometry; // released last: blocks refer to its device
  const std::shared_ptr<const SurfaceBlocks> blocks;

  explicit HeldBlocks(Geometry* held)
    : geometry(held),
      blocks(asCompressible(held) ? cbvh::blocksOf(asCompressible(held)) : nullptr) {
    if (!blocks) throwNotCompressed(asCompressible(held));
  }
};
} // namespace

bool findTriangle(Geometry* geometry, float time, unsigned primID, float u, float v, const float* Ng,
                  cbvh::StoredTriangle& triangle) {
  return requireBlocks(geometry).index().find(traversalTime(geometry, time), primID, u, v, Ng, triangle);
}

bool findClosestPointOfPrimitive(Geometry* geometry, float time, unsigned primID, const float p[3], float radius,
                                 cbvh::PointOnSurface& closest) {
  return requireBlocks(geometry).index().findClosest(traversalTime(geometry, time), primID, p, radius, closest);
}

void forEachPart(Geometry* geometry, float time, const std::function<bool(const cbvh::StoredPart&)>& closure) {
  const HeldBlocks held(geometry);
  cbvh::forEachPart(*held.blocks, traversalTime(geometry, time),
                    [&](const cbvh::StoredBlock&, const cbvh::StoredPart& part) { return closure(part); });
}

void forEachCluster(Geometry* geometry, float time, cbvh::ClusterFormat format,
                    const std::function<bool(const cbvh::StoredCluster&)>& closure,
                    cbvh::ClusterStatistics& statistics) {
  statistics = cbvh::ClusterStatistics();
  const HeldBlocks held(geometry);
  if (format != cbvh::ClusterFormat::FLOAT3 && format != cbvh::ClusterFormat::COMPRESSED1 &&
      format != cbvh::ClusterFormat::DGF1)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                   "unknown cluster format " + std::to_string(int(format)) + ": expected 0 to 2");
  cbvh::forEachCluster(*held.blocks, traversalTime(geometry, time), format, closure, statistics);
}
} // namespace embree::core
