// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds one scene at a time in the background. Earlier scenes stay while there is memory, for switching back.
 *
 * Call all functions on one thread. Requested scenes stay valid until the next request, others until the next poll. */

#include "building/built_scene.h"
#include "building/view_dicing.h"
#include "worker.h"

#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace programs {

constexpr int autoLevel = -1; // rates by a view

/* "auto", or the number. */
std::string levelText(int level);

struct SceneKey {
  Representation representation;
  int level = 6;
  std::optional<Camera> camera; // only for autoLevel, except meshes and triangles
};

/* True if equal, or both unset. */
bool isSameView(const std::optional<Camera>& a, const std::optional<Camera>& b);

/* Ignores frame levels of NAIVE and GRID. */
bool operator==(const SceneKey& a, const SceneKey& b);
inline bool operator!=(const SceneKey& a, const SceneKey& b) { return !(a == b); }

class SceneStore {
public:
  /* The key's level replaces the settings' level. Model and worker must outlive the store. */
  SceneStore(const Model& model, const BuildSettings& settings, Worker& worker);

  /* Settings for autoLevel. `maxPixelError` bounds the spacing of cVERT, 0 for no bound. */
  void setDicing(const ViewDicing& newDicing, float maxPixelError) {
    dicing = newDicing;
    pixelError = maxPixelError;
  }

  ~SceneStore();

  /* Keeps these scenes and builds the missing ones in this order. Stops any other build. */
  void request(const std::vector<SceneKey>& keys);

  /* Adds a finished scene and starts the next build. */
  void poll();

  /* Waits for all requested scenes. Throws Error. */
  void finish();

  /* Null if not built. */
  const BuiltScene* find(const SceneKey& key) const;

  /* Returns the largest gap of the scenes that are kept. */
  SeamGap largestSeamGap() const;

  /* Reason why the last build failed; the next request clears it. */
  const std::string& failure() const { return error; }

private:
  struct Entry {
    SceneKey key;
    std::unique_ptr<BuiltScene> scene;
  };

  bool isRequested(const SceneKey& key) const;
  void start();
  void addBuilt();
  void makeRoom(const SceneKey& key);
  std::unique_ptr<BuiltScene> build(const SceneKey& key) const;

  const Model& model;
  BuildSettings settings;
  ViewDicing dicing;
  float pixelError = 0;
  std::list<Entry> entries; // most recently requested first
  std::vector<SceneKey> requested;
  Worker& worker;
  std::optional<SceneKey> current;   // being built
  std::unique_ptr<BuiltScene> built; // by the worker
  std::string error;
};

} // namespace programs
