// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A shaded picture of several samples a pixel. Where quads are smaller than pixels, one sample shows one of them,
 * and fine displacement looks like salt and pepper. */

#include "building/traced_scene.h"
#include "pictures/image.h"
#include "pictures/shading.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/shutter.h"

#include <vector>

namespace cbvh {

/* Where sample i of a pixel lies, in pixels from its centre: the first there, all of them spread evenly over the pixel. */
Vec2f sampleOffset(int i);

class SampledPicture
{
public:
  SampledPicture(const Camera& camera, Vec3f up, HitColors colors = HitColors::Neutral);

  /* A part of it, with the colours that it has in the whole. */
  SampledPicture(const Camera& camera, const Crop& part, Vec3f up, HitColors colors = HitColors::Neutral);

  /* One sample more of each pixel. rays, hits: one a pixel, in rows. Throws Cancelled. */
  void add(const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits, unsigned threads = 1);

  /* The mean of the samples, before the background. */
  Image image() const;
  std::vector<Vec3f> linear() const;

  /* The same pixel by pixel, for callers with loops of their own: different pixels may be on different threads.
   * Every pixel gets its sample before endSample says that all have it. */
  void addTo(size_t pixel, const Ray& ray, const SurfaceHit& hit);
  void endSample() { samples++; }
  Vec3f mean(size_t pixel) const { return (1.0f / float(samples)) * sums[pixel]; } // linear

private:
  Crop part;
  int height; // of the whole
  HitShader shader;
  std::vector<Vec3f> sums; // linear
  int samples = 0;
};

/* The picture that a scene makes, or a part of it. rays, hits: of primaryRays, with times, which are the first samples. Throws Cancelled. */
SampledPicture sampledPicture(const TracedScene& scene, const Camera& camera, const Crop& part, Vec3f up, const std::vector<Ray>& rays, const std::vector<SurfaceHit>& hits,
                     int samples, const Shutter& shutter, HitColors colors, unsigned threads);

} // namespace cbvh
