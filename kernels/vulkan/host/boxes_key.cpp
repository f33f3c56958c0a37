// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "boxes_key.h"

#include <cstring>
#include <utility>

namespace embree::vulkan {

BoxesKey::BoxesKey(std::vector<VkAabbPositionsKHR> boxes)
  : shared(std::make_shared<const std::vector<VkAabbPositionsKHR>>(std::move(boxes))),
    hashOfBoxes(0xcbf29ce484222325) {
  for (const VkAabbPositionsKHR& box : *shared) {
    uint32_t words[6];
    std::memcpy(words, &box, sizeof(words));
    for (uint32_t word : words) hashOfBoxes = (hashOfBoxes ^ word) * 0x100000001b3;
  }
}

bool BoxesKey::operator==(const BoxesKey& other) const {
  if (shared == other.shared) return true;
  return hashOfBoxes == other.hashOfBoxes && shared->size() == other.shared->size() &&
         std::memcmp(shared->data(), other.shared->data(), shared->size() * sizeof(VkAabbPositionsKHR)) == 0;
}

} // namespace embree::vulkan
