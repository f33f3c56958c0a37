// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "measure/hit_metrics.h"
#include "measure/true_errors.h"

#include <nlohmann/json.hpp>

namespace programs {

inline nlohmann::json summaryJson(const ErrorSummary& e) {
  return {{"rmse_pixels", e.rmse},
          {"median_pixels", e.median},
          {"p99_pixels", e.p99},
          {"max_pixels", e.max},
          {"normal_median_degrees", e.normalMedian},
          {"normal_p99_degrees", e.normalP99},
          {"flipped_normals", e.flipped},
          {"uv_median_quads", e.uvMedian},
          {"uv_p99_quads", e.uvP99},
          {"other_patch", e.otherPatch}};
}

/* Errors against a mesh. At the mesh's level: of compression alone. */
inline nlohmann::json errorsJson(const HitErrors& e) {
  nlohmann::json json = summaryJson(e);
  json.update({{"rays", e.rays},
               {"both_hit", e.bothHit},
               {"bias_pixels", e.bias},
               {"beyond_5_pixels", e.outliers},
               {"inlier_rmse_pixels", e.inlierRmse},
               {"false_hits", e.falseHits},
               {"misses", e.misses}});
  return json;
}

/* Errors against the true surface: tessellation and compression. */
inline nlohmann::json errorsJson(const TrueErrors& e) {
  nlohmann::json json = summaryJson(e);
  json.update({{"hits", e.hits},
               {"rmse_world", e.rmseWorld},
               {"median_world", e.medianWorld},
               {"p99_world", e.p99World},
               {"rmse_along_ray_pixels", e.rmseAlong},
               {"bias_pixels", e.bias},
               {"not_within_5_pixels_along_ray", e.outliers}});
  return json;
}

} // namespace programs
