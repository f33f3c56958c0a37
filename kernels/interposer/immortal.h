// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <new>

namespace interposer {

/* Returns the only immortal object of type T. The first call creates it, because static initializers of other libraries
 * may call Embree before this library's initializers run. It needs no heap, and is never destroyed, because programs
 * call Embree until they end. Thread-safe. */
template<typename T>
T& immortal() {
  alignas(T) static char storage[sizeof(T)];
  static T& object = *new (storage) T;
  return object;
}

} // namespace interposer
