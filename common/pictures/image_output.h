// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Pictures: PNG through OpenImageIO, hits as multi-channel EXR through OpenEXR. Both
 * appear under their names complete or not at all. */

#include "building/built_scene.h"
#include "tracing/camera.h"
#include "tracing/ray_sets.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cbvh {

/* 8-bit sRGB, rows from the top. */
struct Image
{
  explicit Image(ImageSize size) : size(size), rgb(size_t(size.width) * size.height * 3) {}

  /* color: linear, 0 to 1. */
  void set(size_t pixel, Vec3f color);

  ImageSize size;
  std::vector<uint8_t> rgb;
};

/* Throws Error with the path. */
void writePng(const std::string& path, const Image& image);

/* Writes hits of primary rays: float channels P.X P.Y P.Z (hit point), Z (distance
 * along the ray, infinite where it misses), N.X N.Y N.Z (geometric normal of length
 * 1), u, v, and primID as an unsigned integer (0xffffffff where it misses), which a
 * float cannot hold. Throws Error with the path. */
void writeHitsExr(const std::string& path, ImageSize size, const std::vector<Ray>& rays,
                  const std::vector<SurfaceHit>& hits);

} // namespace cbvh
