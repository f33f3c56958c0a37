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
  SceneSettings scene;                         // none named: the window starts empty
  std::vector<Representation> representations; // one, or two for a split screen
  BuildSettings build;
  bool autoLevel = false;                   // rates by the view where the window starts, in place of build.level
  float quadSize = 1;                       // in pixels, then
  float maxPixelError = 0;                  // bound on the spacing of cVERT in pixels, then; 0 for none
  PictureMode mode = PictureMode::Shading;
  std::string view = "full";
  int samples = 16;                         // a pixel, in PictureMode::Shading; a window gathers them while nothing moves
  float time = 0;                           // of a model that moves, 0 to 1; where the window starts
  ImageSize size{1024, 768};
  std::string screenshot;                   // render there and end; empty: open a window
  std::string picture = "cbvh_viewer.png";  // where the window's key saves
};

/* Reads a command line. Returns nothing when it asked for help, which is printed.
 * Throws Error, one line, for anything wrong. */
std::optional<ViewerOptions> parseViewerOptions(int argc, char** argv);

} // namespace cbvh
