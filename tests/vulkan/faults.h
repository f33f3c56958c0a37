// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan that fails on request: a wrapper of vkGetInstanceProcAddr counts objects, makes a chosen call fail, and
 * changes properties of devices. Only one object may exist at a time. */

#include <vulkan/vulkan_core.h>

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace programs::test {

class Faults {
public:
  explicit Faults(PFN_vkGetInstanceProcAddr next);
  ~Faults();
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;

  // Replaces `next`.
  PFN_vkGetInstanceProcAddr getInstanceProcAddr() const;

  // Names, without "vk", of functions of instances and devices that the library calls and that return a VkResult.
  static std::vector<std::string> fallible();

  // --- failures ---

  enum When {
    INSTEAD, // the function is not called
    AFTER    // the function is called, but its result is replaced, as if a device is lost during a wait
  };

  // Makes the n-th call of a function from now on fail, counted from 1; only this call, or all later ones too.
  void fail(const std::string& function, unsigned n, VkResult result, When when = INSTEAD, bool forever = false);
  void failNothing();
  bool hasFailed() const { return failed; }

  // Hides a function, as if the driver did not provide it.
  void hide(const std::string& function) { hidden.insert(function); }
  void show(const std::string& function) { hidden.erase(function); }

  // --- modified results, after the call ---

  std::function<void(VkPhysicalDeviceProperties&)> onProperties;
  std::function<void(VkPhysicalDeviceProperties2&)> onProperties2;
  std::function<void(VkPhysicalDeviceFeatures2&)> onFeatures;
  std::function<void(std::vector<VkExtensionProperties>&)> onExtensions;
  std::function<void(std::vector<VkPhysicalDevice>&)> onDevices;

  // before the call
  std::function<void(const VkMemoryAllocateInfo&)> onAllocation;
  std::function<void(const VkMemoryBarrier&, VkPipelineStageFlags to)> onBarrier;

  // The device has memory that is not visible to the host, and host memory, like most GPUs.
  bool isDiscrete = false;

  // before vkCreateInstance, after it, and before vkDestroyInstance
  std::function<VkInstanceCreateInfo(const VkInstanceCreateInfo&)> onInstanceInfo;
  std::function<void(VkInstance)> onInstance, onInstanceEnd;

  // --- counters ---

  // Live objects by kind, for example "buffer". Kinds without objects are not listed.
  std::map<std::string, size_t> live() const;

  // Number of destroyed handles that were not live.
  size_t strangers() const { return numStrangers; }

  unsigned calls(const std::string& function) const;        // since the beginning
  VkDeviceSize lastAllocation() const { return allocated; } // requested bytes, including failed requests
  size_t lastCache() const { return cacheBytes; }           // size of the data from which a pipeline cache was created

  // --- used by the wrapper ---

  struct Failure {
    bool now;
    VkResult result;
    When when;
  };
  Failure called(const char* function);
  void created(const char* kind, const void* handle);
  void destroyed(const char* kind, const void* handle);
  void asked(VkDeviceSize bytes) { allocated = bytes; }
  void askedCache(size_t bytes) { cacheBytes = bytes; }
  PFN_vkVoidFunction find(VkInstance instance, const char* name);
  PFN_vkVoidFunction find(VkDevice device, const char* name);

private:
  mutable std::mutex mutex;
  const PFN_vkGetInstanceProcAddr next;
  PFN_vkGetDeviceProcAddr nextOfDevice = nullptr;
  std::set<std::string> hidden;
  std::map<std::string, unsigned> counts;
  std::map<std::string, std::multiset<const void*>> objects;
  std::string function;
  unsigned countdown = 0;
  VkResult result = VK_SUCCESS;
  When when = INSTEAD;
  bool forever = false, failed = false;
  size_t numStrangers = 0;
  VkDeviceSize allocated = 0;
  size_t cacheBytes = 0;
};

} // namespace programs::test

// For the loader of loader.cpp: vkGetInstanceProcAddr of the current Faults.
extern "C" PFN_vkVoidFunction cbvhTestGetInstanceProcAddr(VkInstance instance, const char* name);
