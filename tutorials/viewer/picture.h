// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* One picture of one representation, or of two side by side, the same in the window
 * and without one. Tiles of pixels are the tasks of TBB. */

#include "building/built_scene.h"
#include "pictures/image.h"
#include "tracing/camera.h"

#include <optional>
#include <vector>

namespace cbvh {

enum class PictureMode
{
  Shading, // two lights
  Normals, // geometric, of the world: x, y, z in red, green, blue
  Error,   // distance to GRID's hit in pixels, figure 10 of the paper
  Cells,   // a colour for each quad, from (u,v)
  Blocks,  // a hue for each frame level, a shade for each block
};

constexpr PictureMode allPictureModes[] = {PictureMode::Shading, PictureMode::Normals, PictureMode::Error,
                                           PictureMode::Cells, PictureMode::Blocks};

/* As on the command line. */
const char* pictureModeName(PictureMode mode);

/* What a part of the picture shows. */
struct Pane
{
  const BuiltScene* scene = nullptr;
  const BuiltScene* reference = nullptr; // GRID at the same level, for PictureMode::Error only
};

struct PaneReport
{
  size_t rays = 0;
  double seconds = 0;             // for tracing them on all threads
  double median = 0, p99 = 0;       // errors in pixels, over rays where both hit
  size_t falseHits = 0, misses = 0; // these four in PictureMode::Error only

  double mrays() const { return seconds > 0 ? double(rays) * 1e-6 / seconds : 0.0; }
};

struct PictureSettings
{
  PictureMode mode = PictureMode::Shading;
  Vec3f up{0, 1, 0};
  float split = 0.5f; // where the right pane starts, of the width
  unsigned threads = 1;
};

/* The column of a picture where its right pane starts, of two. */
int splitColumn(ImageSize size, float split);

/* Frame level that a patch of `resolution` quads a side has in a representation, as
 * the manual of rtcSetGeometryCompression says; 0 for NAIVE and GRID. */
int effectiveFrameLevel(const Representation& representation, unsigned resolution);

/* Renders. panes: 1, or 2 for left and right, a white line between.
 * reports: one a pane, written. */
Image renderPicture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings,
                    std::vector<PaneReport>& reports);

} // namespace cbvh
