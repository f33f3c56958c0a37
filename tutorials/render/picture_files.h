// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions that write throw Error with the path. */

#include "building/representation.h"
#include "building/surface_hit.h"
#include "pictures/image.h"
#include "pictures/shading.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <string>
#include <utility>
#include <vector>

namespace programs {

class PictureFiles {
public:
  /* `samples` is per pixel of shaded pictures. */
  PictureFiles(std::string folder, std::string model, ImageSize whole, Crop part, HitColors colors, int samples)
    : folder(std::move(folder)),
      model(std::move(model)),
      whole(whole),
      part(part),
      size(part.size()),
      colors(colors),
      samples(samples) {}

  /* Returns the path. */
  std::string writePicture(const Representation& r, const Image& image);

  /* `colors` are linear; `hits` holds one entry per ray. */
  void writeExr(const Representation& r, const std::vector<Vec3f>& colors, const std::vector<Ray>& rays,
                const std::vector<SurfaceHit>& hits);

  /* `errors` is a result of pixelErrors. `quadPixels` is the length of a quad's edge, or 0. Parts of a picture have no
   * scale, so that they can be joined. */
  void writeErrors(const Representation& r, const std::vector<float>& errors, float quadPixels);

  /* `grid` is GRID's ambient occlusion; empty for `light` alone. */
  void writeAmbient(const Representation& r, const std::vector<float>& grid, const std::vector<float>& light);

  /* One line per kind of file. `reference` names the reference of the errors. */
  std::string legend(const std::string& reference) const;

private:
  std::string path(const Representation& r, const std::string& ending) const;
  std::string names(const std::vector<std::string>& stems, const std::string& ending) const;

  std::string folder, model;
  ImageSize whole;
  Crop part;
  ImageSize size; // of the part
  HitColors colors;
  int samples;
  std::vector<std::string> shaded, exr, errorMaps, ambient, ambientWithGrid; // of representations
};

} // namespace programs
