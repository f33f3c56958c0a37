// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces whose blocks are on a device, by FlatGeometry::buildID, for reuse while a scene uses them. Thread-safe. */

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

namespace embree::vulkan {

struct UploadedSurface;

class Uploads {
public:
  /* NULL if no scene on the device uses a copy of the surface's blocks. */
  std::shared_ptr<const UploadedSurface> find(uint64_t buildID) const {
    std::lock_guard<std::mutex> lock(mutex);
    const auto found = surfaces.find(buildID);
    return found == surfaces.end() ? nullptr : found->second.lock();
  }

  void add(uint64_t buildID, const std::shared_ptr<const UploadedSurface>& surface) {
    std::lock_guard<std::mutex> lock(mutex);
    surfaces[buildID] = surface;
  }

  void removeExpired() {
    std::lock_guard<std::mutex> lock(mutex);
    for (auto surface = surfaces.begin(); surface != surfaces.end();)
      surface = surface->second.expired() ? surfaces.erase(surface) : std::next(surface);
  }

private:
  mutable std::mutex mutex;
  std::map<uint64_t, std::weak_ptr<const UploadedSurface>> surfaces;
};

} // namespace embree::vulkan
