// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "views.h"
#include "pictures/image.h"

namespace programs {

class ViewPictures {
public:
  /* `scene` is its label. The options must outlive this object. */
  ViewPictures(const BenchOptions& options, const std::string& scene, const Model& model, int level);

  /* Writes the pictures that the options name, and stores their file names in the result. `hits` belong to the
   * view's primary rays. Throws Error. */
  void write(const View& view, const Variant& variant, const BuiltScene& scene, const std::vector<SurfaceHit>& hits,
             ViewResult& result) const;

private:
  bool wanted() const;
  Image shaded(const View& view, const BuiltScene& scene, const std::vector<SurfaceHit>& hits) const;
  std::string stem(const View& view, const Variant& variant) const;
  std::string path(const std::string& name) const;

  const BenchOptions& options;
  std::string scene;
  Vec3f up;
  int level;
};

} // namespace programs
