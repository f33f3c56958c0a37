// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>

namespace embree::cbvh {
/*! Resizes an empty vector without unused capacity; Embree's vectors grow to powers of two. */
template<typename Vector>
void resizeToFit(Vector& vector, size_t size) {
  vector.reserve(size);
  vector.resize(size);
}
} // namespace embree::cbvh
