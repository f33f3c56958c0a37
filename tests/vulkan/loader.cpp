// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A Vulkan loader for EMBREE_VULKAN_LOADER: returns the functions of the test program's Faults. */

#include <vulkan/vulkan_core.h>

#include <dlfcn.h>

extern "C" __attribute__((visibility("default"))) PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance,
                                                                                           const char* name) {
  const auto get = PFN_vkGetInstanceProcAddr(dlsym(RTLD_DEFAULT, "cbvhTestGetInstanceProcAddr"));
  return get ? get(instance, name) : nullptr;
}
