// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "json.h"
#include "measure/quantiles.h"
#include "programs/compression_json.h"
#include "programs/errors_json.h"
#include "programs/json_text.h"

#include <algorithm>

namespace programs {
namespace {

using nlohmann::json;

/* Readers reject other versions. */
constexpr int formatVersion = 2;

json summary(const std::vector<double>& values) {
  const double middle = median(values);
  return {{"median", middle},
          {"min", *std::min_element(values.begin(), values.end())},
          {"max", *std::max_element(values.begin(), values.end())},
          {"spread", interquartileRange(values) / middle}};
}

json leaksJson(const Leaks& l) { return {{"closest", l.closest}, {"any", l.any}, {"through", l.through}}; }

json leaksJson(const LeakCounts& c) {
  json j = {{"rays", c.rays},
            {"aimed_rays", c.aimed},
            {"missed", leaksJson(c.sceneLeaks)},
            {"missed_unaimed", leaksJson(c.random)},
            {"missed_by_grid", leaksJson(c.gridLeaks)},
            {"examples", json::array()}};
  for (const Ray& r : c.examples)
    j["examples"].push_back({r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z});
  return j;
}

json sheetsJson(const SheetCrossings& c) {
  return {{"sheets", c.sheets},
          {"rays", c.rays},
          {"closest", c.closest},
          {"any", c.any},
          {"missed_by_grid", c.gridMisses},
          {"examples", c.examples}};
}

json crossingsJson(const CrossingCheck& c) {
  return {{"view", c.view},
          {"rays", c.counts.rays},
          {"crossings", c.counts.sceneCrossings},
          {"grid_crossings", c.counts.gridCrossings},
          {"different_counts", c.counts.differentCounts},
          {"different_parities", c.counts.differentParities}};
}

json shadowJson(const ShadowErrors& e) {
  return {{"false_occlusions", e.falseOcclusions}, {"false_passes", e.falsePasses}};
}

json shadowsJson(const ShadowCheck& c) {
  return {{"view", c.view},
          {"offset", c.offset},
          {"offset_length", c.settings.length},
          {"offset_pixels", c.settings.pixels},
          {"offset_ulps", c.settings.ulps},
          {"length", std::isfinite(c.length) ? json(c.length) : json()},
          {"rays", c.comparison.rays},
          {"occluded", c.comparison.occluded},
          {"errors", shadowJson(c.comparison.all)},
          {"same_hit_rays", c.comparison.sameHitRays},
          {"same_hit_errors", shadowJson(c.comparison.sameHitErrors)},
          {"flipped_rays", c.comparison.flippedRays},
          {"flipped_errors", shadowJson(c.comparison.flippedErrors)},
          {"control_errors", shadowJson(c.comparison.control)}};
}

json speedJson(const Speed& s, bool onDevice) {
  std::vector<double> mrays;
  for (double seconds : s.seconds) mrays.push_back(s.mrays(seconds));
  json j = {{"view", s.view},
            {"ray_set", raySetName(s.set)},
            {"query", queryName(s.trace.query)},
            {"mode", traceModeName(s.trace.mode)},
            {"threads", s.trace.threads},
            {"clock", onDevice              ? "the device's"
                      : s.trace.threads > 1 ? "wall"
                                            : "processor time of the thread"},
            {"passes", s.trace.passes},
            {"rays", s.rays},
            {"hits", s.hits},
            {"seconds", s.seconds},
            {"mrays_per_second", summary(mrays)},
            {"relative_to_grid", summary(s.toGrid)}};
  if (!s.toFirst.empty()) j["relative_to_first_library"] = summary(s.toFirst);
  return j;
}

json agreementJson(const HitAgreement& a) {
  return {{"view", a.view},
          {"ray_set", raySetName(a.set)},
          {"query", queryName(a.trace.query)},
          {"mode", traceModeName(a.trace.mode)},
          {"rays", a.differences.rays},
          {"different_rays", a.differences.all()},
          {"different_hit_or_miss", a.differences.hits},
          {"different_ids", a.differences.ids},
          {"different_distance", a.differences.distances},
          {"different_uv_or_normal", a.differences.surfaces}};
}

json libraryJson(const Library& library) {
  return {{"name", library.name()},
          {"path", library.path()},
          {"version", library.version()},
          {"isas", library.isas()},
          {"compresses", library.compresses()}};
}

json memoryJson(const VariantResult& r) {
  json j = {{"live_bytes", r.build.liveBytes},
            {"peak_bytes", r.build.peakBytes},
            {"large_page_bytes", r.build.largePageBytes},
            {"bytes_per_quad", r.build.bytesPerQuad()},
            {"inner_bytes", r.innerBytes},
            {"leaf_bytes", r.leafBytes},
            {"leaf_bytes_method", r.variant.representation.isCompressed() ? "counted" : "computed from the layout"}};
  if (r.variant.representation.isCompressed()) j["compression"] = compressionJson(r.build.compression);
  return j;
}

json viewJson(const ViewResult& v) {
  json view = {{"view", v.view}, {"errors", errorsJson(v.errors)}, {"bounced", errorsJson(v.bounced)}};
  if (v.toReference) view["errors_to_reference_level"] = errorsJson(*v.toReference);
  if (v.toTrue) view["errors_to_true_surface"] = errorsJson(*v.toTrue);
  if (!v.picture.empty()) view["picture"] = v.picture;
  if (!v.errorMap.empty()) view["error_map"] = v.errorMap;
  return view;
}

json resultJson(const VariantResult& r) {
  const Representation& what = r.variant.representation;
  const std::string label = what.label();
  json j = {{"representation", label}, {"kind", label.substr(0, label.find('^'))}, {"isa", r.variant.isa}};
  if (!r.library.empty()) j["library"] = r.library;
  if (what.hasFrames()) j["frame_level"] = what.frameLevel == autoFrameLevel ? json("auto") : json(what.frameLevel);
  if (!r.skipped.empty()) {
    j["skipped"] = r.skipped;
    return j;
  }
  j["batch"] = r.batch;
  j["build_seconds"] = r.build.seconds;
  j["memory"] = memoryJson(r);
  if (r.build.onDevice)
    j["on_device"] = {{"device", r.build.onDevice->device},
                      {"upload_seconds", r.build.onDevice->uploadSeconds},
                      {"device_bytes", r.build.onDevice->deviceBytes},
                      {"imported_bytes", r.build.onDevice->importedBytes}};
  j["views"] = json::array();
  for (const ViewResult& v : r.views) j["views"].push_back(viewJson(v));
  for (const HitAgreement& a : r.agreements) j["hit_agreement"].push_back(agreementJson(a));
  j["speed"] = json::array();
  for (const Speed& s : r.speeds) j["speed"].push_back(speedJson(s, r.build.onDevice.has_value()));
  if (r.checks.leaks) j["leaks"] = leaksJson(*r.checks.leaks);
  if (r.checks.sheets) j["sheets"] = sheetsJson(*r.checks.sheets);
  for (const CrossingCheck& c : r.checks.crossings) j["crossings"].push_back(crossingsJson(c));
  for (const ShadowCheck& c : r.checks.shadows) j["shadows"].push_back(shadowsJson(c));
  return j;
}

json groupJson(const Group& g) {
  json group = {{"scene", g.scene}, {"level", g.level},       {"faces", g.faces},
                {"quads", g.quads}, {"diagonal", g.diagonal}, {"quad_width", g.quadWidth}};
  for (const ViewInfo& v : g.views)
    group["views"].push_back({{"view", v.name},
                              {"camera", v.camera},
                              {"primary_hits", v.primaryHits},
                              {"coherent_rays", v.rays[Coherent]},
                              {"incoherent_rays", v.rays[Incoherent]}});
  group["results"] = json::array();
  for (const VariantResult& r : g.results) group["results"].push_back(resultJson(r));
  return group;
}

json settingsJson(const BenchOptions& options) {
  return {{"rays", options.rays},
          {"repeat", options.repeat},
          {"width", options.size.width},
          {"height", options.size.height},
          {"ray_offset_diagonals", options.rayOffset},
          {"true_surface_hits", options.trueHits},
          {"seed", options.seed},
          {"build_threads", options.buildThreads},
          {"device", options.device},
          {"stream_size", streamSize},
          {"check_rays", options.checks.rays},
          {"check_packets", options.checks.packets},
          {"position", {options.position.x, options.position.y, options.position.z}},
          {"max_error_diagonals", options.maxError ? json(*options.maxError) : json()},
          {"reference_level", options.referenceLevel >= 0 ? json(options.referenceLevel) : json()}};
}

/* Command, machine, build and settings. */
json runJson(const BenchOptions& options, const Machine& m) {
  json run = {{"command", options.command},
              {"date", m.date},
              {"end", dateNow()},
              {"commit", m.commit},
              {"compiler", m.compiler},
              {"flags", m.flags},
              {"build_type", m.buildType},
              {"library_isas", m.isas},
              {"cpu", m.cpu},
              {"hardware_threads", m.threads},
              {"memory_bytes", m.memoryBytes},
              {"load_before", m.load},
              {"system", m.system},
              {"settings", settingsJson(options)}};
  for (const Library& library : options.libraries)
    if (!library.name().empty()) run["libraries"].push_back(libraryJson(library));
  return run;
}

} // namespace

std::string formatJson(const BenchOptions& options, const Machine& m, const std::vector<Group>& groups, bool complete) {
  json out;
  out["format"] = "cbvh-bench";
  out["version"] = formatVersion;
  out["complete"] = complete;
  out["run"] = runJson(options, m);
  out["groups"] = json::array();
  for (const Group& g : groups) out["groups"].push_back(groupJson(g));
  return textOfJson(out, 1);
}

std::string formatAbout(const Machine& machine) {
  const json about = {{"commit", machine.commit},
                      {"isas", usableIsas(machine)},
                      {"scenes", sceneNames()},
                      {"hardware_threads", machine.threads}};
  return about.dump();
}

} // namespace programs
