// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vulkan that fails when a test wants it to. All functions that the library calls are fetched
 * through a wrapper of vkGetInstanceProcAddr, which counts what is created and destroyed, makes a
 * chosen call fail, and changes what a device says of itself. There is one at a time. */

#include <vulkan/vulkan_core.h>

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace cbvh::test {

class Faults
{
public:
  explicit Faults(PFN_vkGetInstanceProcAddr next);
  ~Faults();
  Faults(const Faults&) = delete;
  Faults& operator=(const Faults&) = delete;

  // In place of `next`.
  PFN_vkGetInstanceProcAddr getInstanceProcAddr() const;

  // Functions that the library calls and that return a VkResult, without "vk", those of
  // instances and those of devices.
  static std::vector<std::string> fallible();

  // --- failing ---

  enum When
  {
    INSTEAD, // the function is not called
    BEHIND   // it is, and its result is lost: as when a device is lost while something waits for it
  };

  // The n-th call from now of a function fails, counted from 1; after it no other, or all.
  void fail(const std::string& function, unsigned n, VkResult result, When when = INSTEAD, bool forever = false);
  void failNothing();
  bool hasFailed() const { return failed; }

  // The driver does not have a function.
  void hide(const std::string& function) { hidden.insert(function); }
  void show(const std::string& function) { hidden.erase(function); }

  // --- changing what is said; behind the call ---

  std::function<void(VkPhysicalDeviceProperties&)> onProperties;
  std::function<void(VkPhysicalDeviceProperties2&)> onProperties2;
  std::function<void(VkPhysicalDeviceFeatures2&)> onFeatures;
  std::function<void(std::vector<VkExtensionProperties>&)> onExtensions;
  std::function<void(std::vector<VkPhysicalDevice>&)> onDevices;

  // before the call
  std::function<void(const VkMemoryAllocateInfo&)> onAllocation;

  // The device has memory of its own that the host does not see, and memory of the host, as most GPUs.
  bool isDiscrete = false;

  // around vkCreateInstance, and before vkDestroyInstance
  std::function<VkInstanceCreateInfo(const VkInstanceCreateInfo&)> onInstanceInfo;
  std::function<void(VkInstance)> onInstance, onInstanceEnd;

  // --- what was called ---

  // Live objects by kind, "buffer" for instance; kinds of which there are none are not listed.
  std::map<std::string, size_t> live() const;

  // Objects that were destroyed and did not live.
  size_t strangers() const { return numStrangers; }

  unsigned calls(const std::string& function) const;   // since the beginning
  VkDeviceSize lastAllocation() const { return allocated; }  // bytes asked for, also in vain
  size_t lastCache() const { return cacheBytes; }            // bytes that a pipeline cache was made from

  // --- of the wrapper ---

  struct Failure { bool now; VkResult result; When when; };
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

} // namespace cbvh::test

// For the loader of loader.cpp: vkGetInstanceProcAddr of the Faults there are.
extern "C" PFN_vkVoidFunction cbvhTestGetInstanceProcAddr(VkInstance instance, const char* name);
