// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "faults.h"

#include "kernels/vulkan/host/functions.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace programs::test {
namespace {

Faults* faults = nullptr;

// --- kinds of objects --------------------------------------------------------------------------

template<typename Handle> constexpr const char* kindOf = nullptr;
template<> constexpr const char* kindOf<VkInstance> = "instance";
template<> constexpr const char* kindOf<VkDevice> = "device";
template<> constexpr const char* kindOf<VkBuffer> = "buffer";
template<> constexpr const char* kindOf<VkDeviceMemory> = "memory";
template<> constexpr const char* kindOf<VkShaderModule> = "shader module";
template<> constexpr const char* kindOf<VkPipelineLayout> = "pipeline layout";
template<> constexpr const char* kindOf<VkPipeline> = "pipeline";
template<> constexpr const char* kindOf<VkPipelineCache> = "pipeline cache";
template<> constexpr const char* kindOf<VkCommandPool> = "command pool";
template<> constexpr const char* kindOf<VkCommandBuffer> = "command buffer";
template<> constexpr const char* kindOf<VkQueryPool> = "query pool";
template<> constexpr const char* kindOf<VkFence> = "fence";

template<typename Handle>
void created(const Handle* handles, uint32_t count) {
  static_assert(kindOf<Handle> != nullptr, "add the kind of this object to kindOf");
  for (uint32_t i = 0; i < count; i++) faults->created(kindOf<Handle>, handles[i]);
}

template<typename Handle>
void destroyed(Handle handle) {
  static_assert(kindOf<Handle> != nullptr, "add the kind of this object to kindOf");
  if (handle) faults->destroyed(kindOf<Handle>, handle);
}

// --- observing calls by their arguments --------------------------------------------------------

// before the call
template<typename... Arguments>
void begins(Arguments...) {}

template<typename Owner, typename Handle,
         typename = std::enable_if_t<std::is_pointer_v<Handle> && kindOf<Handle> != nullptr>>
void begins(Owner, Handle handle, const VkAllocationCallbacks*) {
  destroyed(handle);
}

void begins(VkDevice device, const VkAllocationCallbacks*) { destroyed(device); }

void begins(VkInstance instance, const VkAllocationCallbacks*) {
  destroyed(instance);
  if (faults->onInstanceEnd) faults->onInstanceEnd(instance);
}

void begins(VkDevice, VkCommandPool, uint32_t count, const VkCommandBuffer* commands) {
  for (uint32_t i = 0; i < count; i++) destroyed(commands[i]);
}

void begins(VkDevice, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks*, VkDeviceMemory*) {
  faults->asked(info->allocationSize);
  if (faults->onAllocation) faults->onAllocation(*info);
}

void begins(VkCommandBuffer, VkPipelineStageFlags, VkPipelineStageFlags to, VkDependencyFlags, uint32_t count,
            const VkMemoryBarrier* barriers, uint32_t, const VkBufferMemoryBarrier*, uint32_t,
            const VkImageMemoryBarrier*) {
  for (uint32_t i = 0; i < count; i++)
    if (faults->onBarrier) faults->onBarrier(barriers[i], to);
}

void begins(VkDevice, const VkPipelineCacheCreateInfo* info, const VkAllocationCallbacks*, VkPipelineCache*) {
  faults->askedCache(info->initialDataSize);
}

// after a successful call
template<typename... Arguments>
void ends(Arguments...) {}

template<typename Owner, typename Info, typename Handle>
void ends(Owner, const Info*, const VkAllocationCallbacks*, Handle* handle) {
  created(handle, 1);
}

void ends(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance* instance) {
  created(instance, 1);
  if (faults->onInstance) faults->onInstance(*instance);
}

void ends(VkDevice, VkPipelineCache, uint32_t count, const VkComputePipelineCreateInfo*, const VkAllocationCallbacks*,
          VkPipeline* pipelines) {
  created(pipelines, count);
}

void ends(VkDevice, const VkCommandBufferAllocateInfo* info, VkCommandBuffer* commands) {
  created(commands, info->commandBufferCount);
}

void ends(VkPhysicalDevice, VkPhysicalDeviceProperties* properties) {
  if (faults->isDiscrete) properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  if (faults->onProperties) faults->onProperties(*properties);
}
void ends(VkPhysicalDevice, VkPhysicalDeviceProperties2* properties) {
  if (faults->onProperties2) faults->onProperties2(*properties);
}
void ends(VkPhysicalDevice, VkPhysicalDeviceFeatures2* features) {
  if (faults->onFeatures) faults->onFeatures(*features);
}

// --- discrete devices: every memory type exists twice, for the device and for the host -------------

uint32_t numMemoryTypes = 0; // number of actual types

void ends(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* memory) {
  numMemoryTypes = memory->memoryTypeCount;
  if (!faults->isDiscrete) return;
  memory->memoryTypeCount = std::min(2 * numMemoryTypes, uint32_t(VK_MAX_MEMORY_TYPES));
  for (uint32_t i = 0; i < numMemoryTypes; i++) {
    const uint32_t heap = memory->memoryTypes[i].heapIndex;
    if (i + numMemoryTypes < memory->memoryTypeCount)
      memory->memoryTypes[i + numMemoryTypes] = {
          memory->memoryTypes[i].propertyFlags & ~VkMemoryPropertyFlags(VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT), heap};
    memory->memoryTypes[i].propertyFlags &= VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  }
}

void ends(VkDevice, VkBuffer, VkMemoryRequirements* requirements) {
  if (faults->isDiscrete) requirements->memoryTypeBits |= requirements->memoryTypeBits << numMemoryTypes;
}

// --- modified lists ------------------------------------------------------------------------------

template<typename Item, typename List, typename Change>
VkResult changedList(List list, const Change& change, uint32_t* count, Item* items) {
  uint32_t all = 0;
  VkResult result = list(&all, nullptr);
  if (result != VK_SUCCESS) return result;
  std::vector<Item> changed(all);
  result = list(&all, changed.data());
  if (result != VK_SUCCESS) return result;
  change(changed);
  const uint32_t most = items ? *count : uint32_t(changed.size());
  *count = std::min(most, uint32_t(changed.size()));
  if (items) std::copy(changed.begin(), changed.begin() + *count, items);
  return *count < changed.size() ? VK_INCOMPLETE : VK_SUCCESS;
}

// By default, only calls the function.
template<typename Result, typename... Arguments>
Result forwarded(Result(VKAPI_PTR* next)(Arguments...), Arguments... arguments) {
  return next(arguments...);
}

VkResult forwarded(PFN_vkEnumeratePhysicalDevices next, VkInstance instance, uint32_t* count,
                   VkPhysicalDevice* devices) {
  if (!faults->onDevices) return next(instance, count, devices);
  return changedList([&](uint32_t* n, VkPhysicalDevice* to) { return next(instance, n, to); }, faults->onDevices, count,
                     devices);
}

VkResult forwarded(PFN_vkEnumerateDeviceExtensionProperties next, VkPhysicalDevice device, const char* layer,
                   uint32_t* count, VkExtensionProperties* extensions) {
  if (!faults->onExtensions) return next(device, layer, count, extensions);
  return changedList([&](uint32_t* n, VkExtensionProperties* to) { return next(device, layer, n, to); },
                     faults->onExtensions, count, extensions);
}

VkResult forwarded(PFN_vkCreateInstance next, const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                   VkInstance* instance) {
  if (!faults->onInstanceInfo) return next(info, callbacks, instance);
  const VkInstanceCreateInfo changed = faults->onInstanceInfo(*info);
  return next(&changed, callbacks, instance);
}

VkResult forwarded(PFN_vkAllocateMemory next, VkDevice device, const VkMemoryAllocateInfo* info,
                   const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
  VkMemoryAllocateInfo changed = *info;
  if (faults->isDiscrete && changed.memoryTypeIndex >= numMemoryTypes) changed.memoryTypeIndex -= numMemoryTypes;
  return next(device, &changed, callbacks, memory);
}

PFN_vkVoidFunction VKAPI_CALL getDeviceProcAddr(VkDevice device, const char* name) {
  return faults->find(device, name);
}

// --- wrappers --------------------------------------------------------------------------------------

#define CBVH_TEST_FUNCTIONS(F) \
  F(CreateInstance) CBVH_INSTANCE_FUNCTIONS(F) CBVH_DEVICE_FUNCTIONS(F) F(GetMemoryHostPointerPropertiesEXT)

#define CBVH_NAME(NAME) of##NAME,
enum FunctionIndex { CBVH_TEST_FUNCTIONS(CBVH_NAME) numFunctions };
#undef CBVH_NAME

template<int index, typename Function> struct Wrapper;

template<int index, typename Result, typename... Arguments>
struct Wrapper<index, Result(VKAPI_PTR*)(Arguments...)> {
  using Function = Result(VKAPI_PTR*)(Arguments...);
  static inline const char* name = nullptr;
  static inline Function next = nullptr;

  static Result VKAPI_CALL call(Arguments... arguments) {
    const Faults::Failure failure = faults->called(name);
    if constexpr (std::is_same_v<Result, VkResult>) {
      if (failure.now && failure.when == Faults::INSTEAD) {
        if constexpr (index == ofAllocateMemory) begins(arguments...);
        return failure.result;
      }
      begins(arguments...);
      const VkResult result = forwarded(next, arguments...);
      if (result == VK_SUCCESS) ends(arguments...);
      return failure.now ? failure.result : result;
    } else if constexpr (std::is_void_v<Result>) {
      begins(arguments...);
      next(arguments...);
      ends(arguments...);
    } else {
      return next(arguments...);
    }
  }
};
// Returns the wrapper of a function, or `found` if there is none.
PFN_vkVoidFunction wrapped(const char* name, PFN_vkVoidFunction found) {
  if (!found) return nullptr;
#define CBVH_WRAP(NAME) \
  if (!std::strcmp(name, "vk" #NAME)) { \
    using Wrap = Wrapper<of##NAME, PFN_vk##NAME>; \
    Wrap::name = #NAME; \
    Wrap::next = PFN_vk##NAME(found); \
    return PFN_vkVoidFunction(&Wrap::call); \
  }
  CBVH_TEST_FUNCTIONS(CBVH_WRAP)
#undef CBVH_WRAP
  return found;
}

template<typename Result, typename... Arguments>
constexpr bool isFallible(Result(VKAPI_PTR*)(Arguments...)) {
  return std::is_same_v<Result, VkResult>;
}

PFN_vkVoidFunction VKAPI_CALL getInstanceProcAddrOfFaults(VkInstance instance, const char* name) {
  return faults->find(instance, name);
}

} // namespace

// --- faults ----------------------------------------------------------------------------------------

Faults::Faults(PFN_vkGetInstanceProcAddr next) : next(next) {
  if (faults) throw std::logic_error("only one Faults object may exist");
  faults = this;
}

Faults::~Faults() { faults = nullptr; }

PFN_vkGetInstanceProcAddr Faults::getInstanceProcAddr() const { return getInstanceProcAddrOfFaults; }

std::vector<std::string> Faults::fallible() {
  std::vector<std::string> names;
#define CBVH_LIST(NAME) \
  if (isFallible(PFN_vk##NAME(nullptr))) names.push_back(#NAME);
  CBVH_TEST_FUNCTIONS(CBVH_LIST)
#undef CBVH_LIST
  return names;
}

PFN_vkVoidFunction Faults::find(VkInstance instance, const char* name) {
  if (hidden.count(name + 2)) return nullptr;
  if (!std::strcmp(name, "vkGetInstanceProcAddr")) return PFN_vkVoidFunction(getInstanceProcAddrOfFaults);
  const PFN_vkVoidFunction found = next(instance, name);
  if (!std::strcmp(name, "vkGetDeviceProcAddr")) {
    nextOfDevice = PFN_vkGetDeviceProcAddr(found);
    return PFN_vkVoidFunction(getDeviceProcAddr);
  }
  return wrapped(name, found);
}

PFN_vkVoidFunction Faults::find(VkDevice device, const char* name) {
  if (hidden.count(name + 2)) return nullptr;
  return wrapped(name, nextOfDevice(device, name));
}

void Faults::fail(const std::string& name, unsigned n, VkResult with, When how, bool on) {
  const std::lock_guard<std::mutex> lock(mutex);
  function = name;
  countdown = n;
  result = with;
  when = how;
  forever = on;
  failed = false;
}

void Faults::failNothing() {
  const std::lock_guard<std::mutex> lock(mutex);
  function = "";
  countdown = 0;
}

Faults::Failure Faults::called(const char* name) {
  const std::lock_guard<std::mutex> lock(mutex);
  counts[name]++;
  if (countdown == 0 || function != name) return {false, VK_SUCCESS, INSTEAD};
  if (countdown > 1) {
    countdown--;
    return {false, VK_SUCCESS, INSTEAD};
  }
  if (!forever) countdown = 0;
  failed = true;
  return {true, result, when};
}

void Faults::created(const char* kind, const void* handle) {
  const std::lock_guard<std::mutex> lock(mutex);
  objects[kind].insert(handle);
}

void Faults::destroyed(const char* kind, const void* handle) {
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = objects[kind].find(handle);
  if (found == objects[kind].end()) numStrangers++;
  else objects[kind].erase(found);
}

std::map<std::string, size_t> Faults::live() const {
  const std::lock_guard<std::mutex> lock(mutex);
  std::map<std::string, size_t> counted;
  for (const auto& kind : objects)
    if (!kind.second.empty()) counted[kind.first] = kind.second.size();
  return counted;
}

unsigned Faults::calls(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

} // namespace programs::test

extern "C" __attribute__((visibility("default"))) PFN_vkVoidFunction cbvhTestGetInstanceProcAddr(VkInstance instance,
                                                                                                 const char* name) {
  return programs::test::faults ? programs::test::faults->find(instance, name) : nullptr;
}
