// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Representations that the programs compare, and their names. */

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <string>
#include <vector>

namespace programs {

enum class RepresentationKind {
  Naive, // two triangles per quad in Embree's triangle BVH
  Grid,  // Embree's vertex grids
  /* The library's kinds, described in kernels/cbvh/base/kinds.h. */
  CGrid = RTC_COMPRESSION_CGRID,
  CVoxel = RTC_COMPRESSION_CVOXEL,
  CLeaf = RTC_COMPRESSION_CLEAF,
  CVert = RTC_COMPRESSION_CVERT,
  CTile = RTC_COMPRESSION_CTILE,
  /* cLEAF as in the paper: no faces stored as cVERT (cbvh_fallback_faces=0). */
  CLeafOnly = 1000,
  NaiveCompact, // NAIVE's triangles with RTC_SCENE_FLAG_COMPACT
};

/* What programs build unless told otherwise: the library's default. */
constexpr RepresentationKind preferredKind = RepresentationKind::CTile;

const std::vector<RepresentationKind>& representationKinds();

/* Names in tables, "cLEAF", and on command lines, "cleaf". */
const std::string& labelOf(RepresentationKind kind);
const std::string& optionNameOf(RepresentationKind kind);

/* Lists all names: "naive, naive-compact, ...". `last` precedes the last one. */
std::string listOfRepresentations(const std::string& separator, const std::string& last);
inline std::string listOfRepresentations(const std::string& separator) {
  return listOfRepresentations(separator, separator);
}

/* The programs' default list: all but cLEAF-only, which is close to cLEAF. */
std::string defaultRepresentations();

/* The representations that meshes support: Embree's own kernel, the same in its compact mode, cVERT and cTILE. */
std::string meshRepresentations();

constexpr int autoFrameLevel = -1;
extern const int maxLevel; // the library's limit for tessellation and frames

/* "0 to 8" */
std::string levelRange();

struct Representation {
  RepresentationKind kind = RepresentationKind::Grid;
  int frameLevel = autoFrameLevel; // or 0 to maxLevel; ignored if hasFrames() is false

  bool isCompressed() const { return compression() != RTC_COMPRESSION_NONE; }

  bool isTriangulated() const;

  bool hasFrames() const;

  /* cVERT or cTILE, whose vertices and hits are equal. */
  bool isExact() const { return kind == RepresentationKind::CVert || kind == RepresentationKind::CTile; }

  /* Names what the library builds instead if the surface moves: "stored as cVERT" or "GRID". Empty if this
   * representation supports motion, or is triangulated. */
  std::string replacementInMotion() const;

  /* Faces that leaves approximate badly are stored as cVERT. */
  bool hasFallbackFaces() const { return kind == RepresentationKind::CLeaf; }

  /* "cLEAF", "cLEAF^2" with a frame level, "cLEAF-only^2" */
  std::string label() const;

  /* "cleaf", "cleaf2", "cleaf-only2" */
  std::string fileStem() const;

  RTCCompression compression() const;

  std::string deviceConfig() const;

  RTCSceneFlags sceneFlags() const;
};

/* Parses a comma-separated list such as "grid,cvoxel^3,cleaf:2,cgrid". Names are case-insensitive; a frame level may
 * follow after ^ or :. The library's kinds may be spelled as in device strings: cvert, cbvh.vert, vert; but "grid"
 * is Embree's. Throws Error with the word if it is invalid or repeated. */
std::vector<Representation> parseRepresentations(const std::string& list, int defaultFrameLevel);

/* Accepts "auto" or 0 to maxLevel. Throws Error. */
int parseFrameLevel(const std::string& text);

} // namespace programs
