// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Displacement: moves a point of the limit surface, as a pure function of face, (u,v), normal and tessellation level,
 * so that every representation gets exactly the same surface. Most displacements move points along their normals.
 * Maps are filtered to the spacing of the level's vertices.
 *
 * Closed surfaces stay closed: if the faces at a border read different values, at a seam of an atlas or because each
 * face has its own map, all of them use the mean. */

#include "surface/cage.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace cbvh {

/* Points of a face, as Embree passes them to displacement functions. */
struct SurfacePoints
{
  unsigned face;     // of the cage
  int level;         // of the subdivision, at least 0: the spacing is 2^-level
  size_t n;          // number of points
  const float* u;    // n values
  const float* v;    // n values
  const float* levels = nullptr; // n fractional levels in [0,finestLevel] that replace `level` if edge rates differ

  float levelAt(size_t i) const { return levels ? levels[i] : float(level); }
};

/* A level at which every map is read unfiltered. */
constexpr int finestLevel = 24;

class Displacement
{
public:
  virtual ~Displacement() = default;

  /* True if points move along their normals: offsets() then returns the distances. Otherwise call vectors(). */
  virtual bool isAlongNormals() const { return true; }

  /* Writes points.n offsets along the limit normal, in world units. Thread-safe. */
  virtual void offsets(const SurfacePoints& points, float* offsets) const = 0;

  /* Writes points.n displacements, in world units along the axes of the cage. `normals` holds points.n unit vectors.
   * Thread-safe. */
  virtual void vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* vectors) const;

  /* Returns the number of texels along an edge of a face, from corner `edge` to the next; infinity without a map. */
  virtual float texelsAlong(unsigned face, unsigned edge) const;
};

/* Heights displace by scale * (height - mid level); this is the default mid level. */
constexpr float neutralHeight = 0.5f;

/* The meaning of the values of a map. */
enum class MapValues
{
  Heights,        // along the normal
  ObjectVectors,  // three channels: x, y and z of the cage
  TangentVectors, // three channels: along the texture's first axis, the normal, and its second axis
};

/* A map in a file, and how to read it. */
struct DisplacementMap
{
  std::string path;              // <UDIM> in it stands for the number of a tile, see udim_tiles.h
  float scale = 1.0f;            // world units per unit of the map's values
  MapValues values = MapValues::Heights;
  std::optional<float> midLevel; // the value that moves nothing; default: neutralHeight for heights, 0 for vectors
  std::string channel;           // the first one to read, by name or number from 0; empty: the first of the file
  Vec2f repeat{1, 1};            // copies of the map per unit of texture coordinates, or per face
};

/* Returns the value of the map that moves nothing. */
float midLevelOf(const DisplacementMap& map);

/* Reads a map through the cage's texture coordinates if it has some, otherwise on its faces.
 *
 * Texture coordinates are as in OBJ: (0,0) is the lower left corner of the image, (1,1) the upper right; the image
 * repeats outside. They are interpolated bilinearly over a face (over each corner quad of an n-gon) and not
 * subdivided: on an edge they depend on the edge alone. If the path contains <UDIM>, a face reads the tile at its
 * center, 1001 + column + 10 row, and is not displaced if that file does not exist.
 *
 * On faces, row 0 of the image is at v = 0 of the face. A file with one image: the whole image covers every face and
 * every corner quad of an n-gon. A file with several images, such as Ptex: one image per quad and n per n-gon, in
 * order.
 *
 * Appends complete lines to `warnings` for probable mistakes.
 * Throws Error for a file that cannot be read or has too few images or channels, for tangent-space vectors or <UDIM>
 * without texture coordinates, and for texture coordinates on some faces only. Throws Canceled. */
std::unique_ptr<Displacement> displaceByMap(const Cage& cage, const DisplacementMap& map, std::string& warnings);

} // namespace cbvh
