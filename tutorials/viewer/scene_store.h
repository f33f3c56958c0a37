// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The built scenes of a viewer. One is built at a time, in the background, so that
 * the window goes on; scenes looked at before stay while there is memory, so that
 * switching back and forth is instant.
 *
 * Everything here is called from one thread; scenes that it hands out live until the
 * next call of request. */

#include "building/built_scene.h"
#include "building/view_dicing.h"
#include "worker.h"

#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

constexpr int autoLevel = -1; // rates by a view

/* "auto", or the number. */
std::string levelText(int level);

struct SceneKey
{
  Representation representation;
  int level = 6;
  std::optional<Camera> camera; // of autoLevel; none of what has one level whatever the view, meshes and NAIVE
};

/* Whether both are the same, or none. */
bool isSameView(const std::optional<Camera>& a, const std::optional<Camera>& b);

/* Frame levels count where there are frames only. */
bool operator==(const SceneKey& a, const SceneKey& b);
inline bool operator!=(const SceneKey& a, const SceneKey& b) { return !(a == b); }

class SceneStore
{
public:
  /* settings: its level is overruled by those of the keys. worker: builds; outlives
   * the store. */
  SceneStore(const Model& model, const BuildSettings& settings, Worker& worker);

  /* How scenes of autoLevel are built. maxPixelError: on the spacing of cVERT, 0 for none. */
  void setDicing(const ViewDicing& how, float maxPixelError)
  {
    dicing = how;
    pixelError = maxPixelError;
  }

  /* Stops a build that is under way. */
  ~SceneStore();

  /* Keeps these scenes and builds what is missing of them, in this order. Stops a
   * build that is not among them. */
  void request(const std::vector<SceneKey>& keys);

  /* Takes over what has been built since and starts the next build. */
  void poll();

  /* Waits until everything requested is there. Throws Error, Cancelled. */
  void finish();

  /* Null if it is not built. */
  const BuiltScene* find(const SceneKey& key) const;

  /* Why the last build failed; empty once another one is requested. */
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
  std::list<Entry> entries; // requested last, first
  std::vector<SceneKey> requested;
  Worker& worker;
  std::optional<SceneKey> underWay;
  std::unique_ptr<BuiltScene> built; // by the worker, for underWay
  std::string error;
};

} // namespace cbvh
