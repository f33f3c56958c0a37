// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from one side of a displaced sheet to the other: each must hit it. Sheets are random in shape, level, frame
 * level and edge rates; rays in slope and side.
 *
 * Complements leak_rays.h, whose rays start far inside, see convex walls and cross borders of few frames. */

#include "tracing/ray.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace programs {

struct SheetSettings {
  size_t rays = 1000000;
  size_t raysPerSheet = 20000;
  uint32_t seed = 1;
  std::string device = "cpu"; // see makeTracer
  bool packets = false;       // on the CPU
};

/* 4 x 4 flat faces over [-1,1]^2, displaced by waves of 3 to 7 quads at frequency 1. */
struct DisplacedSheet {
  int level = 5;
  int frameLevel = 0;
  float rate = 32;
  std::vector<float> rates; // per face index, replaces `rate` unless empty
  double amplitude = 1;     // along the normal, in quads
  double sideways = 0;      // in the plane, in quads
  double frequency = 1;     // relative, of the waves

  double quad() const { return 0.5 / double(1 << level); }

  std::string describe() const;
};

struct SheetCrossings {
  size_t sheets = 0, rays = 0;
  size_t closest = 0;    // closest-hit queries that miss but hit GRID's sheet
  size_t any = 0;        // any-hit queries that miss but hit GRID's sheet
  size_t gridMisses = 0; // rays of such queries that also miss GRID's sheet, not counted above
  static constexpr size_t maxExamples = 16;
  std::vector<std::string> examples;
};

/* The caller releases the scene. The sheet must outlive it. */
RTCScene commitSheet(RTCDevice device, const DisplacedSheet& sheet, RTCCompression compression);

/* Throws Canceled, and Error if a Vulkan device fails. */
SheetCrossings crossSheets(RTCDevice device, RTCCompression compression, const SheetSettings& settings,
                           unsigned threads);

} // namespace programs
