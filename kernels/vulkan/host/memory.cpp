// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "memory.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace embree::vulkan {
namespace {

/* Returns the allowed memory type that has all needed flags and the most preferred ones. Throws VulkanError if there is
 * none. allowed: mask of types. what: for the message. */
uint32_t chooseType(const Capabilities& capabilities, uint32_t allowed, VkMemoryPropertyFlags needed,
                    VkMemoryPropertyFlags preferred, const char* what) {
  uint32_t best = ~0u;
  int bestScore = -1;
  for (uint32_t i = 0; i < capabilities.memory.memoryTypeCount; i++) {
    const VkMemoryPropertyFlags flags = capabilities.memory.memoryTypes[i].propertyFlags;
    if (!(allowed & (1u << i)) || (flags & needed) != needed) continue;
    const int score = __builtin_popcount(flags & preferred);
    if (score > bestScore) {
      best = i;
      bestScore = score;
    }
  }
  if (best == ~0u)
    throw VulkanError(RTC_ERROR_OUT_OF_MEMORY, std::string("Vulkan: the device has no type of memory for ") + what);
  return best;
}

constexpr VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
constexpr VkBufferUsageFlags structures = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
constexpr VkBufferUsageFlags transfer = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

std::string sizeText(size_t bytes) { return std::to_string(bytes) + " bytes"; }

void checkLimit(const Device& device, size_t bytes, const char* what) {
  if (bytes > device.capabilities.maxAllocation)
    throw VulkanError(RTC_ERROR_OUT_OF_MEMORY, std::string("Vulkan: the buffer for ") + what + " needs " +
                                                   sizeText(bytes) + ", and the device's maxMemoryAllocationSize is " +
                                                   sizeText(device.capabilities.maxAllocation));
}

} // namespace

Buffer::Buffer(Device& device, size_t bytes, Kind kind, const char* what)
  : bytes(std::max(bytes, size_t(16))),
    device(device) {
  checkLimit(device, this->bytes, what);
  try {
    create(nullptr, what);
    VkMemoryRequirements requirements;
    device.vk.GetBufferMemoryRequirements(device.handles.device, handle, &requirements);
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const uint32_t type = kind == OnDevice ? chooseType(device.capabilities, requirements.memoryTypeBits,
                                                        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                                                        device.capabilities.info.isDiscrete ? 0 : host, what)
                                           : chooseType(device.capabilities, requirements.memoryTypeBits, host,
                                                        VK_MEMORY_PROPERTY_HOST_CACHED_BIT, what);
    VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = requirements.size;
    info.memoryTypeIndex = type;
    allocate(info, what);
    const VkMemoryPropertyFlags flags = device.capabilities.memory.memoryTypes[type].propertyFlags;
    if ((flags & host) == host) {
      void* data = nullptr;
      check(device.vk.MapMemory(device.handles.device, memory, 0, VK_WHOLE_SIZE, 0, &data),
            "mapping " + sizeText(info.allocationSize) + " for " + what);
      mapped = static_cast<char*>(data);
    }
  } catch (...) {
    destroy();
    throw;
  }
}

Buffer::Buffer(Device& device, void* begin, size_t bytes) : bytes(bytes), device(device) {
  const char* what = "blocks in the host's memory";
  checkLimit(device, bytes, what);
  try {
    VkExternalMemoryBufferCreateInfo external = {VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO};
    external.handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
    create(&external, what);
    VkMemoryHostPointerPropertiesEXT pointer = {VK_STRUCTURE_TYPE_MEMORY_HOST_POINTER_PROPERTIES_EXT};
    check(device.vk.GetMemoryHostPointerPropertiesEXT(
              device.handles.device, VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT, begin, &pointer),
          "importing " + sizeText(bytes) + " of the host's memory");
    VkMemoryRequirements requirements;
    device.vk.GetBufferMemoryRequirements(device.handles.device, handle, &requirements);
    VkImportMemoryHostPointerInfoEXT import = {VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT};
    import.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
    import.pHostPointer = begin;
    VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.pNext = &import;
    info.allocationSize = bytes;
    info.memoryTypeIndex =
        chooseType(device.capabilities, requirements.memoryTypeBits & pointer.memoryTypeBits, 0, 0, what);
    allocate(info, what, "importing ");
  } catch (...) {
    destroy();
    throw;
  }
}

void Buffer::create(const void* next, const char* what) {
  VkBufferCreateInfo info = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.pNext = next;
  info.size = bytes;
  info.usage = next ? usage : usage | transfer | (device.handles.hasRayQuery ? structures : 0);
  check(device.vk.CreateBuffer(device.handles.device, &info, nullptr, &handle),
        "creating a buffer of " + sizeText(bytes) + " for " + what);
}

void Buffer::allocate(VkMemoryAllocateInfo info, const char* what, const char* doing) {
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  flags.pNext = info.pNext;
  info.pNext = &flags;
  check(device.vk.AllocateMemory(device.handles.device, &info, nullptr, &memory),
        doing + sizeText(info.allocationSize) + " for " + what);
  check(device.vk.BindBufferMemory(device.handles.device, handle, memory, 0),
        "binding " + sizeText(info.allocationSize) + " for " + what);
  VkBufferDeviceAddressInfo address = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = handle;
  this->address = device.vk.GetBufferDeviceAddress(device.handles.device, &address);
}

Buffer::~Buffer() { destroy(); }

void Buffer::destroy() {
  if (handle) device.vk.DestroyBuffer(device.handles.device, handle, nullptr);
  if (memory) device.vk.FreeMemory(device.handles.device, memory, nullptr);
}

/* --- uploads ---------------------------------------------------------------------------- */

void Uploader::write(const Slice& to, size_t offset, const void* data, size_t bytes) {
  written += bytes;
  if (to.buffer->mapped) {
    std::memcpy(to.buffer->mapped + to.offset + offset, data, bytes);
    return;
  }
  const size_t size = std::min(size_t(32) << 20, device.capabilities.maxAllocation);
  if (!staging) staging.reset(new Buffer(device, size, Buffer::Staging, "copies to the device"));
  for (size_t done = 0; done < bytes;) {
    if (used == size) flush();
    const size_t n = std::min(bytes - done, size - used);
    std::memcpy(staging->mapped + used, static_cast<const char*>(data) + done, n);
    const VkDeviceSize target = to.offset + offset + done;
    Copy* last = copies.empty() ? nullptr : &copies.back();
    if (last && last->to == to.buffer->handle && last->region.dstOffset + last->region.size == target &&
        last->region.srcOffset + last->region.size == used)
      last->region.size += n;
    else copies.push_back({to.buffer->handle, {used, target, n}});
    used += n;
    done += n;
  }
}

void Uploader::flush() {
  if (copies.empty()) return;
  device.run([&](VkCommandBuffer commands) {
    for (const Copy& copy : copies) device.vk.CmdCopyBuffer(commands, staging->handle, copy.to, 1, &copy.region);
    VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    // not only compute shaders: also builds of structures, and ray tracing pipelines of the application
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT;
    device.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1,
                                 &barrier, 0, nullptr, 0, nullptr);
  });
  copies.clear();
  used = 0;
}

/* --- arenas ------------------------------------------------------------------------------ */

Buffer& Arena::add(size_t bytes, const char* what) {
  std::unique_ptr<Buffer> buffer(new Buffer(device, bytes, Buffer::OnDevice, what));
  buffers.push_back(std::move(buffer));
  return *buffers.back();
}

Slice Arena::allocate(size_t bytes, const char* what) {
  const size_t largest = std::min(size_t(16) << 20, device.capabilities.maxAllocation);
  bytes = (bytes + 15) & ~size_t(15);
  if (bytes > largest / 64) return {&add(bytes, what), 0};
  if (shared == ~size_t(0) || used + bytes > buffers[shared]->bytes) {
    /* Sizes double from 16 KiB to 16 MiB: little memory for small scenes, few buffers for large ones. */
    const size_t size = shared == ~size_t(0) ? size_t(1) << 14 : 2 * buffers[shared]->bytes;
    add(std::max(bytes, std::min(size, largest)), what);
    shared = buffers.size() - 1;
    used = 0;
  }
  const Slice slice = {buffers[shared].get(), used};
  used += bytes;
  return slice;
}

size_t Arena::bytes() const {
  size_t sum = 0;
  for (const auto& buffer : buffers) sum += buffer->bytes;
  return sum;
}

} // namespace embree::vulkan
