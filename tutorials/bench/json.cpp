// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "json.h"
#include "measure/quantiles.h"
#include "programs/errors_json.h"

#include <algorithm>
#include <cstdio>

namespace cbvh {
namespace {

using nlohmann::json;

/* Of the format below; readers refuse others. */
constexpr int formatVersion = 2;

json summary(const std::vector<double>& values)
{
  const double middle = median(values);
  return {{"median", middle},
          {"min", *std::min_element(values.begin(), values.end())},
          {"max", *std::max_element(values.begin(), values.end())},
          {"spread", interquartileRange(values) / middle}};
}

json leaksJson(const Leaks& l)
{
  return {{"closest", l.closest}, {"any", l.any}, {"through", l.through}};
}

json leaksJson(const LeakCounts& c)
{
  json j = {{"rays", c.rays},
            {"aimed_rays", c.aimed},
            {"missed", leaksJson(c.ofScene)},
            {"missed_unaimed", leaksJson(c.random)},
            {"missed_by_grid", leaksJson(c.ofGrid)},
            {"examples", json::array()}};
  for (const Ray& r : c.examples)
    j["examples"].push_back({r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z});
  return j;
}

json sheetsJson(const SheetCrossings& c)
{
  return {{"sheets", c.sheets}, {"rays", c.rays}, {"closest", c.closest}, {"any", c.any}, {"missed_by_grid", c.ofGrid}, {"examples", c.examples}};
}

json shadowJson(const ShadowErrors& e)
{
  return {{"false_occlusions", e.falseOcclusions}, {"false_passes", e.falsePasses}};
}

json shadowsJson(const ShadowCheck& c)
{
  return {{"view", c.view},
          {"offset", c.offset},
          {"offset_length", c.settings.length},
          {"offset_pixels", c.settings.pixels},
          {"offset_ulps", c.settings.ulps},
          {"length", std::isfinite(c.length) ? json(c.length) : json()},
          {"rays", c.found.rays},
          {"occluded", c.found.occluded},
          {"errors", shadowJson(c.found.all)},
          {"same_place_rays", c.found.raysOfSame},
          {"same_place_errors", shadowJson(c.found.ofSame)},
          {"turned_rays", c.found.raysOfTurned},
          {"turned_errors", shadowJson(c.found.ofTurned)},
          {"control_errors", shadowJson(c.found.control)}};
}

json speedJson(const Speed& s)
{
  std::vector<double> mrays;
  for (double seconds : s.seconds)
    mrays.push_back(s.mrays(seconds));
  return {{"view", s.view},
          {"set", raySetName(s.set)},
          {"query", queryName(s.trace.query)},
          {"mode", traceModeName(s.trace.mode)},
          {"threads", s.trace.threads},
          {"clock", s.trace.threads > 1 ? "wall" : "processor time of the thread"},
          {"passes", s.trace.passes},
          {"rays", s.rays},
          {"hits", s.hits},
          {"seconds", s.seconds},
          {"mrays_per_second", summary(mrays)},
          {"relative_to_grid", summary(s.toGrid)}};
}

json memoryJson(const VariantResult& r)
{
  const RTCCompressionStatistics& s = r.build.compression;
  json j = {{"live_bytes", r.build.liveBytes},
            {"peak_bytes", r.build.peakBytes},
            {"bytes_per_quad", r.build.bytesPerQuad()},
            {"inner_bytes", r.innerBytes},
            {"leaf_bytes", r.leafBytes},
            {"leaf_bytes_are", r.variant.representation.isCompressed() ? "counted" : "computed from the layout"}};
  if (r.variant.representation.isCompressed())
    j["compression"] = {{"top_level_bytes", s.topLevelBytes}, {"frame_bytes", s.frameBytes},
                        {"node_bytes", s.nodeBytes},          {"leaf_bytes", s.leafBytes},
                        {"grid_bytes", s.gridBytes},          {"blocks", s.numBlocks},
                        {"quads", s.numQuads},                {"grid_quads", s.numGridQuads},
                        {"invalid_quads", s.numInvalidQuads}, {"affine_blocks", s.numAffineBlocks},
                        {"solid_leaves", s.numSolidLeaves},   {"max_leaf_thickness", s.maxLeafThickness}};
  return j;
}

json resultJson(const VariantResult& r)
{
  const Representation& what = r.variant.representation;
  const std::string label = what.label();
  json j = {{"representation", label}, {"kind", label.substr(0, label.find('^'))}, {"isa", r.variant.isa}};
  if (what.isCompressed())
    j["frame_level"] = what.frameLevel == autoFrameLevel ? json("auto") : json(what.frameLevel);
  if (!r.skipped.empty())
  {
    j["skipped"] = r.skipped;
    return j;
  }
  j["batch"] = r.batch;
  j["build_seconds"] = r.build.seconds;
  j["memory"] = memoryJson(r);
  j["views"] = json::array();
  for (const ViewResult& v : r.views)
  {
    json view = {{"view", v.view},
                 {"errors", errorsJson(v.errors)},
                 {"errors_away_from_silhouettes", errorsJson(v.away)},
                 {"bounced", errorsJson(v.bounced)}};
    if (v.toReference)
      view["errors_to_reference_level"] = errorsJson(*v.toReference);
    if (v.toTrue)
      view["errors_to_true_surface"] = errorsJson(*v.toTrue);
    if (v.bins)
      view["bins_of_4_bits"] = heightBinsJson(*v.bins);
    if (v.binsAway)
      view["bins_of_4_bits_away_from_silhouettes"] = heightBinsJson(*v.binsAway);
    if (!v.picture.empty())
      view["picture"] = v.picture;
    if (!v.errorMap.empty())
      view["error_map"] = v.errorMap;
    j["views"].push_back(view);
  }
  j["speed"] = json::array();
  for (const Speed& s : r.speeds)
    j["speed"].push_back(speedJson(s));
  if (r.checks.leaks)
    j["leaks"] = leaksJson(*r.checks.leaks);
  if (r.checks.sheets)
    j["sheets"] = sheetsJson(*r.checks.sheets);
  for (const ShadowCheck& c : r.checks.shadows)
    j["shadows"].push_back(shadowsJson(c));
  return j;
}

std::string checkLines(const CheckResult& checks)
{
  std::string out;
  char line[240];
  if (checks.leaks)
  {
    const LeakCounts& c = *checks.leaks;
    std::snprintf(line, sizeof(line),
                  "    leaks of %zu rays: closest %zu, any %zu, through %zu (GRID %zu, %zu, %zu)\n", c.rays,
                  c.ofScene.closest, c.ofScene.any, c.ofScene.through, c.ofGrid.closest, c.ofGrid.any,
                  c.ofGrid.through);
    out += line;
  }
  if (checks.sheets)
  {
    std::snprintf(line, sizeof(line), "    through %zu random sheets, of %zu rays: closest %zu, any %zu (GRID, too: %zu)\n", checks.sheets->sheets,
                  checks.sheets->rays, checks.sheets->closest, checks.sheets->any, checks.sheets->ofGrid);
    out += line;
    for (const std::string& example : checks.sheets->examples)
      out += "      " + example + "\n";
  }
  for (const ShadowCheck& c : checks.shadows)
  {
    const auto share = [](size_t n, size_t rays) { return rays ? 1000.0 * double(n) / double(rays) : 0.0; };
    std::snprintf(line, sizeof(line),
                  "    %s shadows, offset %s, %s: %.3f per 1000 (occluded %.3f, passed %.3f); "
                  "same place %.3f; turned %.3f; control %.3f\n",
                  c.view.c_str(), c.offset.c_str(), std::isfinite(c.length) ? "short" : "infinite",
                  share(c.found.all.sum(), c.found.rays), share(c.found.all.falseOcclusions, c.found.rays),
                  share(c.found.all.falsePasses, c.found.rays), share(c.found.ofSame.sum(), c.found.raysOfSame),
                  share(c.found.ofTurned.sum(), c.found.rays), share(c.found.control.sum(), c.found.rays));
    out += line;
  }
  return out;
}

std::string number(const char* format, double value)
{
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

} // namespace

std::string formatJson(const BenchOptions& options, const Machine& m, const std::vector<Group>& groups,
                       bool complete)
{
  json out;
  out["format"] = "cbvh-bench";
  out["version"] = formatVersion;
  out["complete"] = complete;
  out["run"] = {{"command", options.command},
                {"date", m.date},
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
                {"settings",
                 {{"rays", options.rays},
                  {"repeat", options.repeat},
                  {"width", options.size.width},
                  {"height", options.size.height},
                  {"ray_offset_diagonals", options.rayOffset},
                  {"true_surface_hits", options.trueHits},
                  {"seed", options.seed},
                  {"build_threads", options.buildThreads},
                  {"stream_size", streamSize},
                  {"check_rays", options.checks.rays},
                  {"position", {options.position.x, options.position.y, options.position.z}},
                  {"max_error_diagonals", options.maxError},
                  {"reference_level", options.referenceLevel >= 0 ? json(options.referenceLevel) : json()}}}};
  out["groups"] = json::array();
  for (const Group& g : groups)
  {
    json group = {{"scene", g.scene},
                  {"level", g.level},
                  {"faces", g.faces},
                  {"quads", g.quads},
                  {"diagonal", g.diagonal},
                  {"quad_width", g.quadWidth}};
    for (const ViewInfo& v : g.views)
      group["views"].push_back({{"view", v.name},
                                {"camera", v.camera},
                                {"primary_hits", v.primaryHits},
                                {"coherent_rays", v.rays[Coherent]},
                                {"incoherent_rays", v.rays[Incoherent]}});
    group["results"] = json::array();
    for (const VariantResult& r : g.results)
      group["results"].push_back(resultJson(r));
    out["groups"].push_back(group);
  }
  return out.dump(1) + "\n";
}

std::string formatAbout(const Machine& machine)
{
  const json about = {{"commit", machine.commit}, {"isas", usableIsas(machine)}, {"scenes", sceneNames()},
                      {"hardware_threads", machine.threads}};
  return about.dump();
}

std::string formatHead(const BenchOptions& options, const Machine& m)
{
  std::string isas, threads;
  for (const std::string& isa : options.isas)
    isas += (isas.empty() ? "" : ", ") + isa;
  for (unsigned n : options.threads)
    threads += (threads.empty() ? "" : ", ") + std::to_string(n);
  char text[512];
  std::snprintf(text, sizeof(text),
                "commit %s, %s build by %s\n%s, %u hardware threads, load %.1f; isa %s; tracing on %s thread%s\n",
                m.commit.c_str(), m.buildType.c_str(), m.compiler.c_str(), m.cpu.c_str(), m.threads, m.load,
                isas.c_str(), threads.c_str(), threads == "1" ? "" : "s");
  return text;
}

std::string formatTable(const Group& g)
{
  std::string out = "\n" + g.scene + ", level " + std::to_string(g.level) + ", " +
                    number("%.3f", double(g.quads) * 1e-6) + " million quads\n";
  for (const VariantResult& r : g.results)
  {
    char head[160];
    std::snprintf(head, sizeof(head), "  %-10s %-7s", r.variant.representation.label().c_str(), r.variant.isa.c_str());
    out += head;
    if (!r.skipped.empty())
    {
      out += r.skipped + "\n";
      continue;
    }
    std::snprintf(head, sizeof(head), "%9.1f MiB %7.2f B/quad, build %6.2f s", double(r.build.liveBytes) / (1 << 20),
                  r.build.bytesPerQuad(), r.build.seconds);
    out += head;
    for (const ViewResult& v : r.views)
      out += ", " + v.view + " RMSE " + number("%.4f px", v.errors.rmse);
    out += "\n";
    out += checkLines(r.checks);
    for (const Speed& s : r.speeds)
    {
      std::vector<double> mrays;
      for (double seconds : s.seconds)
        mrays.push_back(s.mrays(seconds));
      const double toGrid = median(s.toGrid);
      std::snprintf(head, sizeof(head), "%-10s %-7s %-8s %2u thr %8.3f Mrays/s, %5.2f of GRID, spread %4.1f%%\n",
                    raySetName(s.set), queryName(s.trace.query), traceModeName(s.trace.mode), s.trace.threads,
                    median(mrays), toGrid, 100.0 * interquartileRange(s.toGrid) / toGrid);
      out += "    " + s.view + " " + head;
    }
  }
  return out;
}

} // namespace cbvh
