// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The representations that the programs compare, and their names on command lines,
 * in tables and in file names. */

#include <embree3/rtcore_compression.h>

#include <string>
#include <vector>

namespace cbvh {

enum class RepresentationKind
{
  Naive,  // two indexed triangles a quad in stock Embree's triangle BVH
  Grid,   // stock Embree's vertex grids
  CGrid,  // compressed nodes, full-precision vertices
  CVoxel, // compressed nodes, the leaf box is the surface
  CLeaf,  // compressed nodes, shared heights
  CVert,  // GRID's own triangles over vertices on a lattice
};

constexpr int autoFrameLevel = -1;
constexpr int maxLevel = 8;

struct Representation
{
  RepresentationKind kind = RepresentationKind::Grid;
  int frameLevel = 2; // 0..8 or autoFrameLevel; NAIVE, GRID and cVERT ignore it

  bool isCompressed() const { return kind != RepresentationKind::Naive && kind != RepresentationKind::Grid; }

  /* Whether blocks have frames, and so a level at which these start. */
  bool hasFrames() const { return isCompressed() && kind != RepresentationKind::CVert; }

  /* As in the paper: "cLEAF^2". */
  std::string label() const;

  /* For file names: "cleaf2". */
  std::string fileStem() const;

  /* RTC_COMPRESSION_NONE of NAIVE and GRID. */
  RTCCompression compression() const;

  /* What selects it in an Embree device's configuration string. */
  std::string deviceConfig() const;
};

/* Reads a comma list such as "grid,cvoxel^3,cleaf:2,cgrid": names in any case, a
 * frame level of their own after ^ or :, else the default one. Throws Error with
 * the offending word; each may occur once. */
std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel);

/* Reads "auto" or 0..8. Throws Error. */
int parseFrameLevel(const std::string& text);

} // namespace cbvh
