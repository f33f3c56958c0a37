// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "picture.h"
#include "basics/progress.h"
#include "measure/hit_metrics.h"
#include "measure/quantiles.h"
#include "pictures/shading.h"
#include "tracing/trace_hits.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace programs {
namespace {

/* Side of a tile in pixels. A tile is a task: large enough to outweigh its overhead, and small enough that the last
 * ones do not delay the frame. */
constexpr int tileSize = 16;

/* Columns of a pane. Hits are stored in rows of the region. */
struct Region {
  int begin, end, height;
  int width() const { return end - begin; }
  size_t index(int x, int y) const { return size_t(y) * size_t(width()) + size_t(x - begin); }
  size_t pixels() const { return size_t(width()) * size_t(height); }
};

template<typename Body>
void forTiles(const Region& region, const Body& body) {
  const tbb::blocked_range2d<int> tiles(0, region.height, tileSize, region.begin, region.end, tileSize);
  tbb::parallel_for(
      tiles,
      [&](const tbb::blocked_range2d<int>& tile) {
        body(tile.cols().begin(), tile.cols().end(), tile.rows().begin(), tile.rows().end());
      },
      tbb::simple_partitioner());
}

/* Writes one hit per pixel. */
void traceRegion(const Camera& camera, const Region& region, const TracedScene& scene, Vec2f offset, float time,
                 std::vector<SurfaceHit>& hits) {
  forTiles(region, [&](int x0, int x1, int y0, int y1) {
    Ray rays[tileSize * tileSize];
    SurfaceHit found[tileSize * tileSize];
    size_t n = 0;
    for (int y = y0; y < y1; y++)
      for (int x = x0; x < x1; x++) {
        rays[n] = primaryRay(camera, x, y, offset);
        rays[n++].time = time;
      }
    traceClosest(scene, n, rays, found);
    n = 0;
    for (int y = y0; y < y1; y++)
      for (int x = x0; x < x1; x++) hits[region.index(x, y)] = found[n++];
  });
}

/* Finalizer of MurmurHash3. */
uint32_t mix(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x85ebca6bu;
  x = (x ^ (x >> 13)) * 0xc2b2ae35u;
  return x ^ (x >> 16);
}

float unit(uint32_t bits) { return float(bits & 0xffff) * (1.0f / 65535.0f); }

/* Linear and not too dark; `hue` is in turns. */
Vec3f fromHue(float hue, float saturation, float value) {
  const auto channel = [&](float shift) {
    const float x = std::abs(6.0f * (hue + shift - std::floor(hue + shift)) - 3.0f) - 1.0f;
    return value * (1.0f - saturation + saturation * std::min(std::max(x, 0.0f), 1.0f));
  };
  return {channel(0.0f), channel(2.0f / 3.0f), channel(1.0f / 3.0f)};
}

/* The quad of a hit. */
struct Cell {
  uint32_t patch;
  unsigned x, y, resolution;
};

Cell findCell(const PatchLayout& layout, const SurfaceHit& hit) {
  const Patch& patch = layout.find(hit.face, hit.u, hit.v);
  float u = hit.u, v = hit.v;
  if (!layout.isQuadFace(hit.face)) decodeSubPatch(u, v);
  const auto index = [&](float t) {
    return unsigned(std::min(std::max(t, 0.0f) * float(patch.resolution), float(patch.resolution - 1)));
  };
  return {mix(patch.face * 16 + patch.subPatch), index(u), index(v), patch.resolution};
}

Vec3f cellColor(const Cell& cell) {
  const uint32_t bits = mix(cell.patch ^ (cell.y << 16 | cell.x));
  return fromHue(unit(bits), 0.8f, 0.2f + 0.7f * unit(bits >> 16));
}

Vec3f blockColor(const Cell& cell, int frameLevel, bool compressed) {
  const unsigned size = std::max(1u, cell.resolution >> frameLevel); // quads per side of a block
  const uint32_t bits = mix(cell.patch ^ ((cell.y / size) << 16 | (cell.x / size)));
  if (!compressed) return Vec3f{1, 1, 1} * (0.15f + 0.65f * unit(bits >> 16)); // no blocks: patches in gray
  /* Hues of consecutive levels differ by the golden ratio. */
  const float hue = 0.6f + 0.618034f * float(frameLevel) + 0.05f * (unit(bits) - 0.5f);
  return fromHue(hue, 0.8f, 0.15f + 0.8f * unit(bits >> 16));
}

/* Runs on the threads of the caller's arena. */
class PaneRender {
public:
  PaneRender(const Camera& camera, const Pane& pane, const PictureSettings& settings, const Region& region)
    : camera(camera),
      pane(pane),
      settings(settings),
      region(region),
      hits(region.pixels()) {}

  /* Traces sample i of each pixel. */
  PaneReport trace(int i) {
    PaneReport report;
    report.rays = region.pixels();
    offset = sampleOffset(i);
    const auto start = std::chrono::steady_clock::now();
    traceRegion(camera, region, *pane.scene, offset, settings.time, hits);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.hits = size_t(std::count_if(hits.begin(), hits.end(), [](const SurfaceHit& hit) { return hit.hit(); }));
    return report;
  }

  void compare(PaneReport& report) {
    std::vector<SurfaceHit> reference(region.pixels());
    traceRegion(camera, region, *pane.reference, offset, settings.time, reference);
    errors = pixelErrors(reference, hits, camera.footprint());
    summarize(report);
  }

  void addTo(SampledPicture& picture) const {
    forPixels([&](int x, int y, size_t pixel) {
      picture.addTo(pixel, primaryRay(camera, x, y, offset), hits[region.index(x, y)]);
    });
  }

  /* Colors the pane in all modes but shading. */
  void paint(Image& image) const {
    forPixels([&](int x, int y, size_t pixel) { image.set(pixel, color(x, y)); });
  }

private:
  /* body(x, y, index of the pixel in the picture) */
  template<typename Body>
  void forPixels(const Body& body) const {
    const size_t width = size_t(camera.size().width);
    forTiles(region, [&](int x0, int x1, int y0, int y1) {
      for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) body(x, y, size_t(y) * width + size_t(x));
    });
  }

  /* Computes statistics as in HitErrors. */
  void summarize(PaneReport& report) const {
    std::vector<float> both;
    for (float e : errors) {
      report.falseHits += e == falseHitError;
      report.misses += e == missError;
      if (e >= 0.0f) both.push_back(e);
    }
    report.median = quantile(both, 0.5);
    report.p99 = quantile(both, 0.99);
  }

  Vec3f color(int x, int y) const {
    const size_t index = region.index(x, y);
    if (settings.mode == PictureMode::Error) return errorColor(errors[index]);
    if (!hits[index].hit()) return backgroundColor(float(y) / float(region.height));
    return surfaceColor(primaryRay(camera, x, y), hits[index]);
  }

  Vec3f surfaceColor(const Ray& ray, const SurfaceHit& hit) const {
    const Vec3f n = normalize(hit.normal);
    if (settings.mode == PictureMode::Normals) return 0.5f * (n + Vec3f{1, 1, 1});
    /* Darker at grazing angles, so that the shape stays visible. */
    const float facing = 0.4f + 0.6f * std::abs(dot(n, ray.direction));
    const Cell cell = findCell(pane.built->layout(), hit);
    if (settings.mode == PictureMode::Cells) return facing * cellColor(cell);
    const Representation& r = pane.built->representation();
    return facing * blockColor(cell, effectiveFrameLevel(r, cell.resolution), r.isCompressed());
  }

  const Camera& camera;
  const Pane& pane;
  const PictureSettings& settings;
  Region region;
  Vec2f offset; // of the hits
  std::vector<SurfaceHit> hits;
  std::vector<float> errors; // only in PictureMode::Error
};

void drawLine(Image& image, ImageSize size, int column) {
  for (int y = 0; y < size.height; y++) image.set(size_t(y) * size_t(size.width) + size_t(column), {1, 1, 1});
}

} // namespace

const char* pictureModeName(PictureMode mode) {
  static const char* const names[] = {"shading", "normals", "error", "cells", "blocks"};
  return names[size_t(mode)];
}

bool Pane::canShow(PictureMode mode) const {
  if (mode == PictureMode::Error) return reference;
  return built || mode == PictureMode::Shading || mode == PictureMode::Normals;
}

int effectiveFrameLevel(const Representation& representation, unsigned resolution) {
  constexpr int autoBlockLevel = 4; // blocks of 16 x 16 quads
  int level = 0;
  while (resolution > 1u << level) level++;
  if (!representation.isCompressed()) return 0;
  if (!representation.hasFrames() || representation.frameLevel == autoFrameLevel)
    return std::max(0, level - autoBlockLevel); // as large as cVERT's blocks
  return std::min(representation.frameLevel, level);
}

int splitColumn(ImageSize size, float split) { return std::clamp(int(split * float(size.width)), 0, size.width - 1); }

Picture::Picture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings)
  : camera(camera),
    panes(panes),
    settings(settings),
    shown(camera.size()) {
  if (settings.mode == PictureMode::Shading) shading.emplace(camera, settings.up);
}

void Picture::addSample() {
  const ImageSize size = camera.size();
  const int middle = panes.size() == 2 ? splitColumn(size, settings.split) : size.width;
  const int borders[] = {0, middle, size.width};
  tbb::task_arena arena(int(settings.threads));
  for (size_t i = 0; i < panes.size(); i++)
    arena.execute([&] {
      PaneRender render(camera, panes[i], settings, {borders[i], borders[i + 1], size.height});
      PaneReport report = render.trace(count);
      if (settings.mode == PictureMode::Error) render.compare(report);
      if (shading) render.addTo(*shading);
      else render.paint(shown);
      if (count == 0) paneReports.push_back(report);
    });
  count++;
  if (shading) {
    shading->endSample();
    arena.execute([&] {
      forTiles({0, size.width, size.height}, [&](int x0, int x1, int y0, int y1) {
        for (int y = y0; y < y1; y++)
          for (int x = x0; x < x1; x++) {
            const size_t pixel = size_t(y) * size_t(size.width) + size_t(x);
            shown.set(pixel, shading->mean(pixel));
          }
      });
    });
  }
  if (panes.size() == 2) drawLine(shown, size, middle);
}

Image renderPicture(const Camera& camera, const std::vector<Pane>& panes, const PictureSettings& settings) {
  Picture picture(camera, panes, settings);
  while (!picture.isComplete()) {
    throwIfCanceled();
    picture.addSample();
  }
  return picture.image();
}

} // namespace programs
