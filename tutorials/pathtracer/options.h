// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_pathtracer. */

#include "building/built_scene.h"
#include "building/representation.h"
#include "scenes/catalogue.h"
#include "tracing/image_size.h"
#include "tracing/shutter.h"

#include <optional>
#include <string>

namespace cbvh {

struct PathTracerOptions
{
  SceneSettings scene;
  Representation representation;
  BuildSettings build;
  bool autoLevel = false;     // rates by the view, in place of build.level
  float quadSize = 1;         // in pixels, then
  float maxPixelError = 0;    // bound on the spacing of cVERT, in pixels of the view, 0 for none
  std::string view = "full";  // full, close, or ex,ey,ez,lx,ly,lz,fov
  ImageSize size;
  unsigned samples = 64;      // a pixel
  unsigned bounces = 3;       // hits of a path behind its first
  Shutter shutter;            // of models that move
  std::string device;         // "cpu", or as rtcNewVulkanDevice takes it
  bool byRayQuery = false;    // of the device's driver, and not the library's own tree
  bool window = false;
  std::string output;         // empty: none

  bool onCpu() const { return device == "cpu"; }
};

/* Reads a command line. Returns nothing when it asked for help, which is printed.
 * Throws Error, one line, for anything wrong. */
std::optional<PathTracerOptions> parsePathTracerOptions(int argc, char** argv);

} // namespace cbvh
