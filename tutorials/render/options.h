// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_render. */

#include "built_scene.h"
#include "camera.h"
#include "representation.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct Options
{
  std::string scene;             // generated: cube, trex; empty: a cage
  std::string cagePath;          // OBJ
  std::string heightPath;        // height map of the cage, empty: not displaced
  std::optional<float> amplitude; // fraction of the cage's bounding-box diagonal
  bool rough = false;            // trex: five times the amplitude
  std::vector<Representation> representations;
  BuildSettings build;
  std::string view = "full";     // full, close, or ex,ey,ez,lx,ly,lz,fov
  ImageSize size;
  std::string output = "cbvh_render_output";
  std::string json;              // also write the numbers there
  size_t rays = 500000;          // at most, a set, for speed
  int repeat = 5;
  bool speed = true;
  float rayOffset = 1e-4f;       // of bounced rays, in bounding-box diagonals
};

/* Reads a command line. Returns nothing when it asked for help, which is printed.
 * Throws Error, one line, for anything wrong. */
std::optional<Options> parseOptions(int argc, char** argv);

/* Parses "ex,ey,ez,lx,ly,lz,fov". Throws Error. */
Camera parseView(const std::string& text, Vec3f up, ImageSize size);

} // namespace cbvh
