// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/built_scene.h"
#include "building/representation.h"
#include "scenes/catalogue.h"
#include "tracing/image_size.h"
#include "tracing/shutter.h"

#include <optional>
#include <string>

namespace programs {

struct PathTracerOptions {
  SceneSettings scene;
  Representation representation;
  BuildSettings build;
  bool autoLevel = false;    // rates by the view instead of build.level
  float quadSize = 1;        // of rates by the view, in pixels
  float maxPixelError = 0;   // largest lattice spacing of cVERT, in pixels of the view, 0 for no bound
  std::string view = "full"; // full, close, or ex,ey,ez,lx,ly,lz,fov
  ImageSize size;
  unsigned samples = 64; // per pixel
  unsigned bounces = 3;  // hits of a path after the first
  Shutter shutter;       // for models that move
  std::string device;    // "cpu", or a name as in VulkanTracer::create
  bool window = false;
  std::string output; // empty for none

  bool onCpu() const { return device == "cpu"; }
};

/* Returns nothing after printing help. Throws Error, one line. */
std::optional<PathTracerOptions> parsePathTracerOptions(int argc, char** argv);

} // namespace programs
