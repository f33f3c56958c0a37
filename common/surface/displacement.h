// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Displacement: where a point of the limit surface moves to, a pure function of face,
 * (u,v), normal and tessellation level, so every representation sees the very same surface.
 * Most displacements move points along their normals. Maps are filtered to the spacing of
 * the level's vertices.
 *
 * Closed surfaces stay closed. Where the sides of a border read different values,
 * on a seam of an atlas or in maps of a face each, all of them take the mean. */

#include "surface/cage.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace cbvh {

/* Points of a face as Embree hands them to displacement functions. */
struct SurfacePoints
{
  unsigned face;     // of the cage
  int level;         // of the subdivision, 0 and more: spacing is 2^-level
  size_t n;
  const float* u;    // n
  const float* v;    // n
  const float* levels = nullptr; // of each, in place of level, where rates of edges differ: not whole numbers, 0 to finestLevel

  float levelAt(size_t i) const { return levels ? levels[i] : float(level); }
};

/* A level beyond all spacings of texels: heights as they are in the map. */
constexpr int finestLevel = 24;

class Displacement
{
public:
  virtual ~Displacement() = default;

  /* Whether points move along their normals: then offsets() says how far, else vectors()
   * where to. */
  virtual bool isAlongNormals() const { return true; }

  /* Offsets along the limit normal in world units.
   *
   * offsets: points.n floats, written.
   * Thread safety: callable from any number of threads. */
  virtual void offsets(const SurfacePoints& points, float* offsets) const = 0;

  /* The way that points move, in world units and the axes of the cage.
   *
   * normals: points.n of length 1. vectors: points.n, written.
   * Thread safety: callable from any number of threads. */
  virtual void vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* vectors) const;

  /* Texels of a map along an edge of a face, from that corner to the next; infinity where there is no map. */
  virtual float texelsAlong(unsigned face, unsigned edge) const;
};

/* scale * (height - neutral level) with the neutral level at 0.5. */
constexpr float neutralHeight = 0.5f;

/* What the values of a map are. */
enum class MapValues
{
  Heights,        // along the normal
  ObjectVectors,  // three channels: x, y and z of the cage
  TangentVectors, // three channels: along the texture's first axis, the normal, and its second axis
};

/* A map in a file, and how it is read. */
struct DisplacementMap
{
  std::string path;              // <UDIM> in it stands for a tile of texture coordinates, see udim_tiles.h
  float scale = 1.0f;            // world units that a difference of 1 moves by
  MapValues values = MapValues::Heights;
  std::optional<float> midLevel; // value that moves nothing; none: neutralHeight of heights, 0 of vectors
  std::string channel;           // the first that counts, by name or number from 0; empty for the first of the file
  Vec2f repeat{1, 1};            // copies of the map in a unit of texture coordinates, or on a face
};

/* The value of a map that moves nothing. */
float midLevelOf(const DisplacementMap& map);

/* Through the cage's own texture coordinates where it has some, else on its faces.
 *
 * By texture coordinates, as in OBJ: (0,0) is the lower left corner of the image, (1,1) the
 * upper right, repeated outside; interpolated bilinearly over a face (over the corner quads
 * of an n-gon), not subdivided: on an edge they depend on the edge alone. With <UDIM> in the
 * path a face reads the tile that its middle lies on, 1001 + column + 10 row, and is not
 * displaced where there is no such file.
 *
 * By faces, in (u,v) of each, row 0 of the image at v = 0. A file with one image: all of it
 * on every face and on every corner quad of an n-gon. A file of several, Ptex for one: an
 * image a quad and n an n-gon, in order.
 *
 * warnings: lines on what is likely not meant are added to it, each with its end.
 * Errors: throws Error for a file that cannot be read or has too few images or channels, and
 * for vectors in tangent space and <UDIM> without texture coordinates, and for texture
 * coordinates on some faces only; Cancelled. */
std::unique_ptr<Displacement> displaceByMap(const Cage& cage, const DisplacementMap& map, std::string& warnings);

} // namespace cbvh
