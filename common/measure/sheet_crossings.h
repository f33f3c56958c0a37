// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from one side of a displaced sheet to the other, each of which has to hit it: a
 * property of random sheets, with GRID as the judge. The sheets differ in amplitude,
 * sideways displacement, frequency, level, frame level and edge rates; rays in slope, from
 * flat to steep, and in side.
 *
 * They find what rays out of closed surfaces (leak_rays.h) do not: those start far inside,
 * see convex walls and few frames' borders. */

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
  size_t raysASheet = 20000;
  uint32_t seed = 1;
  std::string device = "cpu"; // that traces, see makeTracer
  bool packets = false;       // by coherent packets, on the processor
};

/* A sheet of 4 x 4 flat faces over [-1,1]^2, displaced by waves of about a tenth of a wave a
 * quad. */
struct DisplacedSheet
{
  int level = 5;
  int frameLevel = 0;
  float rate = 32;             // of edges
  std::vector<float> rates;    // of each edge of each face, over rate
  double amplitude = 1;        // along the normal, in quads
  double sideways = 0;         // in the plane, in quads
  double frequency = 1;        // of the waves, relative

  double quad() const { return 0.5 / double(1 << level); }

  std::string describe() const;
};

struct SheetCrossings
{
  size_t sheets = 0, rays = 0;
  size_t closest = 0;          // of rays that hit GRID's sheet: nothing hit
  size_t any = 0;              // nothing hit, any hit
  size_t ofGrid = 0;           // rays that GRID lets through
  std::vector<std::string> examples; // sheet and ray, at most 16
};

/* Commits a sheet on its own; the sheet outlives the scene, which the caller releases. */
RTCScene commitSheet(RTCDevice device, const DisplacedSheet& sheet, RTCCompression compression);

/* Throws Cancelled; Error of a Vulkan device. */
SheetCrossings crossSheets(RTCDevice device, RTCCompression compression, const SheetSettings& settings, unsigned threads);

} // namespace cbvh
