// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "picture_files.h"
#include "pictures/error_picture.h"
#include "pictures/image_output.h"

#include <filesystem>

namespace programs {

std::string PictureFiles::writePicture(const Representation& r, const Image& image) {
  writePng(path(r, ".png"), image);
  shaded.push_back(r.fileStem());
  return path(r, ".png");
}

void PictureFiles::writeExr(const Representation& r, const std::vector<Vec3f>& colors, const std::vector<Ray>& rays,
                            const std::vector<SurfaceHit>& hits) {
  programs::writeExr(path(r, ".exr"), whole, part, colors, rays, hits);
  exr.push_back(r.fileStem());
}

void PictureFiles::writeErrors(const Representation& r, const std::vector<float>& errors, float quadPixels) {
  const bool isPart = size.width != whole.width || size.height != whole.height;
  writePng(path(r, "_error.png"), isPart ? errorHeatMap(size, errors) : errorPicture(size, errors, quadPixels));
  errorMaps.push_back(r.fileStem());
}

void PictureFiles::writeAmbient(const Representation& r, const std::vector<float>& grid,
                                const std::vector<float>& light) {
  writePng(path(r, "_ambient.png"), grid.empty() ? grayImage(size, light) : compareAmbient(size, grid, light));
  (grid.empty() ? ambient : ambientWithGrid).push_back(r.fileStem());
}

std::string PictureFiles::path(const Representation& r, const std::string& ending) const {
  return (std::filesystem::path(folder) / (model + "_" + r.fileStem() + ending)).string();
}

/* Lists paths in the syntax of a shell: trex_{grid,cleaf2}.png. */
std::string PictureFiles::names(const std::vector<std::string>& stems, const std::string& ending) const {
  std::string list;
  for (const std::string& stem : stems) list += (list.empty() ? "" : ",") + stem;
  const std::string name = stems.size() > 1 ? "{" + list + "}" : list;
  return (std::filesystem::path(folder) / (model + "_" + name + ending)).string();
}

std::string PictureFiles::legend(const std::string& reference) const {
  const auto line = [&](const std::vector<std::string>& stems, const std::string& ending, const std::string& shows) {
    return stems.empty() ? "" : "  " + names(stems, ending) + ": " + shows + "\n";
  };
  const std::string shading =
      colors == HitColors::Sides ? "shaded, magenta if the normal points away from the camera" : "shaded";
  return "Pictures:\n" +
         line(shaded, ".png",
              shading + ", " + std::to_string(samples) + (samples == 1 ? " sample" : " samples") + " per pixel") +
         line(exr, ".exr",
              "linear colors, and position, distance, normal, u, v and primID of hits at the centers of pixels") +
         line(errorMaps, "_error.png",
              "distance from " + reference +
                  " at the center of the pixel, from blue (none) to pink (5 pixels and "
                  "more); black: false hit, orange: miss") +
         line(ambient, "_ambient.png", "ambient occlusion") +
         line(ambientWithGrid, "_ambient.png",
              "ambient occlusion of GRID, of this representation, and 4 times the difference");
}

} // namespace programs
