// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Device memory: buffers, imported host memory, uploads, and arenas. */

#include "device.h"

#include <memory>

namespace embree::vulkan {

class Buffer {
public:
  enum Kind {
    OnDevice, // in the device's memory; mapped if that is host-visible and coherent
    Staging   // in the host's memory, mapped, for copies
  };

  /* what: contents of the buffer, for messages. */
  Buffer(Device& device, size_t bytes, Kind kind, const char* what);

  /* Imports host memory, which must outlive the buffer. Requires RTCVulkanDeviceHandles::hasHostImport. begin and bytes
   * must be multiples of Capabilities::importAlignment. Does not set `mapped`. */
  Buffer(Device& device, void* begin, size_t bytes);

  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  const size_t bytes;
  char* mapped = nullptr; // host address of the contents, or NULL

private:
  void create(const void* next, const char* what);
  void allocate(VkMemoryAllocateInfo info, const char* what, const char* doing = "allocating ");
  void destroy();

  Device& device;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

/* A part of a buffer. Does not own it. */
struct Slice {
  Buffer* buffer = nullptr;
  size_t offset = 0;

  VkDeviceAddress address() const { return buffer->address + offset; }
};

/* Writes to buffers, through a staging buffer if they are not mapped. */
class Uploader {
public:
  explicit Uploader(Device& device) : device(device) {}

  /* Reads the data during the call; the device has it after flush(). The buffer must exist until then. offset: bytes
   * from the start of the slice. */
  void write(const Slice& to, size_t offset, const void* data, size_t bytes);

  /* Completes the writes and waits. */
  void flush();

  size_t written = 0; // bytes, in total

private:
  Device& device;
  std::unique_ptr<Buffer> staging;
  size_t used = 0;
  struct Copy {
    VkBuffer to;
    VkBufferCopy region;
  };
  std::vector<Copy> copies;
};

/* Allocates slices, aligned to 16 bytes, of shared buffers, because devices support few allocations. Large slices get
 * buffers of their own. */
class Arena {
public:
  explicit Arena(Device& device) : device(device) {}

  /* what: contents, for messages. */
  Slice allocate(size_t bytes, const char* what);

  size_t bytes() const;

private:
  Buffer& add(size_t bytes, const char* what);

  Device& device;
  std::vector<std::unique_ptr<Buffer>> buffers;
  size_t used = 0;            // bytes used of the current shared buffer
  size_t shared = ~size_t(0); // index of that buffer, or all bits set
};

} // namespace embree::vulkan
