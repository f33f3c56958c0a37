// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes shaded pictures and error maps of the views of a group. */

#include "views.h"
#include "pictures/image.h"

namespace cbvh {

class ViewPictures
{
public:
  /* `scene` is the label of the scene. The options must outlive this object. */
  ViewPictures(const BenchOptions& options, const std::string& scene, const Model& model, int level);

  /* Writes the pictures of a variant in a view that the options name, and stores their file names in the result. `hits`
   * are the hits of the view's primary rays. Throws Error. */
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

} // namespace cbvh
