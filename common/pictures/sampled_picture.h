// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A shaded picture with several samples per pixel: with one, fine displacement looks like noise. */

#include "building/traced_scene.h"
#include "pictures/image.h"
#include "pictures/shading.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/shutter.h"

#include <vector>

namespace programs {

/* Position of sample i, in pixels from the center of the pixel. Sample 0 is the center. */
Vec2f sampleOffset(int i);

class SampledPicture {
public:
  SampledPicture(const Camera& camera, Vec3f up, HitColors colors = HitColors::Neutral);

  /* A pixel of the part has the same color as in the whole picture. */
  SampledPicture(const Camera& camera, const Crop& part, Vec3f up, HitColors colors = HitColors::Neutral);

  /* Adds a sample to each pixel. `rays` and `hits` hold one entry per pixel, in rows. Throws Canceled. */
  void add(const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits, unsigned threads = 1);

  /* Mean of the samples over the background: as sRGB, and linear. */
  Image image() const;
  std::vector<Vec3f> linear() const;

  /* Adds a sample to one pixel, for callers with their own loops. Different pixels may be on different threads. Call
   * endSample once every pixel has its sample. */
  void addTo(size_t pixel, const Ray& ray, const SurfaceHit& hit);
  void endSample() { samples++; }
  Vec3f mean(size_t pixel) const { return (1.0f / float(samples)) * sums[pixel]; } // linear

private:
  Crop part;
  int height; // of the whole picture
  HitShader shader;
  std::vector<Vec3f> sums; // linear
  int samples = 0;
};

/* `first` and `hits` are the first samples, from primaryRays with times. Throws Canceled. */
SampledPicture sampledPicture(const TracedScene& scene, const Camera& camera, const Crop& part, Vec3f up,
                              const std::vector<Ray>& first, const std::vector<SurfaceHit>& hits, int samples,
                              const Shutter& shutter, HitColors colors, unsigned threads);

} // namespace programs
