// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The open document: a model, the initial view, a coarse preview, and scenes that are built from the model. For a
 * file of compressed surfaces: its scene, and the bounding box as a model. */

#include "options.h"
#include "scene_store.h"

#include <memory>
#include <string>

namespace programs {

struct LoadedModel {
  SceneSettings source; // has an amplitude or scale, see withDefaultAmplitude
  Model model;
  std::string warnings; // one per line
  std::optional<Camera> start;
  std::unique_ptr<BuiltScene> preview; // GRID at a low level on the CPU; null for files
  std::unique_ptr<SavedScene> saved;   // null for models

  const TracedScene& first() const { return saved ? static_cast<const TracedScene&>(*saved) : *preview; }
  bool moves() const;
};

/* Opens a file, or loads or generates a model, and fits the view. Slow. The result's preview refers to its model.
 * Throws Error. */
std::unique_ptr<const LoadedModel> loadModel(const SceneSettings& source, const ViewerOptions& options);

struct Document {
  Document(std::unique_ptr<const LoadedModel> loaded, const ViewerOptions& options, Worker& worker)
    : loaded(std::move(loaded)),
      store(this->loaded->model, options.build, worker) {
    ViewDicing dicing;
    dicing.quadSize = options.quadSize;
    store.setDicing(dicing, options.maxPixelError);
  }

  const Model& model() const { return loaded->model; }

  const std::unique_ptr<const LoadedModel> loaded;
  SceneStore store;
  std::string seamWarning; // once it was shown
};

} // namespace programs
