// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "view_errors.h"

#include "tracing/trace_hits.h"

namespace programs {
namespace {

std::vector<SurfaceHit> selectHits(const std::vector<SurfaceHit>& hits, const std::vector<size_t>& rays) {
  std::vector<SurfaceHit> some;
  for (size_t ray : rays) some.push_back(hits[ray]);
  return some;
}

/* Bins belong to a block's frame, which must be known. Faces that are stored as cVERT have none. */
bool hasBins(const Representation& representation) {
  return representation.kind == RepresentationKind::CLeafOnly && representation.frameLevel != autoFrameLevel;
}

void addErrorsToTrueSurface(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                            const std::vector<SurfaceHit>& hits, ViewResult& result) {
  const auto trueView = [&](const std::vector<size_t>& sample) {
    return TrueView{settings.model, *settings.surfaces, view.primary, sample, view.camera.footprint()};
  };
  result.toTrue = compareToTrueSurface(trueView(view.sample), hits, scene.layout(), settings.threads);
  if (!hasBins(scene.representation())) return;
  const auto bins = [&](const std::vector<size_t>& sample) {
    const BlockGrid blocks{scene.layout(), settings.level, scene.representation().frameLevel};
    return heightBins(trueView(sample), view.gridHits, blocks, settings.threads);
  };
  result.bins = bins(view.sample);
  result.binsAwayFromSilhouettes = bins(view.sampleAwayFromSilhouettes);
}

} // namespace

ViewResult errorsInView(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                        const std::vector<SurfaceHit>& hits) {
  const auto compare = [&](const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& own) {
    return compareHits(reference, own, view.camera.footprint(), scene.layout());
  };
  ViewResult result;
  result.view = view.name;
  result.errors = compare(view.gridHits, hits);
  result.errorsAwayFromSilhouettes =
      compare(selectHits(view.gridHits, view.awayFromSilhouettes), selectHits(hits, view.awayFromSilhouettes));
  if (view.reference) result.toReference = compare(view.reference->gridHits, hits);
  if (settings.surfaces) addErrorsToTrueSurface(settings, view, scene, hits, result);
  result.bounced = compare(view.bouncedGridHits, traceClosest(scene, view.sets[Incoherent], settings.threads));
  return result;
}

} // namespace programs
