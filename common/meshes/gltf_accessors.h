// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Accessors of glTF 2.0: strided, sparse and normalized arrays in buffers. */

#include "basics/vec.h"
#include "meshes/gltf_buffers.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace programs {

class GltfAccessors {
public:
  explicit GltfAccessors(GltfBuffers& buffers) : buffers(buffers) {}

  /* Values of accessors of `components` components each (1 to 4, or 16 for MAT4), one element after the other.
   * Normalized integers become 0 to 1 or -1 to 1. Throws Error for other types and for ranges beyond the buffers. */
  std::vector<double> numbers(size_t accessor, size_t components);

  /* Appends positions (VEC3). Returns their number. */
  size_t appendPositions(size_t accessor, std::vector<Vec3d>& positions);

  /* Unsigned integers (SCALAR). */
  std::vector<unsigned> indices(size_t accessor);

  size_t count(size_t accessor) const {
    return size_t(buffers.document().element("accessors", accessor).integer("count"));
  }

private:
  struct Array;
  Array open(const GltfValue& accessor, size_t components);
  Array openPart(const GltfValue& part, uint64_t componentType, uint64_t count, size_t components);

  /* Calls store(element, component, value) for all stored values, sparse ones last. Zeros are not stored. */
  template<typename Store>
  void visit(const GltfValue& accessor, const Array& array, size_t components, const Store& store);

  GltfBuffers& buffers;
};

} // namespace programs
