// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "picture.h"
#include "scenes/catalogue.h"

#include <optional>
#include <string>
#include <vector>

namespace programs {

struct ViewerOptions {
  SceneSettings scene;                         // the window starts empty without a name
  std::vector<Representation> representations; // one, or two for a split screen
  BuildSettings build;
  bool autoLevel = false;  // rates by the view instead of build.level
  float quadSize = 1;      // of rates by the view, in pixels
  float maxPixelError = 0; // largest lattice spacing of cVERT with rates by the view, pixels; 0: none
  PictureMode mode = PictureMode::Shading;
  std::string view = "full";
  int samples = 16; // per pixel in PictureMode::Shading
  float time = 0;   // initial, 0 to 1
  ImageSize size{1024, 768};
  bool noWindow = false;                  // write the picture and exit
  std::string output = "cbvh_viewer.png"; // file for the picture
};

/* Returns nothing after printing help. Throws Error, one line. */
std::optional<ViewerOptions> parseViewerOptions(int argc, char** argv);

} // namespace programs
