// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a viewer has opened: a model, the view that it starts with, a coarse scene to
 * show at once, and the scenes that are built of it. Of a file of compressed surfaces: the scene
 * that is in it, and a model that has no more than its name and the corners of its box. */

#include "options.h"
#include "scene_store.h"

#include <memory>
#include <string>

namespace cbvh {

/* A model as read or made, ready to be shown. */
struct LoadedModel
{
  SceneSettings source;                // with the strength of the displacement, see withDefaultAmplitude
  Model model;
  std::string warnings;                // a line each
  std::optional<Camera> start;
  std::unique_ptr<BuiltScene> preview; // GRID at a low level, always on the CPU; or, of a file,
  std::unique_ptr<SavedScene> saved;   // all there is to show

  const TracedScene& first() const { return saved ? static_cast<const TracedScene&>(*saved) : *preview; }
  bool moves() const;
};

/* Opens the file, or reads or makes the model, and fits the view of the options to it: long work, for the
 * background. The preview refers to the model beside it. Throws Error, Cancelled. */
std::unique_ptr<const LoadedModel> loadModel(const SceneSettings& source, const ViewerOptions& options);

struct Document
{
  Document(std::unique_ptr<const LoadedModel> loaded, const ViewerOptions& options, Worker& worker)
    : loaded(std::move(loaded)), store(this->loaded->model, options.build, worker)
  {
    ViewDicing dicing;
    dicing.quadSize = options.quadSize;
    store.setDicing(dicing, options.maxPixelError);
  }

  const Model& model() const { return loaded->model; }

  const std::unique_ptr<const LoadedModel> loaded;
  SceneStore store;
};

} // namespace cbvh
