// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "struct_size.h"
#include "errors.h"
#include <algorithm>
#include <cstring>

namespace embree::core {
namespace {
size_t structSizeOf(const void* data) {
  size_t size;
  std::memcpy(&size, data, sizeof(size));
  return size;
}
} // namespace

void checkStructSize(const StructInfo& info, const void* data) {
  const size_t size = structSizeOf(data);
  const bool isAligned = size % alignof(size_t) == 0; // as sizeof of every struct with a size_t
  if (size < info.firstSize || size > maxStructSize || !isAligned)
    throwInvalidArgument(std::string(info.name) + ": invalid structSize " + std::to_string(size) +
                         ": expected sizeof(struct " + info.name + "), which is " + std::to_string(info.size) +
                         " in this version and at least " + std::to_string(info.firstSize));
}

void copyFromApplication(const StructInfo& info, const void* from, void* to) {
  checkStructSize(info, from);
  const size_t size = structSizeOf(from), common = std::min(size, info.size);
  const char* const bytes = (const char*)from;
  const char* const nonzero = std::find_if(bytes + common, bytes + size, [](char byte) { return byte != 0; });
  if (nonzero != bytes + size)
    throwInvalidArgument(std::string(info.name) + ": structSize is " + std::to_string(size) + ", and byte " +
                         std::to_string(nonzero - bytes) + " is not zero: expected zeros after the " +
                         std::to_string(info.size) + " bytes that this version of the library knows");
  std::memcpy(to, from, common);
  std::memset((char*)to + common, 0, info.size - common);
  std::memcpy(to, &info.size, sizeof(size_t));
}

void copyToApplication(const StructInfo& info, void* to, const void* from) {
  checkStructSize(info, to);
  const size_t size = structSizeOf(to), common = std::min(size, info.size);
  std::memcpy((char*)to + sizeof(size_t), (const char*)from + sizeof(size_t), common - sizeof(size_t));
  std::memset((char*)to + common, 0, size - common);
}
} // namespace embree::core
