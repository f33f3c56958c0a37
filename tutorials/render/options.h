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
  Crop crop; // part of the picture to render
  std::string output = "cbvh_render_output";
  HitColors colors = HitColors::Neutral;
  int samples = 16;              // per pixel of shaded pictures
  Shutter shutter;               // for models that move
  bool exr = false;              // also write linear colors and hits
  bool details = false;          // all rows of the table
  std::string json;              // file for the numbers; empty for none
  std::string savePath, loadPath; // file to save the compressed scene to, or to open instead of a scene
  std::string exportPath;        // OBJ for the surface as cVERT stores it
  size_t rays = 500000;          // largest number per set, for speed
  int repeat = 5;
  bool speed = false;
  bool autoLevel = false;        // use rates by the view instead of build.level
  float quadSize = 1;            // of rates by the view, in pixels
  float maxPixelError = 0;       // largest spacing of cVERT, in pixels of the view, 0 for no bound
  float rayOffset = 1e-4f;       // of bounced rays, in diagonals of the bounding box
  unsigned ambientRays = 0;      // per pixel, for pictures of ambient occlusion; 0 for none
  size_t trueHits = 0;           // largest number of hits that are compared with the true surface

  /* True if the scene is saved copy by copy and its picture is rendered from the file. */
  bool savesCopyByCopy() const { return !savePath.empty() && scene.scene == "herd"; }

  /* True if there are several representations to compare. */
  bool compares() const { return representations.size() > 1; }
};

/* Parses a command line. Returns nothing after printing help. Throws Error, one line, for anything invalid. */
std::optional<Options> parseOptions(int argc, char** argv);

} // namespace cbvh
