// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* One picture of one representation, or of two side by side, the same in the window
 * and without one. Tiles of pixels are the tasks of TBB.
 *
 * Shading has several samples a pixel, as fine displacement is salt and pepper with one. All
 * else is of one hit, which has no mean: errors, places and normals, and all figures. */

#include "building/built_scene.h"
#include "building/saved_scene.h"
#include "pictures/sampled_picture.h"

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
  Pane() = default;
  explicit Pane(const BuiltScene* built, const BuiltScene* reference = nullptr) : scene(built), built(built), reference(reference) {}
  explicit Pane(const SavedScene* saved) : scene(saved), saved(saved) {}

  /* Whether it has what a mode shows: errors need a reference, places a model. */
  bool canShow(PictureMode mode) const;

  const TracedScene* scene = nullptr;
  const BuiltScene* built = nullptr;     // the same, one of these two
  const SavedScene* saved = nullptr;
  const BuiltScene* reference = nullptr; // GRID at the same level, for PictureMode::Error only
};

/* Of one ray a pixel. */
struct PaneReport
{
  size_t rays = 0;                  // whether they hit or not
  size_t hits = 0;
  double seconds = 0;               // for tracing all of them on all threads
  double median = 0, p99 = 0;       // errors in pixels, over rays where both hit
  size_t falseHits = 0, misses = 0; // these four in PictureMode::Error only

  double mrays() const { return seconds > 0 ? double(rays) * 1e-6 / seconds : 0.0; }
  double mhits() const { return seconds > 0 ? double(hits) * 1e-6 / seconds : 0.0; }
};

struct PictureSettings
{
  PictureMode mode = PictureMode::Shading;
  Vec3f up{0, 1, 0};
  float split = 0.5f; // where the right pane starts, of the width
  unsigned threads = 1;
  int samples = 1; // a pixel, in PictureMode::Shading
  float time = 0;  // of a model that moves, from its first step at 0 to its last at 1
};

/* The column of a picture where its right pane starts, of two. */
int splitColumn(ImageSize size, float split);

/* Frame level that a patch of `resolution` quads a side has in a representation, as
 * the manual of rtcSetGeometryCompression says; 0 for NAIVE and GRID. */
int effectiveFrameLevel(const Representation& representation, unsigned resolution);

/* A picture that comes sample by sample: the first, through the centres of pixels, is one to show
 * and the one that the figures are of; the others make it smooth. */
class Picture
{
public:
  /* panes: 1, or 2 for left and right, a white line between. Their scenes outlive the picture, or
   * its last sample. */
  Picture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings);

  /* One sample more of each pixel. */
  void addSample();

  int samples() const { return count; }
  int wantedSamples() const { return settings.mode == PictureMode::Shading ? settings.samples : 1; }
  bool isComplete() const { return count >= wantedSamples(); }

  /* Of all samples so far, at least one. */
  const Image& image() const { return shown; }

  /* One a pane. */
  const std::vector<PaneReport>& reports() const { return paneReports; }

private:
  const Camera camera;
  const std::vector<Pane> panes;
  const PictureSettings settings;
  std::optional<SampledPicture> shading; // in PictureMode::Shading
  Image shown;
  std::vector<PaneReport> paneReports;
  int count = 0;
};

/* With all its samples. Throws Cancelled. */
Image renderPicture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings);

} // namespace cbvh
