// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "meshes/input_bytes.h"

#include <cstdint>
#include <string>
#include <vector>

namespace programs {

enum class PlyFormat { Ascii, LittleEndian, BigEndian };
enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

constexpr bool isInteger(PlyType type) { return type < PlyType::Float32; }

constexpr unsigned sizeOf(PlyType type) {
  constexpr unsigned sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[int(type)];
}

struct PlyProperty {
  std::string name;
  PlyType type; // of the value, or of the items of a list
  bool isList = false;
  PlyType countType = PlyType::UInt8; // of a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /* Index of the property, or -1. */
  int find(const char* property) const;

  /* Least number of bytes of one element. */
  size_t leastBytes(PlyFormat format) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::Ascii;
  std::vector<PlyElement> elements; // with different names
  std::string comments;             // one per line
};

/* Reads the header, whose lines end as its first line does. Throws Error with path and line. */
PlyHeader readPlyHeader(InputBytes& input);

} // namespace programs
