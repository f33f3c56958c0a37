// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/seconds.h"
#include "building/scene_tracer.h"
#include "measure/quantiles.h"
#include "surface/model.h"
#include "tracing/camera.h"
#include "tracing/image_size.h"
#include "tracing/ray_conversion.h"
#include "tracing/ray_sets.h"

#include <embree3/rtcore.h>

#include <random>
#include <vector>

namespace programs {

enum class TimedQuery { Single, Packets, AnyHit };

/* Processor seconds of the calling thread. */
inline double traceTimed(RTCScene scene, const std::vector<RTCRayHit>& rays, std::vector<RTCRayHit>& hits,
                         TimedQuery query) {
  hits = rays;
  const clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
  if (query == TimedQuery::Packets)
    return processorSecondsOf(clock, [&] { PacketTracer(scene).intersect(hits.data(), hits.size()); });
  if (query == TimedQuery::Single)
    return processorSecondsOf(clock, [&] { EmbreeTracer(scene).intersect(hits.data(), hits.size()); });
  return processorSecondsOf(clock, [&] {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (RTCRayHit& r : hits) rtcOccluded1(scene, &context, &r.ray);
  });
}

/* Traces the same rays alternately. Returns the speed of `ours` divided by the speed of `theirs` per run; `hits`
 * receives theirs and ours of the last run. */
inline std::vector<double> interleavedSpeedups(RTCScene theirs, RTCScene ours, const std::vector<RTCRayHit>& rays,
                                               TimedQuery query, unsigned repeat, std::vector<RTCRayHit> hits[2]) {
  std::vector<double> ratios;
  for (unsigned i = 0; i < repeat; i++) {
    const double before = traceTimed(theirs, rays, hits[0], query), now = traceTimed(ours, rays, hits[1], query);
    ratios.push_back(before / now);
  }
  return ratios;
}

inline double medianSpeedup(RTCScene theirs, RTCScene ours, const std::vector<RTCRayHit>& rays, TimedQuery query,
                            unsigned repeat, std::vector<RTCRayHit> hits[2]) {
  return median(interleavedSpeedups(theirs, ours, rays, query, repeat, hits));
}

inline bool isHit(const RTCRayHit& r) { return r.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

/* Primary rays in rows and in tiles, and rays that bounce off their hits. Times are random in [0,1), or 0. */
struct PictureRays {
  PictureRays(const Model& model, RTCScene scene, ImageSize size, bool atRandomTimes)
    : camera(Camera::fit(model.positions(), 0.0f, model.view, 40, size)) {
    const std::vector<Ray> rays = primaryRays(camera);
    primary = loaded(rays, atRandomTimes, 1);
    std::vector<RTCRayHit> hits;
    traceTimed(scene, primary, hits, TimedQuery::Single);
    std::vector<SurfaceHit> seen(rays.size());
    for (size_t i = 0; i < seen.size(); i++)
      if (isHit(hits[i])) {
        seen[i].t = hits[i].ray.tfar;
        seen[i].face = 0;
        seen[i].normal = {hits[i].hit.Ng_x, hits[i].hit.Ng_y, hits[i].hit.Ng_z};
      }
    BounceSettings bounce;
    bounce.offset = 1e-4f * model.cage.bounds().diagonal();
    bounces = loaded(bounceRays(rays, seen, bounce), atRandomTimes, 2);
    tiles = loaded(coherentRays(rays, camera.size(), 0), atRandomTimes, 3);
  }

  Camera camera;
  std::vector<RTCRayHit> primary, bounces, tiles;

private:
  static std::vector<RTCRayHit> loaded(const std::vector<Ray>& rays, bool atRandomTimes, uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<RTCRayHit> all(rays.size());
    for (size_t i = 0; i < rays.size(); i++) {
      load(rays[i], all[i]);
      if (atRandomTimes) all[i].ray.time = float(random() >> 8) * 0x1p-24f;
    }
    return all;
  }
};

} // namespace programs
