// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "report.h"

#include <algorithm>
#include <cstdio>
#include <functional>

namespace programs {
namespace {

std::string number(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string scientific(double value) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

std::string mebibytes(size_t bytes) {
  const double value = double(bytes) / (1 << 20);
  return number(value, value < 1.0 ? 3 : 1);
}

class Table {
public:
  explicit Table(const std::vector<Result>& results) : results(results) {
    rows.push_back({""});
    for (const Result& r : results) rows[0].push_back(r.representation.label());
  }

  void row(const std::string& name, const std::function<std::string(const Result&)>& cell) {
    rows.push_back({name});
    for (const Result& r : results) rows.back().push_back(cell(r));
  }

  std::string text() const {
    std::vector<size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows)
      for (size_t i = 0; i < row.size(); i++) widths[i] = std::max(widths[i], row[i].size());
    std::string out;
    for (size_t r = 0; r < rows.size(); r++) {
      for (size_t i = 0; i < rows[r].size(); i++) {
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

const std::string none = "-";

bool contains(const Comparison& c, RepresentationKind kind) {
  const auto isKind = [=](const Result& r) { return r.representation.kind == kind; };
  return std::any_of(c.results.begin(), c.results.end(), isKind);
}

/* Only if there is cLEAF, which mixes two forms. */
void exactRow(Table& table, const Comparison& c) {
  if (contains(c, RepresentationKind::CLeaf))
    table.row("quads stored as cVERT, %", [](const Result& r) {
      return r.representation.hasFallbackFaces() ? number(100.0 * r.build.fallbackFraction(), 1) : none;
    });
}

std::string medianAndP99(const ErrorSummary& e) { return number(e.median, 4) + ", " + number(e.p99, 4); }

bool hasMeshErrors(const Comparison& c) {
  return std::any_of(c.results.begin(), c.results.end(), [](const Result& r) { return r.errors.has_value(); });
}

template<typename Errors>
void errorRow(Table& table, const std::string& name, std::optional<Errors> Result::* errors,
              const std::function<std::string(const Errors&)>& cell) {
  table.row(name, [=](const Result& r) { return r.*errors ? cell(*(r.*errors)) : none; });
}

void meshRow(Table& table, const std::string& name, const std::function<std::string(const HitErrors&)>& cell) {
  errorRow<HitErrors>(table, name, &Result::errors, cell);
}

void trueRow(Table& table, const std::string& name, const std::function<std::string(const TrueErrors&)>& cell) {
  errorRow<TrueErrors>(table, name, &Result::trueErrors, cell);
}

/* --- default: about a dozen rows ------------------------------------------------------- */

/* Instead of a ratio if rounds differ too much. Both rates count. */
std::string ratioCell(double ratio, const Speed& a, const Speed& b) {
  const double difference = std::max(a.difference, b.difference);
  return difference > mostRoundDifference ? "rounds differ by " + number(100 * difference, 0) + "%" : number(ratio, 2);
}

/* Relative to GRID, whose rounds are a part of each comparison with it. */
std::string gridRatioCell(const Speed& speed) { return ratioCell(speed.toGrid.value_or(0.0), speed, speed); }

std::string speedCell(const Speed& speed) {
  return number(speed.mrays, 3) + (speed.toGrid || speed.isNoisy() ? " (" + gridRatioCell(speed) + ")" : "");
}

/* Median and 99th percentile, because an RMSE would mostly show the few rays at silhouettes that hit another sheet
 * far behind. */
void addOverview(Table& table, const Comparison& c) {
  table.row("bytes per quad", [](const Result& r) { return number(r.build.bytesPerQuad(), 2); });
  exactRow(table, c);
  table.row("memory, MiB", [](const Result& r) { return mebibytes(r.build.liveBytes); });
  table.row("peak of the build, MiB", [](const Result& r) { return mebibytes(r.build.peakBytes); });
  table.row("build, s", [](const Result& r) { return number(r.build.seconds, 2); });
  if (c.speed)
    for (RaySet set : {Coherent, Incoherent})
      table.row(std::string(raySetName(set)) + " rays, millions/s" +
                    (contains(c, RepresentationKind::Grid) ? " (of GRID)" : ""),
                [=](const Result& r) { return speedCell(r.speed[set][Closest]); });
  if (hasMeshErrors(c)) {
    meshRow(table, "error against the mesh, pixels: median, p99", medianAndP99);
    meshRow(table, "false hits + misses",
            [](const HitErrors& e) { return std::to_string(e.falseHits) + " + " + std::to_string(e.misses); });
    meshRow(table, "flipped normals", [](const HitErrors& e) { return std::to_string(e.flipped); });
  }
  if (!c.trueHits) return;
  trueRow(table, "error against the true surface, pixels: median, p99", medianAndP99);
  if (!hasMeshErrors(c))
    trueRow(table, "flipped normals", [](const TrueErrors& e) { return std::to_string(e.flipped); });
}

/* --- with --details -------------------------------------------------------------------- */

void addMemory(Table& table, const Comparison& c) {
  table.row("bytes per quad", [](const Result& r) { return number(r.build.bytesPerQuad(), 2); });
  using Field = size_t RTCCompressionStatistics::*;
  const std::pair<const char*, Field> split[] = {{"- top level", &RTCCompressionStatistics::topLevelBytes},
                                                 {"- frames", &RTCCompressionStatistics::headerBytes},
                                                 {"- nodes", &RTCCompressionStatistics::nodeBytes},
                                                 {"- leaves", &RTCCompressionStatistics::leafBytes},
                                                 {"- grids", &RTCCompressionStatistics::uncompressedBytes}};
  for (const auto& [name, field] : split)
    table.row(name, [field = field](const Result& r) {
      return r.representation.isCompressed() ? number(double(r.build.compression.*field) / double(r.build.quads), 2)
                                             : none;
    });
  exactRow(table, c);
  table.row("memory, MiB", [](const Result& r) { return mebibytes(r.build.liveBytes); });
  table.row("peak of the build, MiB", [](const Result& r) { return mebibytes(r.build.peakBytes); });
  table.row("build, s", [](const Result& r) { return number(r.build.seconds, 2); });
}

void addSeams(Table& table) {
  table.row("largest gap closed at seams, world units",
            [](const Result& r) { return scientific(r.build.seams.distance); });
  table.row("- quads", [](const Result& r) { return number(r.build.seams.quads, 3); });
}

void addSpeed(Table& table, const Comparison& c) {
  const auto naive = std::find_if(c.results.begin(), c.results.end(),
                                  [](const Result& r) { return r.representation.kind == RepresentationKind::Naive; });
  for (int set = 0; set < numRaySets; set++)
    for (int query = 0; query < numQueries; query++) {
      const std::string name = std::string(raySetName(RaySet(set))) + ", " + queryName(Query(query)) + " hit";
      table.row(name + ", Mrays/s", [=](const Result& r) { return number(r.speed[set][query].mrays, 3); });
      if (!contains(c, RepresentationKind::Grid)) continue;
      table.row("- of GRID", [=](const Result& r) { return gridRatioCell(r.speed[set][query]); });
      if (naive != c.results.end())
        table.row("- of NAIVE", [=](const Result& r) {
          const Speed &own = r.speed[set][query], &base = naive->speed[set][query];
          return ratioCell(own.mrays / base.mrays, own, base);
        });
    }
}

template<typename Errors>
void addNormalsAndParameters(Table& table, std::optional<Errors> Result::* errors) {
  const auto row = [&](const std::string& name, double Errors::* value, int digits) {
    errorRow<Errors>(table, name, errors, [=](const Errors& e) { return number(e.*value, digits); });
  };
  const auto count = [&](const std::string& name, size_t Errors::* value) {
    errorRow<Errors>(table, name, errors, [=](const Errors& e) { return std::to_string(e.*value); });
  };
  row("- normal, degrees, median", &Errors::normalMedian, 3);
  row("- - p99", &Errors::normalP99, 2);
  count("- flipped normals (beyond 90 degrees)", &Errors::flipped);
  row("- (u,v), cells, median", &Errors::uvMedian, 4);
  row("- - p99", &Errors::uvP99, 3);
  count("- - on another patch", &Errors::otherPatch);
}

/* Errors of compression. The RMSE is for comparison with the paper. */
void addMeshErrors(Table& table) {
  meshRow(table, "against the mesh: error, pixels, median", [](const HitErrors& e) { return number(e.median, 4); });
  meshRow(table, "- p99", [](const HitErrors& e) { return number(e.p99, 4); });
  meshRow(table, "- max", [](const HitErrors& e) { return number(e.max, 2); });
  meshRow(table, "- the paper's RMSE", [](const HitErrors& e) { return number(e.rmse, 4); });
  meshRow(table, "- beyond 5 pixels", [](const HitErrors& e) { return std::to_string(e.outliers); });
  meshRow(table, "- bias without these", [](const HitErrors& e) { return number(e.bias, 4); });
  meshRow(table, "- false hits", [](const HitErrors& e) { return std::to_string(e.falseHits); });
  meshRow(table, "- misses", [](const HitErrors& e) { return std::to_string(e.misses); });
  addNormalsAndParameters(table, &Result::errors);
}

/* Errors of tessellation and compression. */
void addTrueErrors(Table& table) {
  trueRow(table, "against the true surface: error, pixels, median",
          [](const TrueErrors& e) { return number(e.median, 4); });
  trueRow(table, "- p99", [](const TrueErrors& e) { return number(e.p99, 4); });
  trueRow(table, "- max", [](const TrueErrors& e) { return number(e.max, 2); });
  trueRow(table, "- median, world units", [](const TrueErrors& e) { return scientific(e.medianWorld); });
  trueRow(table, "- p99, world units", [](const TrueErrors& e) { return scientific(e.p99World); });
  trueRow(table, "- not within 5 pixels along the ray", [](const TrueErrors& e) { return std::to_string(e.outliers); });
  trueRow(table, "- bias along the ray without these", [](const TrueErrors& e) { return number(e.bias, 4); });
  addNormalsAndParameters(table, &Result::trueErrors);
}

void addDetails(Table& table, const Comparison& c) {
  addMemory(table, c);
  const auto hasSeams = [](const Result& r) { return r.build.seams.distance > 0.0f; };
  if (std::any_of(c.results.begin(), c.results.end(), hasSeams)) addSeams(table);
  if (c.speed) addSpeed(table, c);
  if (hasMeshErrors(c)) addMeshErrors(table);
  if (c.trueHits) addTrueErrors(table);
  for (int set = 0; c.compares && set < numRaySets; set++)
    table.row(std::string("any-hit disagreements, ") + raySetName(RaySet(set)),
              [=](const Result& r) { return std::to_string(r.anyDisagreements[set]); });
}

/* --- lines above the table ------------------------------------------------------------- */

std::string modelLine(const Comparison& c) {
  const size_t quads = c.results[0].build.quads;
  const std::string level = c.isMesh         ? "not subdivided, "
                            : c.quadSize > 0 ? "level auto, "
                                             : "level " + std::to_string(c.build.level) + ", ";
  return c.model + ": " + std::to_string(c.faces) + " faces, " + level +
         (quads < 100000 ? std::to_string(quads) : number(double(quads) * 1e-6, 2) + " million") + " quads; " +
         std::to_string(c.size.width) + " x " + std::to_string(c.size.height) + " pixels from " + c.camera + ", " +
         std::to_string(c.primaryHits) + " hit\n";
}

std::string speedLine(const Comparison& c) {
  const auto& device = c.results[0].build.onDevice;
  return "speed: " + (device ? device->device : "one thread, single rays") + ", " + std::to_string(c.rays[Coherent]) +
         " coherent and " + std::to_string(c.rays[Incoherent]) + " incoherent rays; isa " +
         (c.build.isa.empty() ? "the host's best" : c.build.isa) + "\n";
}

std::string errorLine(const Comparison& c) {
  std::string line;
  if (hasMeshErrors(c)) line += "mesh: " + c.reference + ", " + std::to_string(c.primaryHits) + " pixels";
  if (c.trueHits)
    line += std::string(line.empty() ? "" : "; ") + "true surface: " + std::to_string(c.trueHits) + " hits";
  return line.empty() ? "" : "errors against " + line + "\n";
}

} // namespace

std::string formatTable(const Comparison& c, bool details) {
  Table table(c.results);
  if (details) addDetails(table, c);
  else addOverview(table, c);
  return modelLine(c) + (c.speed ? speedLine(c) : "") + errorLine(c) + "\n" + table.text() + "\n" + c.pictures;
}

} // namespace programs
