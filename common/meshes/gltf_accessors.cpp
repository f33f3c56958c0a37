// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/gltf_accessors.h"
#include "basics/progress.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace programs {
namespace {

enum ComponentType : uint64_t { Byte = 5120, UByte = 5121, Short = 5122, UShort = 5123, UInt = 5125, Float = 5126 };

size_t bytesOf(uint64_t type) {
  switch (type) {
  case Byte:
  case UByte: return 1;
  case Short:
  case UShort: return 2;
  case UInt:
  case Float: return 4;
  default: return 0;
  }
}

template<typename T>
T littleEndianValue(const uint8_t* bytes) {
  T value; // the processors that Embree supports are little endian
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

uint32_t unsignedValue(uint64_t type, const uint8_t* bytes) {
  if (type == UByte) return *bytes;
  return type == UShort ? littleEndianValue<uint16_t>(bytes) : littleEndianValue<uint32_t>(bytes);
}

double numberOf(uint64_t type, bool isNormalized, const uint8_t* bytes) {
  switch (type) {
  case Byte: {
    const double value = littleEndianValue<int8_t>(bytes);
    return isNormalized ? std::max(value / 127, -1.0) : value;
  }
  case UByte: return isNormalized ? *bytes / 255.0 : *bytes;
  case Short: {
    const double value = littleEndianValue<int16_t>(bytes);
    return isNormalized ? std::max(value / 32767, -1.0) : value;
  }
  case UShort: {
    const double value = littleEndianValue<uint16_t>(bytes);
    return isNormalized ? value / 65535 : value;
  }
  case UInt: return littleEndianValue<uint32_t>(bytes);
  default: return double(littleEndianValue<float>(bytes));
  }
}

} // namespace

struct GltfAccessors::Array {
  uint64_t componentType = 0, count = 0;
  const uint8_t* data = nullptr; // null: zeros
  size_t stride = 0, componentBytes = 0;

  const uint8_t* at(uint64_t element, size_t component) const {
    return data + element * stride + component * componentBytes;
  }
};

/* Requires that the elements are inside of the buffer view that `part` names. */
GltfAccessors::Array GltfAccessors::openPart(const GltfValue& part, uint64_t componentType, uint64_t count,
                                             size_t components) {
  const size_t bytes = bytesOf(componentType) * components;
  if (bytes == 0) part.fail("has the component type " + std::to_string(componentType) + ": expected 5120 to 5126");
  const GltfBytes view = buffers.view(size_t(part.integer("bufferView")));
  const uint64_t offset = part.integer("byteOffset", 0);
  const size_t stride = view.stride == 0 ? bytes : size_t(view.stride);
  if (stride < bytes || stride > 252)
    part.fail("has elements of " + std::to_string(bytes) + " bytes, " + std::to_string(stride) + " bytes apart");
  if (count > 0 &&
      (offset > view.size || view.size - offset < bytes || (view.size - offset - bytes) / stride < count - 1))
    part.fail("has " + std::to_string(count) + " elements of " + std::to_string(bytes) +
              " bytes: the buffer view has " + std::to_string(view.size) + " bytes");
  return {componentType, count, view.data + offset, stride, bytesOf(componentType)};
}

GltfAccessors::Array GltfAccessors::open(const GltfValue& accessor, size_t components) {
  const char* const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const std::string expected = components == 16 ? "MAT4" : types[components];
  const std::string type = accessor.member("type").text();
  if (type != expected) accessor.fail("has the type " + quotedWord(type) + ": expected " + expected);
  const uint64_t componentType = accessor.integer("componentType"), count = accessor.integer("count");
  if (accessor.has("bufferView")) return openPart(accessor, componentType, count, components);
  if (!accessor.has("sparse")) accessor.fail("has no data: expected 'bufferView' or 'sparse'");
  if (count > buffers.fileSize()) // a small file must not allocate much
    accessor.fail("has " + std::to_string(count) +
                  " elements without 'bufferView': expected at most one per byte of "
                  "the file");
  return {componentType, count, nullptr, 0, 0};
}

template<typename Store>
void GltfAccessors::visit(const GltfValue& accessor, const Array& array, size_t components, const Store& store) {
  for (uint64_t i = 0; array.data && i < array.count; i++) {
    if (i % 65536 == 0) throwIfCanceled();
    for (size_t c = 0; c < components; c++) store(i, c, array.at(i, c));
  }
  if (!accessor.has("sparse")) return;
  const GltfValue sparse = accessor.member("sparse");
  const GltfValue places = sparse.member("indices");
  const uint64_t count = sparse.integer("count"), type = places.integer("componentType");
  if (type != UByte && type != UShort && type != UInt) places.fail("has no unsigned integers");
  const Array indices = openPart(places, type, count, 1);
  const Array values = openPart(sparse.member("values"), array.componentType, count, components);
  for (uint64_t i = 0; i < count; i++) {
    const uint32_t element = unsignedValue(type, indices.at(i, 0));
    if (element >= array.count)
      places.fail("has the index " + std::to_string(element) + ": expected 0 to " + std::to_string(array.count - 1));
    for (size_t c = 0; c < components; c++) store(element, c, values.at(i, c));
  }
}

std::vector<double> GltfAccessors::numbers(size_t index, size_t components) {
  const GltfValue accessor = buffers.document().element("accessors", index);
  const Array array = open(accessor, components);
  const bool isNormalized = accessor.flag("normalized");
  std::vector<double> values(array.count * components);
  visit(accessor, array, components, [&](uint64_t i, size_t c, const uint8_t* bytes) {
    values[i * components + c] = numberOf(array.componentType, isNormalized, bytes);
  });
  return values;
}

size_t GltfAccessors::appendPositions(size_t index, std::vector<Vec3d>& positions) {
  const GltfValue accessor = buffers.document().element("accessors", index);
  const Array array = open(accessor, 3);
  const bool isNormalized = accessor.flag("normalized");
  if (array.componentType == UInt)
    accessor.fail("has positions of the component type 5125: expected 5120 to 5123 or 5126");
  const size_t first = positions.size();
  positions.resize(first + array.count);
  visit(accessor, array, 3, [&](uint64_t i, size_t c, const uint8_t* bytes) {
    Vec3d& p = positions[first + i];
    (c == 0 ? p.x : c == 1 ? p.y : p.z) = numberOf(array.componentType, isNormalized, bytes);
  });
  return array.count;
}

std::vector<unsigned> GltfAccessors::indices(size_t index) {
  const GltfValue accessor = buffers.document().element("accessors", index);
  const Array array = open(accessor, 1);
  const uint64_t type = array.componentType;
  if (type != UByte && type != UShort && type != UInt)
    accessor.fail("has indices of the component type " + std::to_string(type) + ": expected 5121, 5123 or 5125");
  std::vector<unsigned> values(array.count);
  visit(accessor, array, 1, [&](uint64_t i, size_t, const uint8_t* bytes) { values[i] = unsignedValue(type, bytes); });
  return values;
}

} // namespace programs
