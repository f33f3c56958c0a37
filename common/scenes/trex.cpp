// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/trex.h"
#include "basics/file_output.h"
#include "basics/parallel.h"
#include "scenes/baked_heights.h"
#include "scenes/trex_cage.h"
#include "scenes/trex_skin.h"
#include "surface/face_atlas.h"

#include <filesystem>

namespace programs {
namespace {

/* Texels per side of a face: one per vertex at level 6. Fewer in the atlas, because more than half of it is empty. */
constexpr int tileTexels = 64, chartTexels = 48;

/* Changes with everything on which the texels depend. */
std::string recipe(const Cage& cage, const char* mapping, int texels) {
  return "trex skin " + std::to_string(trexSkinVersion) + ", " + mapping + " of " + std::to_string(texels) +
         " texels, cage " + fingerprint(cage);
}

} // namespace

Model makeTrex(const TrexSettings& settings) {
  const bool faces = settings.mapping == TrexMapping::Faces;
  TrexCage trex = makeTrexCage();
  const std::string path =
      (std::filesystem::path(settings.mapFolder) / (faces ? "trex_height.exr" : "trex_height_atlas.exr")).string();
  const std::string made = faces ? recipe(trex.cage, "tiles", tileTexels) : recipe(trex.cage, "charts", chartTexels);
  const Bake bake{"trex: skin", threadCount(settings.threads),
                  [&](const LimitPoint& p) { return trexHeight(trex.parts[p.face], p.position); }};

  Model model;
  model.name = "trex";
  const float scale = settings.amplitude * trex.cage.bounds().diagonal();
  const bool cached = HeightMap::recipeOf(path) == made;
  if (!cached)
    prepareOutputFolder(settings.mapFolder.empty() ? "." : settings.mapFolder); // fails before the work, not after it
  if (faces) {
    const FaceAtlas atlas = FaceAtlas::forFaces(trex.cage.numFaces(), tileTexels);
    HeightMap map = cached ? HeightMap::read(path) : bakeTiles(trex.cage, atlas, bake);
    if (!cached) map.write(path, made);
    model.displacement = displaceByAtlas(trex.cage, atlas, std::move(map), scale);
  } else {
    if (cached) assignChartUVs(trex.cage, chartTexels);
    else bakeCharts(trex.cage, chartTexels, bake).write(path, made);
    DisplacementMap map;
    map.path = path;
    map.scale = scale;
    std::string ignored; // warnings are for users' maps
    model.displacement = displaceByMap(trex.cage, map, ignored);
  }
  model.cage = std::move(trex.cage);
  model.view.direction = {-0.62f, -0.12f, -0.8f};
  model.view.closePoint = {0.84f, 0.24f};
  model.view.closeDistance = 0.13f;
  return model;
}

} // namespace programs
