// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from one side of a displaced sheet to the other, each of which must hit it: a property of random sheets, with
 * GRID as the reference. Sheets differ in amplitude, sideways displacement, frequency, level, frame level and edge
 * rates; rays differ in slope, from flat to steep, and in side.
 *
 * They find errors that rays out of closed surfaces (leak_rays.h) miss: those rays start far inside, see convex walls
 * and cross borders of few frames. */

#include "tracing/ray.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cbvh {

struct SheetSettings
{
  size_t rays = 1000000;
  size_t raysPerSheet = 20000;
  uint32_t seed = 1;
  std::string device = "cpu"; // see makeTracer
  bool packets = false;       // trace coherent packets on the CPU
};

/* A sheet of 4 x 4 flat faces over [-1,1]^2, displaced by waves. A quad is about a tenth of a wave. */
struct DisplacedSheet
{
  int level = 5;
  int frameLevel = 0;
  float rate = 32;          // of all edges
  std::vector<float> rates; // of each edge of each face, instead of `rate` if not empty
  double amplitude = 1;     // along the normal, in quads
  double sideways = 0;      // in the plane, in quads
  double frequency = 1;     // of the waves, relative

  double quad() const { return 0.5 / double(1 << level); }

  std::string describe() const;
};

struct SheetCrossings
{
  size_t sheets = 0, rays = 0;
  size_t closest = 0;    // closest-hit queries without a hit, for rays that hit GRID's sheet
  size_t any = 0;        // any-hit queries without a hit, for rays that hit GRID's sheet
  size_t gridMisses = 0; // rays that miss GRID's sheet
  std::vector<std::string> examples; // sheet and ray, at most 16
};

/* Commits a sheet as a scene, which the caller must release. The sheet must outlive the scene. */
RTCScene commitSheet(RTCDevice device, const DisplacedSheet& sheet, RTCCompression compression);

/* Traces random rays through random sheets. Throws Cancelled, and Error if a Vulkan device fails. */
SheetCrossings crossSheets(RTCDevice device, RTCCompression compression, const SheetSettings& settings,
                           unsigned threads);

} // namespace cbvh
