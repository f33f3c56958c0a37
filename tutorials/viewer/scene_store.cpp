// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scene_store.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "building/memory.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>

namespace programs {
namespace {

/* Both halves and GRID, and as many for switching back. */
constexpr size_t maxEntries = 6;

std::string name(const SceneKey& key) { return key.representation.label() + ", level " + levelText(key.level); }

} // namespace

std::string levelText(int level) { return level == autoLevel ? "auto" : std::to_string(level); }

bool isSameView(const std::optional<Camera>& a, const std::optional<Camera>& b) {
  if (!a || !b) return !a && !b;
  return a->description() == b->description() && a->size().width == b->size().width &&
         a->size().height == b->size().height;
}

bool operator==(const SceneKey& a, const SceneKey& b) {
  return a.level == b.level && isSameView(a.camera, b.camera) && a.representation.kind == b.representation.kind &&
         (!a.representation.hasFrames() || a.representation.frameLevel == b.representation.frameLevel);
}

SceneStore::SceneStore(const Model& model, const BuildSettings& settings, Worker& worker)
  : model(model),
    settings(settings),
    worker(worker) {}

SceneStore::~SceneStore() {
  if (current) worker.stop();
}

bool SceneStore::isRequested(const SceneKey& key) const {
  return std::find(requested.begin(), requested.end(), key) != requested.end();
}

const BuiltScene* SceneStore::find(const SceneKey& key) const {
  for (const Entry& e : entries)
    if (e.key == key) return e.scene.get();
  return nullptr;
}

SeamGap SceneStore::largestSeamGap() const {
  SeamGap largest;
  for (const Entry& e : entries)
    if (const SeamGap& gap = e.scene->report().seams; gap.quads > largest.quads) largest = gap;
  return largest;
}

void SceneStore::request(const std::vector<SceneKey>& keys) {
  requested = keys;
  error.clear();
  /* Requested scenes first, the others by age. */
  entries.sort([&](const Entry& a, const Entry& b) { return isRequested(a.key) && !isRequested(b.key); });
  if (current && !isRequested(*current)) worker.cancel();
  start();
}

void SceneStore::makeRoom(const SceneKey& key) {
  /* Unknown for a view until it is diced. */
  const int level = key.level == autoLevel ? BuildSettings().level : key.level;
  const size_t needed = key.camera ? 0 : estimatedPeakBytes(key.representation.kind, {model, level});
  while (!entries.empty() && !isRequested(entries.back().key) &&
         (entries.size() + 1 > maxEntries || needed > availableMemory()))
    entries.pop_back();
  const size_t available = availableMemory();
  if (needed <= available) return;
  char text[160];
  std::snprintf(text, sizeof(text), "not enough memory: %s needs about %.1f GiB, but %.1f GiB are free",
                name(key).c_str(), double(needed) / (1 << 30), double(available) / (1 << 30));
  throw Error(text);
}

void SceneStore::start() {
  if (worker.hasTask() || !error.empty()) return;
  for (const SceneKey& key : requested) {
    if (find(key)) continue;
    try {
      makeRoom(key);
    } catch (const Error& e) {
      error = e.what();
      return;
    }
    current = key;
    worker.start("building " + name(key), [this, key] { built = build(key); });
    return;
  }
}

std::unique_ptr<BuiltScene> SceneStore::build(const SceneKey& key) const {
  BuildSettings own = settings;
  own.level = key.level == autoLevel ? BuildSettings().level : key.level;
  if (key.camera) {
    ViewDicing keyDicing = dicing;
    keyDicing.maxRate = highestRate({key.representation});
    own = settingsForView(own, model, *key.camera, keyDicing, pixelError);
    const BuildSize size(own.rates->quads, 1 + model.poses.size());
    if (estimatedPeakBytes(key.representation.kind, size) > availableMemory())
      throw Error("not enough memory for " + std::to_string(own.rates->quads / 1000000) +
                  " million quads: expected a larger --quad-size");
  }
  return std::make_unique<BuiltScene>(model, key.representation, own);
}

void SceneStore::poll() {
  if (current && worker.finished()) addBuilt();
  start();
}

void SceneStore::addBuilt() {
  const SceneKey key = *current;
  current.reset();
  try {
    worker.join();
    if (built->report().quads == 0)
      throw Error(model.name + ": Embree tessellates no face of this cage: expected faces that are neither holes nor "
                               "invalid");
    entries.push_front({key, std::move(built)});
  } catch (const Canceled&) {
    if (interrupted()) throw;
  } catch (const std::bad_alloc&) { error = name(key) + ": out of memory"; } catch (const std::exception& e) {
    error = name(key) + ": " + e.what();
  }
  built.reset(); // frees it if it is no longer requested
}

void SceneStore::finish() {
  while (current) {
    worker.wait();
    poll();
  }
  if (!error.empty()) throw Error(error);
}

} // namespace programs
