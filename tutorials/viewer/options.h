// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_viewer. */

#include "picture.h"
#include "scenes/catalogue.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct ViewerOptions
{
  SceneSettings scene;                         // if it names nothing, the window starts empty
  std::vector<Representation> representations; // one, or two for a split screen
  BuildSettings build;
  bool autoLevel = false;                   // use rates by the initial view instead of build.level
  float quadSize = 1;                       // of rates by the view, in pixels
  float maxPixelError = 0;                  // largest spacing of cVERT with rates by the view, in pixels; 0: no bound
  PictureMode mode = PictureMode::Shading;
  std::string view = "full";
  int samples = 16;                         // per pixel in PictureMode::Shading
  float time = 0;                           // initial time of a model that moves, 0 to 1
  ImageSize size{1024, 768};
  std::string screenshot;                   // file of a picture; empty: open a window
  std::string picture = "cbvh_viewer.png";  // file for pictures that the window saves
};

/* Parses a command line. Returns nothing after printing help. Throws Error, one line, for anything invalid. */
std::optional<ViewerOptions> parseViewerOptions(int argc, char** argv);

} // namespace cbvh
