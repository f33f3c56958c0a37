// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "view_pictures.h"

#include "measure/quad_size.h"
#include "pictures/error_picture.h"
#include "pictures/image_output.h"
#include "pictures/sampled_picture.h"
#include "basics/parallel.h"

#include <algorithm>
#include <filesystem>

namespace programs {

ViewPictures::ViewPictures(const BenchOptions& options, const std::string& scene, const Model& model, int level)
  : options(options),
    scene(scene),
    up(model.view.up),
    level(level) {}

void ViewPictures::write(const View& view, const Variant& variant, const BuiltScene& scene,
                         const std::vector<SurfaceHit>& hits, ViewResult& result) const {
  if (!wanted()) return;
  result.picture = stem(view, variant) + ".png";
  writePng(path(result.picture), shaded(view, scene, hits));
  if (variant.representation.kind == RepresentationKind::Grid) return;
  result.errorMap = stem(view, variant) + "_error.png";
  writePng(path(result.errorMap), errorPicture(options.size, pixelErrors(view.gridHits, hits, view.camera.footprint()),
                                               medianQuadSize(options.size, view.gridHits, level)));
}

Image ViewPictures::shaded(const View& view, const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const {
  return sampledPicture(scene, view.camera, view.camera.size(), up, primaryRays(view.camera), hits, options.samples,
                        Shutter(), HitColors::Neutral, threadCount(options.buildThreads))
      .image();
}

bool ViewPictures::wanted() const {
  const std::vector<int>& levels = options.pictureLevels;
  return !options.pictures.empty() &&
         (levels.empty() || std::find(levels.begin(), levels.end(), level) != levels.end());
}

std::string ViewPictures::stem(const View& view, const Variant& variant) const {
  std::string stem = scene + "_L" + std::to_string(level) + "_" + view.fileName + "_" +
                     variant.representation.fileStem() + (options.isas.size() > 1 ? "_" + variant.isa : "") +
                     (options.libraries.size() > 1 ? "_" + options.libraries[variant.library].name() : "");
  std::replace(stem.begin(), stem.end(), ':', '_'); // some file systems reject colons, as in "cube:0.45"
  return stem;
}

std::string ViewPictures::path(const std::string& name) const {
  return (std::filesystem::path(options.pictures) / name).string();
}

} // namespace programs
