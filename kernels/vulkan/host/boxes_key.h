// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <vector>
#include <vulkan/vulkan_core.h>

namespace embree::vulkan {

/* Identifies a bottom level by its boxes. The hash only makes comparisons fast: if hashes are equal, the bytes of the
 * boxes decide, because rays would miss leaves in a structure over other boxes. Costs 24 bytes of memory per box. */
class BoxesKey {
public:
  explicit BoxesKey(std::vector<VkAabbPositionsKHR> boxes);

  bool operator==(const BoxesKey& other) const;

  const std::vector<VkAabbPositionsKHR>& boxes() const { return *shared; }
  uint64_t hash() const { return hashOfBoxes; }

private:
  std::shared_ptr<const std::vector<VkAabbPositionsKHR>> shared; // by copies of the key
  uint64_t hashOfBoxes;
};

struct HashOfKey {
  size_t operator()(const BoxesKey& key) const { return size_t(key.hash()); }
};

} // namespace embree::vulkan
