// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/built_scene.h"
#include "measure/crossings.h"
#include "measure/leak_rays.h"
#include "measure/self_shadow.h"
#include "measure/sheet_crossings.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace programs {

struct Checks {
  bool leaks = false;
  bool sheets = false;
  bool crossings = false; // hits that a filter receives if it rejects all
  bool shadows = false;   // at three offsets
  bool offsets = false;   // at many offsets
  size_t rays = 1000000;  // per representation, for leaks and for sheets
  bool packets = false;   // instead of single rays

  bool any() const { return leaks || sheets || crossings || shadows || offsets; }

  /* Throws Error. */
  void add(const std::string& name);
};

struct ShadowCheck {
  std::string view;
  std::string offset; // in words
  RayOffset settings;
  float length = INFINITY; // of the rays
  ShadowComparison comparison;
};

struct CrossingCheck {
  std::string view;
  CrossingCounts counts;
};

struct CheckResult {
  std::optional<LeakCounts> leaks;
  std::optional<SheetCrossings> sheets;
  std::vector<CrossingCheck> crossings;
  std::vector<ShadowCheck> shadows;
};

struct CheckedView {
  const std::string& name;
  const std::vector<Ray>& primary;
  const std::vector<SurfaceHit>& gridHits;
  float footprint;
};

class Robustness {
public:
  /* `frameLevels` belong to the representations. The model must outlive this object. Throws Error. */
  Robustness(const Model& model, const BuildSettings& settings, const std::vector<int>& frameLevels,
             const Checks& checks, uint32_t seed);

  std::optional<LeakCounts> leaks(const BuiltScene& grid, const BuiltScene& scene) const;

  /* Checks the scene's representation with random sheets; nothing for NAIVE and GRID. */
  std::optional<SheetCrossings> sheets(const BuiltScene& scene) const;

  /* `hits` belong to the view's primary rays. */
  std::vector<ShadowCheck> shadows(const BuiltScene& grid, const BuiltScene& scene, const CheckedView& view,
                                   const std::vector<SurfaceHit>& hits) const;

  /* Builds the representation and GRID once more, with filters. */
  std::vector<CrossingCheck> crossings(const Representation& representation, const CheckedView& view) const;

  float quadWidth() const { return meanQuadWidth; }

private:
  int blockLevel(int frameLevel) const;

  const Model& model;
  BuildSettings settings;
  Checks checks;
  uint32_t seed;
  int level;
  unsigned threads;
  float meanQuadWidth = 0;
  std::map<int, AimPoints> points; // by frame level
};

} // namespace programs
