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
  Naive, // two indexed triangles a quad in stock Embree's triangle BVH
  Grid,  // stock Embree's vertex grids
  /* the library's kinds: names and properties are those of its table, kernels/cbvh/base/kinds.h */
  CGrid = RTC_COMPRESSION_GRID,
  CVoxel = RTC_COMPRESSION_VOXEL,
  CLeaf = RTC_COMPRESSION_LEAF,
  CVert = RTC_COMPRESSION_VERT,
  /* cLEAF as in the paper, with leaves for all faces, and none stored exactly: the library's cbvh_exact_faces=0 */
  CLeafOnly = 1000,
};

/* All of them, as lists have them. */
const std::vector<RepresentationKind>& representationKinds();

/* In tables: "cLEAF". On command lines: "cleaf", which is one of the names that parseRepresentations takes. */
const std::string& labelOf(RepresentationKind kind);
const std::string& wordOf(RepresentationKind kind);

/* The words of all, for help texts and errors: "naive, grid, ...". last: in front of the last one. */
std::string listOfRepresentations(const std::string& between, const std::string& last);
inline std::string listOfRepresentations(const std::string& between) { return listOfRepresentations(between, between); }

/* A comma list of what is compared where nobody says what: all but cLEAF-only, beside which cLEAF would stand twice. */
std::string defaultRepresentations();

constexpr int autoFrameLevel = -1;
extern const int maxLevel; // of tessellation and of frames: the library's

/* For help texts: "0 to 8". */
std::string levelRange();

struct Representation
{
  RepresentationKind kind = RepresentationKind::Grid;
  int frameLevel = autoFrameLevel; // or 0 to maxLevel; ignored where there are no frames

  bool isCompressed() const { return compression() != RTC_COMPRESSION_NONE; }

  /* Whether blocks have frames, and so a level at which these start. */
  bool hasFrames() const;

  /* Whether faces that the form holds badly are stored exactly, as cVERT: of cLEAF. */
  bool hasExactFaces() const { return kind == RepresentationKind::CLeaf; }

  /* "cLEAF", and with a frame level as in the paper "cLEAF^2", "cLEAF-only^2". */
  std::string label() const;

  /* For file names: "cleaf", "cleaf2", "cleaf-only2". */
  std::string fileStem() const;

  /* RTC_COMPRESSION_NONE of NAIVE and GRID. */
  RTCCompression compression() const;

  /* What selects it in an Embree device's configuration string. */
  std::string deviceConfig() const;
};

/* Reads a comma list such as "grid,cvoxel^3,cleaf:2,cgrid": names in any case, a
 * frame level of their own after ^ or :, else the default one. The library's kinds have the
 * names of device strings as well, whole and without their beginning: cvert, cbvh.vert, vert;
 * grid alone is Embree's own. Throws Error with the offending word; each representation may
 * occur once. */
std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel);

/* Reads "auto" or 0 to maxLevel. Throws Error. */
int parseFrameLevel(const std::string& text);

} // namespace cbvh
