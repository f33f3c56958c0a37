// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A raster of heights as a scene, which traces rays of the raster's coordinates. Methods need no lock of Python. */

#include "georeference.h"
#include "ray_arrays.h"
#include "ray_errors.h"
#include "terrain_hits.h"

#include "building/traced_scene.h"

#include <filesystem>
#include <memory>
#include <vector>

namespace programs::python {

class Terrain {
public:
  /* file: absolute path, empty in memory. */
  Terrain(const Georeference& space, std::unique_ptr<const TracedScene> scene, double seconds,
          std::filesystem::path file)
    : space(space),
      scene(std::move(scene)),
      seconds(seconds),
      file(std::move(file)) {}

  /* Throw Error and Canceled. `hits` has an element per ray. */
  void intersect(const RayArrays& rays, unsigned threads, TerrainHit* hits) const;
  void occluded(const RayArrays& rays, unsigned threads, bool* hits) const;

  /* Elevations of the horizon in degrees, -90 to 90: of all azimuths at the first point, then at the second one, and so
   * on. azimuths: in degrees, from north to east. accuracy: in degrees. */
  std::vector<float> horizons(const std::vector<Vec3d>& points, const std::vector<double>& azimuths, double accuracy,
                              unsigned threads) const;

  const Georeference space;
  const std::unique_ptr<const TracedScene> scene;
  const double seconds; // for building or opening it
  const std::filesystem::path file;

private:
  RayErrors errors;
};

/* Adds methods of horizons to the class Terrain. */
void defineHorizons(py::class_<Terrain, std::shared_ptr<Terrain>>& terrain);

} // namespace programs::python
