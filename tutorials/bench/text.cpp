// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "text.h"
#include "measure/quantiles.h"

#include <cmath>
#include <cstdio>

namespace programs {
namespace {

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string checkLines(const CheckResult& checks) {
  std::string out;
  char line[320];
  if (checks.leaks) {
    const LeakCounts& c = *checks.leaks;
    std::snprintf(line, sizeof(line), "    leaks of %zu rays: closest %zu, any %zu, through %zu (GRID %zu, %zu, %zu)\n",
                  c.rays, c.sceneLeaks.closest, c.sceneLeaks.any, c.sceneLeaks.through, c.gridLeaks.closest,
                  c.gridLeaks.any, c.gridLeaks.through);
    out += line;
  }
  if (checks.sheets) {
    const SheetCrossings& c = *checks.sheets;
    std::snprintf(line, sizeof(line),
                  "    random sheets: %zu, rays %zu, missed: closest %zu, any %zu (GRID, too: %zu)\n", c.sheets, c.rays,
                  c.closest, c.any, c.gridMisses);
    out += line;
    for (const std::string& example : c.examples) out += "      " + example + "\n";
  }
  for (const CrossingCheck& c : checks.crossings) {
    std::snprintf(line, sizeof(line),
                  "    %s crossings of %zu rays: %zu (GRID %zu), rays with a different number %zu, parity %zu\n",
                  c.view.c_str(), c.counts.rays, c.counts.sceneCrossings, c.counts.gridCrossings,
                  c.counts.differentCounts, c.counts.differentParities);
    out += line;
  }
  for (const ShadowCheck& c : checks.shadows) {
    const ShadowComparison& s = c.comparison;
    const auto share = [](size_t n, size_t rays) { return rays ? 1000.0 * double(n) / double(rays) : 0.0; };
    std::snprintf(line, sizeof(line),
                  "    %s shadows, offset %s, %s: %.3f per 1000 rays (false occlusions %.3f, false passes %.3f); "
                  "of %zu rays with the same hit %.3f, of %zu with a flipped normal %.3f; control %.3f\n",
                  c.view.c_str(), c.offset.c_str(), std::isfinite(c.length) ? "short" : "infinite",
                  share(s.all.sum(), s.rays), share(s.all.falseOcclusions, s.rays), share(s.all.falsePasses, s.rays),
                  s.sameHitRays, share(s.sameHitErrors.sum(), s.sameHitRays), s.flippedRays,
                  share(s.flippedErrors.sum(), s.flippedRays), share(s.control.sum(), s.rays));
    out += line;
  }
  return out;
}

/* One line if all hits are equal. */
std::string agreementLines(const std::vector<HitAgreement>& agreements) {
  size_t rays = 0, differ = 0;
  std::string out;
  for (const HitAgreement& a : agreements) {
    rays += a.differences.rays;
    differ += a.differences.all();
    if (!a.differences.all()) continue;
    char line[240];
    std::snprintf(line, sizeof(line),
                  " %s %s %s: %zu of %zu rays differ from library A: %zu hit or miss, %zu IDs, %zu distances, "
                  "%zu u, v or normals\n",
                  raySetName(a.set), queryName(a.trace.query), traceModeName(a.trace.mode), a.differences.all(),
                  a.differences.rays, a.differences.hits, a.differences.ids, a.differences.distances,
                  a.differences.surfaces);
    out += "    " + a.view + line;
  }
  return rays && !differ ? "    hits of " + std::to_string(rays) + " rays are identical to library A\n" : out;
}

std::string speedLine(const Speed& s, bool onDevice) {
  std::vector<double> mrays;
  for (double seconds : s.seconds) mrays.push_back(s.mrays(seconds));
  const double toGrid = median(s.toGrid);
  char mode[32] = "";
  if (!onDevice) std::snprintf(mode, sizeof(mode), " %-8s %2u thr", traceModeName(s.trace.mode), s.trace.threads);
  char line[160];
  std::snprintf(line, sizeof(line), "%-10s %-7s%s %8.3f Mrays/s, %5.2f of GRID, spread %4.1f%%", raySetName(s.set),
                queryName(s.trace.query), mode, median(mrays), toGrid, 100.0 * interquartileRange(s.toGrid) / toGrid);
  std::string out = "    " + s.view + " " + line;
  if (!s.toFirst.empty())
    out += number(", %.3f of A", median(s.toFirst)) +
           number(", spread %4.1f%%", 100.0 * interquartileRange(s.toFirst) / median(s.toFirst));
  return out + "\n";
}

std::string resultLines(const VariantResult& r) {
  char head[160];
  std::snprintf(head, sizeof(head), "  %-13s %-7s", r.variant.representation.label().c_str(), r.variant.isa.c_str());
  std::string out = head;
  if (!r.library.empty()) out += r.library + " ";
  if (!r.skipped.empty()) return out + r.skipped + "\n";
  std::snprintf(head, sizeof(head), "%9.1f MiB %7.2f B/quad, build %6.2f s", double(r.build.liveBytes) / (1 << 20),
                r.build.bytesPerQuad(), r.build.seconds);
  out += head;
  if (r.variant.representation.hasFallbackFaces())
    out += number(", %.1f%% of the quads stored as cVERT", 100.0 * r.build.fallbackFraction());
  for (const ViewResult& v : r.views)
    out += ", " + v.view + " error median " + number("%.4f", v.errors.median) + number(" p99 %.4f px", v.errors.p99);
  if (r.build.onDevice) out += ", on " + r.build.onDevice->device;
  out += "\n" + checkLines(r.checks) + agreementLines(r.agreements);
  for (const Speed& s : r.speeds) out += speedLine(s, r.build.onDevice.has_value());
  return out;
}

} // namespace

std::string formatHead(const BenchOptions& options, const Machine& m) {
  std::string isas, threads;
  for (const std::string& isa : options.isas) isas += (isas.empty() ? "" : ", ") + isa;
  for (unsigned n : options.threads) threads += (threads.empty() ? "" : ", ") + std::to_string(n);
  const std::string device =
      options.device != "cpu" ? options.device : threads + (threads == "1" ? " thread" : " threads");
  char text[512];
  std::snprintf(text, sizeof(text),
                "commit %s, %s build by %s\n%s, %u hardware threads, load %.1f; isa %s; tracing on %s\n",
                m.commit.c_str(), m.buildType.c_str(), m.compiler.c_str(), m.cpu.c_str(), m.threads, m.load,
                isas.c_str(), device.c_str());
  std::string out = text;
  for (const Library& library : options.libraries)
    if (!library.name().empty())
      out += library.description() + ", Embree " + library.version() +
             (library.compresses() ? "\n" : " without compressed representations\n");
  return out;
}

std::string formatTable(const Group& g) {
  std::string out = "\n" + g.scene + ", level " + std::to_string(g.level) + ", " +
                    number("%.3f", double(g.quads) * 1e-6) + " million quads\n";
  for (const VariantResult& r : g.results) out += resultLines(r);
  return out;
}

} // namespace programs
