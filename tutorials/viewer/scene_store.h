// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The built scenes of a viewer. One scene is built at a time, in the background, so that the window stays responsive.
 * Earlier scenes stay while there is memory, so that switching back is immediate.
 *
 * All functions must be called from the same thread. References to scenes are valid until the next call of request. */

#include "building/built_scene.h"
#include "building/view_dicing.h"
#include "worker.h"

#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

constexpr int autoLevel = -1; // use rates by a view

/* Returns "auto", or the number. */
std::string levelText(int level);

struct SceneKey
{
  Representation representation;
  int level = 6;
  std::optional<Camera> camera; // only for autoLevel; unset for meshes and NAIVE, which do not depend on the view
};

/* True if both cameras are equal, or both are unset. */
bool isSameView(const std::optional<Camera>& a, const std::optional<Camera>& b);

/* Ignores frame levels of representations without frames. */
bool operator==(const SceneKey& a, const SceneKey& b);
inline bool operator!=(const SceneKey& a, const SceneKey& b) { return !(a == b); }

class SceneStore
{
public:
  /* The level of a key replaces the level of the settings. The worker, which builds, must outlive the store. */
  SceneStore(const Model& model, const BuildSettings& settings, Worker& worker);

  /* Sets how scenes of autoLevel are built. `maxPixelError` bounds the spacing of cVERT, 0 for no bound. */
  void setDicing(const ViewDicing& newDicing, float maxPixelError)
  {
    dicing = newDicing;
    pixelError = maxPixelError;
  }

  /* Stops the current build. */
  ~SceneStore();

  /* Keeps these scenes, and builds the missing ones in this order. Stops the current build if it is not requested. */
  void request(const std::vector<SceneKey>& keys);

  /* Adds a finished scene and starts the next build. */
  void poll();

  /* Waits until all requested scenes are built. Throws Error. */
  void finish();

  /* Returns null if the scene is not built. */
  const BuiltScene* find(const SceneKey& key) const;

  /* Returns why the last build failed; empty after the next call of request. */
  const std::string& failure() const { return error; }

private:
  struct Entry
  {
    SceneKey key;
    std::unique_ptr<BuiltScene> scene;
  };

  bool isRequested(const SceneKey& key) const;
  void start();
  void take();
  void makeRoom(const SceneKey& key);
  std::unique_ptr<BuiltScene> build(const SceneKey& key) const;

  const Model& model;
  BuildSettings settings;
  ViewDicing dicing;
  float pixelError = 0;
  std::list<Entry> entries; // the most recently requested first
  std::vector<SceneKey> requested;
  Worker& worker;
  std::optional<SceneKey> current;   // being built
  std::unique_ptr<BuiltScene> built; // by the worker, for `current`
  std::string error;
};

} // namespace cbvh
