// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory of a device: buffers with addresses, an arena that many small things share a buffer of,
 * and memory of the host that the device uses in place. */

#include "device.h"

#include <memory>

namespace embree { namespace vulkan {

/* A buffer with memory of its own. */
class Buffer
{
public:
  enum Kind
  {
    OnDevice,  // the device's own memory, mapped where it is the host's too
    Staging    // the host's, mapped
  };

  /* Throws VulkanError that names `what` and its size. */
  Buffer(Device& device, size_t bytes, Kind kind, const char* what);

  /* Uses memory of the host in place: begin and bytes are multiples of the device's importAlignment. */
  Buffer(Device& device, void* begin, size_t bytes);

  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  const size_t bytes;
  char* mapped = nullptr;   // NULL if the host does not see it

private:
  void create(const void* next, const char* what);
  void allocate(VkMemoryAllocateInfo info, const char* what, const char* doing = "allocating ");
  void destroy();

  Device& device;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

/* A part of a buffer. */
struct Slice
{
  Buffer* buffer = nullptr;
  size_t offset = 0;

  VkDeviceAddress address() const { return buffer->address + offset; }
};

/* Fills buffers of a device: through their mapping, or by way of a staging buffer. */
class Uploader
{
public:
  explicit Uploader(Device& device) : device(device) {}

  void write(const Slice& to, size_t offset, const void* data, size_t bytes);
  void flush();   // what was written is then in place

  size_t written = 0;   // bytes, in all

private:
  Device& device;
  std::unique_ptr<Buffer> staging;
  size_t used = 0;   // of it
  struct Copy { VkBuffer to; VkBufferCopy region; };
  std::vector<Copy> copies;
};

/* Parts of large buffers; aligned to 16 bytes. */
class Arena
{
public:
  explicit Arena(Device& device) : device(device) {}

  /* what: for messages. */
  Slice take(size_t bytes, const char* what);

  size_t bytes() const;

private:
  Buffer& add(size_t bytes, const char* what);

  Device& device;
  std::vector<std::unique_ptr<Buffer>> buffers;
  size_t used = 0;   // of the last shared one
  size_t shared = ~size_t(0);
};

}} // namespace embree::vulkan
