// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The representations that the programs compare, with their names on command lines, in tables and in file names. */

#include <embree3/rtcore_compression.h>

#include <string>
#include <vector>

namespace cbvh {

enum class RepresentationKind
{
  Naive, // two indexed triangles per quad in stock Embree's triangle BVH
  Grid,  // stock Embree's vertex grids
  /* The library's kinds. Their names and properties come from its table, kernels/cbvh/base/kinds.h. */
  CGrid = RTC_COMPRESSION_GRID,
  CVoxel = RTC_COMPRESSION_VOXEL,
  CLeaf = RTC_COMPRESSION_LEAF,
  CVert = RTC_COMPRESSION_VERT,
  /* cLEAF as in the paper: leaves for all faces, none stored exactly (cbvh_exact_faces=0). */
  CLeafOnly = 1000,
};

/* All representations, in the order of lists. */
const std::vector<RepresentationKind>& representationKinds();

/* Names in tables, "cLEAF", and on command lines, "cleaf". parseRepresentations accepts both and others. */
const std::string& labelOf(RepresentationKind kind);
const std::string& wordOf(RepresentationKind kind);

/* Returns all names for help texts and errors: "naive, grid, ...". `last` precedes the last one. */
std::string listOfRepresentations(const std::string& between, const std::string& last);
inline std::string listOfRepresentations(const std::string& between) { return listOfRepresentations(between, between); }

/* Returns the comma-separated list that programs compare by default: all but cLEAF-only, which is close to cLEAF. */
std::string defaultRepresentations();

constexpr int autoFrameLevel = -1;
extern const int maxLevel; // of tessellation and of frames, the library's limit

/* Returns the range of levels for help texts, "0 to 8". */
std::string levelRange();

struct Representation
{
  RepresentationKind kind = RepresentationKind::Grid;
  int frameLevel = autoFrameLevel; // or 0 to maxLevel; ignored if hasFrames() is false

  bool isCompressed() const { return compression() != RTC_COMPRESSION_NONE; }

  /* True if blocks have frames, so that frameLevel applies. */
  bool hasFrames() const;

  /* True if faces that leaves approximate badly are stored exactly, as cVERT. */
  bool hasExactFaces() const { return kind == RepresentationKind::CLeaf; }

  /* For example "cLEAF", or with a frame level "cLEAF^2" as in the paper, "cLEAF-only^2". */
  std::string label() const;

  /* For file names: "cleaf", "cleaf2", "cleaf-only2". */
  std::string fileStem() const;

  /* RTC_COMPRESSION_NONE for NAIVE and GRID. */
  RTCCompression compression() const;

  /* Returns the configuration string of an Embree device that selects the representation. */
  std::string deviceConfig() const;
};

/* Parses a comma-separated list such as "grid,cvoxel^3,cleaf:2,cgrid". Names are case-insensitive; a frame level may
 * follow after ^ or :, otherwise the default applies. The library's kinds may also be spelled as in device strings,
 * with or without the prefix: cvert, cbvh.vert, vert. "grid" alone is Embree's own. Each representation may occur once.
 * Throws Error with the invalid word. */
std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel);

/* Parses "auto" or 0 to maxLevel. Throws Error. */
int parseFrameLevel(const std::string& text);

} // namespace cbvh
