// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moves points of the limit surface, as a pure function of face, (u,v), normal and tessellation level, so that all
 * representations have the same surface. Maps are filtered to the spacing of the level's vertices.
 *
 * Closed surfaces stay closed: faces that read different values at a border, such as a seam of an atlas, use their
 * mean. A face reads no texels beyond the seams of its chart, see chart_filter.h. */

#include "surface/cage.h"
#include "surface/texture_wrap.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace programs {

class SeamGaps;

struct SurfacePoints {
  unsigned face;
  int level; // at least 0: the spacing is 2^-level
  size_t n;
  const float* u;                // n values
  const float* v;                // n values
  const float* levels = nullptr; // n fractional levels in [0,finestLevel], replace `level` if set
  SeamGaps* gaps = nullptr;      // receives the gaps that are closed, if set

  float levelAt(size_t i) const { return levels ? levels[i] : float(level); }
};

/* Reads every map unfiltered. */
constexpr int finestLevel = 24;

class Displacement {
public:
  virtual ~Displacement() = default;

  /* True if offsets() returns all of the displacement; otherwise call vectors(). */
  virtual bool isAlongNormals() const { return true; }

  /* Writes distances along the limit normal, in world units. Thread-safe. */
  virtual void offsets(const SurfacePoints& points, float* offsets) const = 0;

  /* Writes displacements in world units, along the cage's axes. `normals` are unit vectors. Thread-safe. */
  virtual void vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* vectors) const;

  /* Number of texels from corner `edge` to the next; infinity without a map. */
  virtual float texelsAlongEdge(unsigned face, unsigned edge) const;
};

/* Default mid level: heights displace by scale * (height - mid level). */
constexpr float neutralHeight = 0.5f;

enum class MapValues {
  Heights,        // along the normal
  ObjectVectors,  // channels x, y and z of the cage
  TangentVectors, // channels along the texture's first axis, the normal, and the second axis
};

struct DisplacementMap {
  std::string path;   // may contain <UDIM>, see udim_tiles.h
  float scale = 1.0f; // world units per unit of the map's values
  MapValues values = MapValues::Heights;
  std::optional<float> midLevel;   // value that moves nothing; default: neutralHeight for heights, 0 for vectors
  std::string channel;             // first one, by name or number from 0; empty: the file's first
  std::optional<TextureWrap> wrap; // default: Repeat, but Clamp for tiles, and on faces unless repeated
  Vec2f repeat{1, 1};              // copies of the map per unit of texture coordinates, or per face
};

float midLevelOf(const DisplacementMap& map);

/* Reads a map through the cage's texture coordinates, or on faces if it has none.
 *
 * Texture coordinates are as in OBJ: (0,0) is the lower left corner of the image, (1,1) the upper right; `wrap` states
 * how the image continues outside. They are interpolated bilinearly over a face (over each corner quad of an n-gon)
 * and not subdivided: on an edge they depend on the edge alone. If the path contains <UDIM>, a face reads the tile at
 * its center, 1001 + column + 10 row, and is not displaced if that file does not exist.
 *
 * On faces, row 0 of the image is at v = 0. A file with one image covers every face and every corner quad of an
 * n-gon. A file with several images, such as Ptex, has one image per quad and n per n-gon, in order.
 *
 * Appends lines to `warnings` for probable mistakes. Throws Error for a file that cannot be read or has too few
 * images or channels, for tangent-space vectors or <UDIM> without texture coordinates, and for texture coordinates
 * on some faces only. */
std::unique_ptr<Displacement> displaceByMap(const Cage& cage, const DisplacementMap& map, std::string& warnings);

} // namespace programs
