// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "report.h"
#include "programs/compression_json.h"
#include "programs/errors_json.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <functional>

namespace cbvh {
namespace {

using nlohmann::json;

std::string number(double value, int digits)
{
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string scientific(double value)
{
  char text[64];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

class Table
{
public:
  explicit Table(const std::vector<Result>& results) : results(results)
  {
    rows.push_back({""});
    for (const Result& r : results)
      rows[0].push_back(r.representation.label());
  }

  void row(const std::string& name, const std::function<std::string(const Result&)>& cell)
  {
    rows.push_back({name});
    for (const Result& r : results)
      rows.back().push_back(cell(r));
  }

  std::string text() const
  {
    std::vector<size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows)
      for (size_t i = 0; i < row.size(); i++)
        widths[i] = std::max(widths[i], row[i].size());
    std::string out;
    for (size_t r = 0; r < rows.size(); r++)
    {
      for (size_t i = 0; i < rows[r].size(); i++)
      {
        const std::string fill(widths[i] - rows[r][i].size(), ' ');
        out += i == 0 ? "| " + rows[r][i] + fill : " | " + fill + rows[r][i];
      }
      out += " |\n";
      if (r == 0)
        for (size_t i = 0; i < widths.size(); i++)
          out += (i == 0 ? "|:" : "|-") + std::string(widths[i], '-') + (i == 0 ? "-" : ":") +
                 (i + 1 == widths.size() ? "|\n" : "");
    }
    return out;
  }

private:
  const std::vector<Result>& results;
  std::vector<std::vector<std::string>> rows;
};

const Result* findNaive(const Comparison& c)
{
  for (const Result& r : c.results)
    if (r.representation.kind == RepresentationKind::Naive)
      return &r;
  return nullptr;
}

void addMemory(Table& table)
{
  table.row("bytes a quad", [](const Result& r) { return number(r.build.bytesPerQuad(), 2); });
  using Field = size_t RTCCompressionStatistics::*;
  const std::pair<const char*, Field> split[] = {{"- top level", &RTCCompressionStatistics::topLevelBytes},
                                                 {"- frames", &RTCCompressionStatistics::frameBytes},
                                                 {"- nodes", &RTCCompressionStatistics::nodeBytes},
                                                 {"- leaves", &RTCCompressionStatistics::leafBytes},
                                                 {"- grids", &RTCCompressionStatistics::gridBytes}};
  for (const auto& [name, field] : split)
    table.row(name, [field = field](const Result& r) {
      return r.representation.isCompressed() ? number(double(r.build.compression.*field) / double(r.build.quads), 2)
                                             : std::string("-");
    });
  table.row("quads of cLEAF stored as cVERT, %", [](const Result& r) {
    return r.representation.kind == RepresentationKind::CLeaf
             ? number(100.0 * double(r.build.compression.numExactQuads) / double(r.build.quads), 1)
             : std::string("-");
  });
  table.row("memory, MiB", [](const Result& r) { return number(double(r.build.liveBytes) / (1 << 20), 1); });
  table.row("peak of the build, MiB", [](const Result& r) { return number(double(r.build.peakBytes) / (1 << 20), 1); });
  table.row("build, s", [](const Result& r) { return number(r.build.seconds, 2); });
}

void addSpeed(Table& table, const Comparison& c)
{
  const Result* naive = findNaive(c);
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++)
    {
      const std::string name = std::string(raySetName(RaySet(set))) + ", " + queryName(Query(query)) + " hit";
      table.row(name + ", Mrays/s", [=](const Result& r) { return number(r.speed[set][query].mrays, 3); });
      table.row("- of GRID", [=](const Result& r) { return number(r.speed[set][query].toGrid, 2); });
      if (naive)
        table.row("- of NAIVE", [=](const Result& r) {
          return number(r.speed[set][query].toGrid / naive->speed[set][query].toGrid, 2);
        });
    }
}

template<typename Errors>
void addNormalsAndParameters(Table& table, std::optional<Errors> Result::*errors)
{
  const auto row = [&](const std::string& name, double Errors::*value, int digits) {
    table.row(name, [=](const Result& r) { return r.*errors ? number((*(r.*errors)).*value, digits) : std::string("-"); });
  };
  row("- normal, degrees, median", &Errors::normalMedian, 3);
  row("- - p99", &Errors::normalP99, 2);
  table.row("- - beyond 90 degrees", [=](const Result& r) {
    return r.*errors ? std::to_string((*(r.*errors)).flipped) : std::string("-");
  });
  row("- (u,v), cells, median", &Errors::uvMedian, 4);
  row("- - p99", &Errors::uvP99, 3);
  table.row("- - on another patch", [=](const Result& r) {
    return r.*errors ? std::to_string((*(r.*errors)).otherPatch) : std::string("-");
  });
}

/* What compression costs. */
void addMeshErrors(Table& table)
{
  const auto error = [&](const std::string& name, const std::function<std::string(const HitErrors&)>& cell) {
    table.row(name, [=](const Result& r) { return r.errors ? cell(*r.errors) : std::string("-"); });
  };
  error("against the mesh: error RMSE, pixels", [](const HitErrors& e) { return number(e.rmse, 4); });
  error("- median", [](const HitErrors& e) { return number(e.median, 4); });
  error("- p99", [](const HitErrors& e) { return number(e.p99, 4); });
  error("- max", [](const HitErrors& e) { return number(e.max, 2); });
  error("- beyond 5 pixels", [](const HitErrors& e) { return std::to_string(e.farOff); });
  error("- RMSE of the others", [](const HitErrors& e) { return number(e.rmseOfOthers, 4); });
  error("- bias of the others", [](const HitErrors& e) { return number(e.bias, 4); });
  error("- false hits", [](const HitErrors& e) { return std::to_string(e.falseHits); });
  error("- misses", [](const HitErrors& e) { return std::to_string(e.misses); });
  addNormalsAndParameters(table, &Result::errors);
}

/* What tessellation and compression cost. */
void addTrueErrors(Table& table)
{
  const auto error = [&](const std::string& name, const std::function<std::string(const TrueErrors&)>& cell) {
    table.row(name, [=](const Result& r) { return r.trueErrors ? cell(*r.trueErrors) : std::string("-"); });
  };
  error("against the true surface: RMSE, pixels", [](const TrueErrors& e) { return number(e.rmse, 4); });
  error("- median", [](const TrueErrors& e) { return number(e.median, 4); });
  error("- p99", [](const TrueErrors& e) { return number(e.p99, 4); });
  error("- max", [](const TrueErrors& e) { return number(e.max, 2); });
  error("- RMSE, world units", [](const TrueErrors& e) { return scientific(e.rmseWorld); });
  error("- median, world units", [](const TrueErrors& e) { return scientific(e.medianWorld); });
  error("- not within 5 pixels along the ray", [](const TrueErrors& e) { return std::to_string(e.apart); });
  error("- RMSE of the others along the ray", [](const TrueErrors& e) { return number(e.rmseAlong, 4); });
  error("- bias of the others", [](const TrueErrors& e) { return number(e.bias, 4); });
  addNormalsAndParameters(table, &Result::trueErrors);
}

/* speed: whether it was measured. */
json resultJson(const Result& r, bool speed)
{
  json j;
  j["representation"] = r.representation.label();
  j["quads"] = r.build.quads;
  j["bytes_per_quad"] = r.build.bytesPerQuad();
  j["live_bytes"] = r.build.liveBytes;
  j["peak_bytes"] = r.build.peakBytes;
  j["build_seconds"] = r.build.seconds;
  if (r.build.onDevice)
    j["on_device"] = {{"upload_seconds", r.build.onDevice->uploadSeconds},
                      {"device_bytes", r.build.onDevice->deviceBytes},
                      {"imported_bytes", r.build.onDevice->importedBytes}};
  if (r.representation.isCompressed())
    j["compression"] = compressionJson(r.build.compression);
  for (RaySet set : {Coherent, Incoherent})
  {
    const char* const name = raySetName(set);
    j["any_hit_disagreements"][name] = r.anyDisagreements[set];
    for (Query query : {Closest, Any})
      if (speed)
        j["speed"][name][queryName(query)] = {{"mrays_per_second", r.speed[set][query].mrays},
                                              {"relative_to_grid", r.speed[set][query].toGrid}};
  }
  if (r.errors)
    j["errors"] = errorsJson(*r.errors);
  if (r.trueErrors)
    j["errors_to_true_surface"] = errorsJson(*r.trueErrors);
  return j;
}

const VulkanSceneReport* onDevice(const Comparison& c)
{
  return !c.results.empty() && c.results[0].build.onDevice ? &*c.results[0].build.onDevice : nullptr;
}

std::string tracedBy(const Comparison& c)
{
  return onDevice(c) ? onDevice(c)->device : "one thread, single rays";
}

} // namespace

std::string formatTable(const Comparison& c)
{
  char head[1024];
  std::snprintf(head, sizeof(head),
                "%s: %zu faces, level %d, %.2f million quads; %d x %d pixels from %s, %zu hit\n"
                "speed: %s, %zu coherent and %zu incoherent; mesh: %s; true surface: %zu hits; %s%s\n\n",
                c.model.c_str(), c.faces, c.build.level, c.results.empty() ? 0.0 : double(c.results[0].build.quads) * 1e-6,
                c.size.width, c.size.height, c.camera.c_str(), c.primaryHits, tracedBy(c).c_str(), c.rays[Coherent], c.rays[Incoherent],
                c.reference.c_str(), c.trueHits, "isa ", c.build.isa.empty() ? "best of the host" : c.build.isa.c_str());
  Table table(c.results);
  addMemory(table);
  if (c.speed)
    addSpeed(table, c);
  addMeshErrors(table);
  if (c.trueHits)
    addTrueErrors(table);
  for (int set = 0; set < numRaySets; set++)
    table.row(std::string("any hit disagrees, ") + raySetName(RaySet(set)),
              [=](const Result& r) { return std::to_string(r.anyDisagreements[set]); });
  return head + table.text();
}

std::string formatJson(const Comparison& c)
{
  json out;
  out["model"] = c.model;
  out["faces"] = c.faces;
  out["level"] = c.build.level;
  out["device"] = c.build.device;
  if (onDevice(c))
    out["device_name"] = onDevice(c)->device;
  out["isa"] = c.build.isa.empty() ? "best" : c.build.isa;
  out["width"] = c.size.width;
  out["height"] = c.size.height;
  out["camera"] = c.camera;
  out["primary_hits"] = c.primaryHits;
  out["coherent_rays"] = c.rays[Coherent];
  out["incoherent_rays"] = c.rays[Incoherent];
  out["error_reference"] = c.reference;
  out["true_surface_hits"] = c.trueHits;
  for (const Result& r : c.results)
    out["results"].push_back(resultJson(r, c.speed));
  return out.dump(2) + "\n";
}

} // namespace cbvh
