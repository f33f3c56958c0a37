// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "view_errors.h"

#include "tracing/trace_hits.h"

namespace programs {

ViewResult errorsInView(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                        const std::vector<SurfaceHit>& hits) {
  const auto compare = [&](const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& own) {
    return compareHits(reference, own, view.camera.footprint(), scene.layout());
  };
  ViewResult result;
  result.view = view.name;
  result.errors = compare(view.gridHits, hits);
  if (view.reference) result.toReference = compare(view.reference->gridHits, hits);
  if (settings.surfaces) {
    const TrueView sample{settings.model, *settings.surfaces, view.primary, view.sample, view.camera.footprint()};
    result.toTrue = compareToTrueSurface(sample, hits, scene.layout(), settings.threads);
  }
  result.bounced = compare(view.bouncedGridHits, traceClosest(scene, view.sets[Incoherent], settings.threads));
  return result;
}

} // namespace programs
