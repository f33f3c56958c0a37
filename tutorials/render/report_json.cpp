// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "report.h"
#include "programs/compression_json.h"
#include "programs/errors_json.h"
#include "programs/json_text.h"

namespace programs {
namespace {

using nlohmann::json;

/* `compared` is true if there are several representations, `speed` if it was measured. */
json resultJson(const Result& r, bool compared, bool speed) {
  json j;
  j["representation"] = r.representation.label();
  j["quads"] = r.build.quads;
  j["bytes_per_quad"] = r.build.bytesPerQuad();
  j["live_bytes"] = r.build.liveBytes;
  j["peak_bytes"] = r.build.peakBytes;
  j["build_seconds"] = r.build.seconds;
  j["seam_gap"] = r.build.seams.distance;
  j["seam_gap_quads"] = r.build.seams.quads;
  if (r.build.onDevice)
    j["on_device"] = {{"upload_seconds", r.build.onDevice->uploadSeconds},
                      {"device_bytes", r.build.onDevice->deviceBytes},
                      {"imported_bytes", r.build.onDevice->importedBytes}};
  if (r.representation.isCompressed()) j["compression"] = compressionJson(r.build.compression);
  if (compared)
    for (RaySet set : {Coherent, Incoherent}) j["any_hit_disagreements"][raySetName(set)] = r.anyDisagreements[set];
  if (speed) j["speed"] = speedJson(r.speed);
  if (r.errors) j["errors"] = errorsJson(*r.errors);
  if (r.trueErrors) j["errors_to_true_surface"] = errorsJson(*r.trueErrors);
  return j;
}

} // namespace

std::string formatJson(const Comparison& c) {
  json out;
  out["model"] = c.model;
  out["faces"] = c.faces;
  if (c.quadSize > 0) {
    out["level"] = "auto";
    out["quad_size"] = c.quadSize;
  } else if (!c.isMesh) out["level"] = c.build.level;
  out["device"] = c.build.device;
  if (!c.results.empty() && c.results[0].build.onDevice) out["device_name"] = c.results[0].build.onDevice->device;
  out["isa"] = c.build.isa.empty() ? "best" : c.build.isa;
  out["width"] = c.size.width;
  out["height"] = c.size.height;
  out["camera"] = c.camera;
  out["primary_hits"] = c.primaryHits;
  out["coherent_rays"] = c.rays[Coherent];
  out["incoherent_rays"] = c.rays[Incoherent];
  if (!c.reference.empty()) out["error_reference"] = c.reference;
  out["true_surface_hits"] = c.trueHits;
  for (const Result& r : c.results) out["results"].push_back(resultJson(r, c.compares, c.speed));
  return textOfJson(out, 2);
}

} // namespace programs
