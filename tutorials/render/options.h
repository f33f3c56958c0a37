// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

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

namespace programs {

struct Options {
  SceneSettings scene;
  std::vector<Representation> representations;
  BuildSettings build;
  std::string view = "full"; // full, close, or ex,ey,ez,lx,ly,lz,fov
  ImageSize size;
  bool hasSize = false; // it was given
  Crop crop;
  std::string output = "cbvh_render_output";
  HitColors colors = HitColors::Neutral;
  int samples = 16;               // per pixel of shaded pictures
  Shutter shutter;                // for models that move
  bool exr = false;               // also write linear colors and hits
  bool details = false;           // all rows of the table
  std::string json;               // empty for none
  std::string savePath, loadPath; // to save the compressed scene, or to open instead of a scene
  std::vector<std::string> join;  // instead of rendering: a picture, and its parts
  std::string exportPath;         // OBJ of the surface as cVERT stores it
  size_t rays = 500000;           // per set, at most, for speed
  int repeat = 5;
  bool speed = false;
  bool autoLevel = false;   // rates by the view instead of build.level
  float quadSize = 1;       // of rates by the view, in pixels
  float maxPixelError = 0;  // largest lattice spacing of cVERT, in pixels of the view, 0 for no bound
  float rayOffset = 1e-4f;  // of bounced rays, in diagonals of the bounding box
  unsigned ambientRays = 0; // per pixel; 0 for none
  size_t trueHits = 0;      // at most, to compare with the true surface

  /* The picture is then rendered from the file. */
  bool savesCopyByCopy() const { return !savePath.empty() && scene.scene == "herd"; }

  bool compares() const { return representations.size() > 1; }
};

/* Returns nothing after printing help. Throws Error, one line. */
std::optional<Options> parseOptions(int argc, char** argv);

} // namespace programs
