// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "robustness.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "measure/aim_points.h"

#include <sstream>

namespace programs {
namespace {

constexpr size_t pointsPerKind = 100000; // a tenth of a check's default number of rays

struct Offset {
  std::string name;
  RayOffset offset;
};

std::string text(const char* what, float factor) {
  std::ostringstream out;
  out << factor << " " << what;
  return out.str();
}

} // namespace

void Checks::add(const std::string& name) {
  if (name == "leaks") leaks = true;
  else if (name == "sheets") sheets = true;
  else if (name == "crossings") crossings = true;
  else if (name == "shadows") shadows = true;
  else if (name == "offsets") offsets = true;
  else throw Error("unknown --check '" + name + "': expected leaks, sheets, crossings, shadows or offsets");
}

Robustness::Robustness(const Model& model, const BuildSettings& settings, const std::vector<int>& frameLevels,
                       const Checks& checks, uint32_t seed)
  : model(model),
    settings(settings),
    checks(checks),
    seed(seed),
    level(settings.level),
    threads(threadCount(settings.threads)) {
  if (!checks.any()) return;
  const PatchLayout layout = model.layout(settings.level);
  const std::vector<Vec3f> vertices = tessellate(model, settings);
  for (int frameLevel : frameLevels)
    if (!points.count(blockLevel(frameLevel)))
      points[blockLevel(frameLevel)] =
          pickAimPoints({layout, level, blockLevel(frameLevel)}, vertices, pointsPerKind, seed);
  double sum = 0;
  for (const AimPoint& point : points.begin()->second[AtVertex]) sum += length(point.neighbor - point.position);
  meanQuadWidth = float(sum / double(std::max<size_t>(1, points.begin()->second[AtVertex].size())));
}

/* GRID, NAIVE and automatic frame levels use blocks of 16 x 16 quads. */
int Robustness::blockLevel(int frameLevel) const {
  return frameLevel == autoFrameLevel ? std::max(0, level - 4) : frameLevel;
}

std::optional<LeakCounts> Robustness::leaks(const BuiltScene& grid, const BuiltScene& scene) const {
  if (!checks.leaks) return std::nullopt;
  LeakSettings settings;
  settings.rays = checks.rays;
  settings.seed = seed;
  settings.thickness = scene.report().distanceFromMesh();
  /* GRID has no blocks, so any points will do. */
  const auto own = points.find(blockLevel(scene.representation().frameLevel));
  const AimPoints& aims = (own != points.end() ? own : points.begin())->second;
  const PacketTracer packets(scene.handle());
  return countLeaks(grid.handle(), checks.packets ? packets : scene.tracer(), aims, settings, threads);
}

std::optional<SheetCrossings> Robustness::sheets(const BuiltScene& scene) const {
  if (!checks.sheets || !scene.representation().isCompressed()) return std::nullopt;
  SheetSettings settings;
  settings.rays = checks.rays;
  settings.seed = seed;
  settings.device = this->settings.device;
  settings.packets = checks.packets;
  const EmbreeDevice device(scene.representation().deviceConfig()); // sets cbvh_fallback_faces
  return crossSheets(device.handle(), scene.representation().compression(), settings, threads);
}

std::vector<CrossingCheck> Robustness::crossings(const Representation& representation, const CheckedView& view) const {
  if (!checks.crossings) return {};
  BuildSettings filtered = settings;
  filtered.filters = true;
  filtered.device = "cpu"; // others do not call filters
  const BuiltScene grid(model, {RepresentationKind::Grid}, filtered), scene(model, representation, filtered);
  return {{view.name, countCrossings(grid, scene, view.primary, threads)}};
}

std::vector<ShadowCheck> Robustness::shadows(const BuiltScene& grid, const BuiltScene& scene, const CheckedView& view,
                                             const std::vector<SurfaceHit>& hits) const {
  const float diagonal = grid.bounds().diagonal();
  const float thickness = scene.report().compression.maxLeafThickness;
  std::vector<Offset> offsets;
  if (checks.shadows || checks.offsets) {
    offsets.push_back({"Embree's path tracer", RayOffset::ofEmbree()});
    offsets.push_back({"1e-4 diagonals", {1e-4f * diagonal, 0, 0}});
    offsets.push_back({"0.5 quads", {0.5f * meanQuadWidth, 0, 0}});
  }
  if (checks.offsets) {
    for (float x : {0.25f, 1.0f}) offsets.push_back({text("pixels", x), {0, x, 0}});
    for (float x : {0.01f, 0.1f, 1.0f}) offsets.push_back({text("quads", x), {x * meanQuadWidth, 0, 0}});
    for (float x : {0.1f, 0.25f, 0.5f, 1.0f})
      if (thickness > 0.0f) offsets.push_back({text("thickness", x), {x * thickness, 0, 0}});
  }
  std::vector<ShadowCheck> all;
  for (const Offset& o : offsets)
    for (float length : {INFINITY, 0.1f * diagonal}) {
      ShadowSettings settings;
      settings.offset = o.offset;
      settings.length = length;
      settings.seed = seed;
      all.push_back({view.name, o.name, o.offset, length,
                     compareShadows({grid.tracer(), view.gridHits}, {scene.tracer(), hits},
                                    {view.primary, view.footprint}, settings, threads)});
    }
  return all;
}

} // namespace programs
