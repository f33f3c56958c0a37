// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Command line of cbvh_render. */

#include "building/built_scene.h"
#include "building/representation.h"
#include "pictures/shading.h"
#include "scenes/catalogue.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/shutter.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct Options
{
  SceneSettings scene;
  std::vector<Representation> representations;
  BuildSettings build;
  std::string view = "full";     // full, close, or ex,ey,ez,lx,ly,lz,fov
  ImageSize size;
  Crop crop;                     // the part of the picture that is rendered
  std::string output = "cbvh_render_output";
  HitColors colors = HitColors::Neutral;
  int samples = 16;              // a pixel, of shaded pictures
  Shutter shutter;               // of models that move
  bool exr = false;              // write linear colours and hits, too
  bool details = false;          // all rows of the table
  std::string json;              // also write the numbers there
  std::string savePath, loadPath; // file that the compressed scene goes to, or, in place of a scene, comes from
  std::string exportPath;        // where the surface goes as cVERT stores it, OBJ
  size_t rays = 500000;          // at most, a set, for speed
  int repeat = 5;
  bool speed = false;
  bool autoLevel = false;        // rates by the view, in place of build.level
  float quadSize = 1;            // in pixels, then
  float maxPixelError = 0;       // bound on the spacing of cVERT, in pixels of the view, 0 for none
  float rayOffset = 1e-4f;       // of bounced rays, in bounding-box diagonals
  unsigned ambientRays = 0;      // a pixel, for pictures of ambient occlusion; 0: none
  size_t trueHits = 0;           // at most, that are compared with the true surface

  /* Whether the scene goes into its file copy by copy, and its picture comes from there. */
  bool savesCopyByCopy() const { return !savePath.empty() && scene.scene == "herd"; }

  /* Whether there is something to compare, and not only a picture to make. */
  bool compares() const { return representations.size() > 1; }
};

/* Reads a command line. Returns nothing when it asked for help, which is printed.
 * Throws Error, one line, for anything wrong. */
std::optional<Options> parseOptions(int argc, char** argv);

} // namespace cbvh
