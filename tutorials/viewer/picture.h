// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A picture of one representation, or of two side by side. Tiles of pixels are tasks of TBB.
 *
 * Only shading uses several samples per pixel, because fine displacement looks like noise with one. Figures and other
 * modes use one hit, because errors, cells and normals have no meaningful mean. */

#include "building/built_scene.h"
#include "building/saved_scene.h"
#include "pictures/sampled_picture.h"

#include <optional>
#include <vector>

namespace programs {

enum class PictureMode {
  Shading, // two lights
  Normals, // geometric, in world space: x, y, z as red, green, blue
  Error,   // distance from GRID's hit in pixels, as in the paper's figure 10
  Cells,   // one color per quad, from (u,v)
  Blocks,  // one hue per frame level, one shade per block
};

constexpr PictureMode allPictureModes[] = {PictureMode::Shading, PictureMode::Normals, PictureMode::Error,
                                           PictureMode::Cells, PictureMode::Blocks};

/* Name on the command line. */
const char* pictureModeName(PictureMode mode);

/* A part of the picture. */
struct Pane {
  Pane() = default;
  explicit Pane(const BuiltScene* built, const BuiltScene* reference = nullptr)
    : scene(built),
      built(built),
      reference(reference) {}
  explicit Pane(const SavedScene* saved) : scene(saved), saved(saved) {}

  /* Errors need a reference; cells and blocks need a model. */
  bool canShow(PictureMode mode) const;

  const TracedScene* scene = nullptr;
  const BuiltScene* built = nullptr; // either built or saved is the scene
  const SavedScene* saved = nullptr;
  const BuiltScene* reference = nullptr; // GRID at the same level, for PictureMode::Error only
};

/* One ray per pixel. */
struct PaneReport {
  size_t rays = 0; // including misses
  size_t hits = 0;
  double seconds = 0;               // for all rays on all threads
  double median = 0, p99 = 0;       // errors in pixels, where both hit
  size_t falseHits = 0, misses = 0; // these four only in PictureMode::Error

  double mrays() const { return seconds > 0 ? double(rays) * 1e-6 / seconds : 0.0; }
  double mhits() const { return seconds > 0 ? double(hits) * 1e-6 / seconds : 0.0; }
};

struct PictureSettings {
  PictureMode mode = PictureMode::Shading;
  Vec3f up{0, 1, 0};
  float split = 0.5f; // where the right pane starts, as a fraction of the width
  unsigned threads = 1;
  int samples = 1; // per pixel in PictureMode::Shading
  float time = 0;  // 0 is the first time step, 1 the last
};

/* Where the right pane starts. */
int splitColumn(ImageSize size, float split);

/* Frame level of a patch of `resolution` quads per side, as documented for rtcSetGeometryCompression. cVERT's blocks
 * count as frames; 0 for NAIVE and GRID. */
int effectiveFrameLevel(const Representation& representation, unsigned resolution);

/* Rendered sample by sample. The first sample is through the centers of pixels, and all figures belong to it. */
class Picture {
public:
  /* One pane, or two with a white line between. Their scenes must outlive the last call of addSample. */
  Picture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings);

  void addSample();

  int samples() const { return count; }
  int wantedSamples() const { return settings.mode == PictureMode::Shading ? settings.samples : 1; }
  bool isComplete() const { return count >= wantedSamples(); }

  /* Requires a sample. */
  const Image& image() const { return shown; }

  /* One report per pane. */
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

/* Renders all samples. Throws Canceled. */
Image renderPicture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings);

} // namespace programs
