// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Settings of the application's devices and sizes of its buffers, kept while the application holds references to them.
 * Independent of Embree's headers. */

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace interposer {

/* Properties of objects that are identified by their handles. Thread-safe. Objects that were not added are ignored. */
template<typename Properties>
class Handles {
public:
  /* Adds a new object, to which the application holds one reference. */
  void add(const void* handle, const Properties& properties) {
    const std::lock_guard<std::mutex> lock(mutex);
    entries[handle] = {properties, 1};
  }

  /* Returns false for an unknown object. */
  bool retain(const void* handle) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(handle);
    if (found == entries.end()) return false;
    found->second.references++;
    return true;
  }

  /* Removes the object with its last reference. Must be called before Embree releases the object: afterwards, a new
   * object can have the same handle. */
  void release(const void* handle) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(handle);
    if (found != entries.end() && --found->second.references == 0) entries.erase(found);
  }

  bool contains(const void* handle) const {
    const std::lock_guard<std::mutex> lock(mutex);
    return entries.count(handle) != 0;
  }

  /* Returns the default for an unknown object. */
  Properties propertiesOf(const void* handle) const {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = entries.find(handle);
    return found == entries.end() ? Properties() : found->second.properties;
  }

  size_t size() const {
    const std::lock_guard<std::mutex> lock(mutex);
    return entries.size();
  }

private:
  struct Entry {
    Properties properties;
    size_t references;
  };

  mutable std::mutex mutex;
  std::map<const void*, Entry> entries;
};

/* Devices that rtcNewDevice returned. Other functions return devices of GPUs, which cannot trace substitutes. */
class Devices : public Handles<std::string> {
public:
  std::string settingsOf(const void* device) const { return propertiesOf(device); }
};

struct BufferSize {
  size_t bytes = SIZE_MAX;           // unlimited for unknown buffers
  bool requiresWholeStrides = false; // Embree 4.4 rejects a range that ends within its last stride

  /* True if an item of the range is not completely in the buffer. stride: from item to item, in bytes. */
  bool isExceededBy(size_t offset, size_t stride, size_t itemBytes, size_t count) const {
    if (count == 0) return false;
    if (requiresWholeStrides) itemBytes = std::max(itemBytes, stride);
    if (itemBytes > bytes || offset > bytes - itemBytes) return true;
    return stride != 0 && count - 1 > (bytes - itemBytes - offset) / stride;
  }
};

} // namespace interposer
