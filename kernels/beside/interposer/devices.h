// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Settings of the application's devices, kept while the application holds references to them. Independent of Embree's
 * headers. */

#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace interposer {

/* Devices are identified by their handles. Thread-safe. Devices that were not added are ignored. */
class Devices
{
public:
  /* Adds a new device, to which the application holds one reference. */
  void add(const void* device, const std::string& settings)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    entries[device] = {settings, 1};
  }

  void retain(const void* device)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(device);
    if (found != entries.end()) found->second.references++;
  }

  /* Removes the device with its last reference. Must be called before Embree releases the device: afterwards, a new
   * device can have the same handle. */
  void release(const void* device)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(device);
    if (found != entries.end() && --found->second.references == 0) entries.erase(found);
  }

  /* Returns "" for an unknown device. */
  std::string settingsOf(const void* device) const
  {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(device);
    return found == entries.end() ? "" : found->second.settings;
  }

  size_t size() const
  {
    const std::lock_guard<std::mutex> lock(mutex);
    return entries.size();
  }

private:
  struct Entry
  {
    std::string settings;
    size_t references;
  };

  mutable std::mutex mutex;
  std::map<const void*, Entry> entries;
};

} // namespace interposer
