// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Public structs that may grow (in include/cbvh and include/embree3). Each begins with size_t structSize, the
 * application's sizeof. Later versions append members at the previous sizeof; zero selects the previous behavior.
 * Structs that the library reads therefore have no padding at the end.
 *
 * The application's struct may be smaller than this version's: only structSize may be accessed directly.
 *
 * All functions throw RTC_ERROR_INVALID_ARGUMENT, naming the struct, if structSize is out of range or not a multiple of
 * sizeof(size_t). */

#include <cstddef>

namespace embree::core {
/*! firstSize: sizeof in the first version that has the struct. */
template<typename T> struct ExtensibleStruct;

/*! lastOfFirst: last member in the first version. Use in namespace embree::core. */
#define CBVH_EXTENSIBLE_STRUCT(T, lastOfFirst) \
  template<> struct ExtensibleStruct<T> { \
    static const char* name() { return #T; } \
    static const size_t end = offsetof(T, lastOfFirst) + sizeof(((T*)nullptr)->lastOfFirst); \
    static const size_t firstSize = (end + alignof(T) - 1) / alignof(T) * alignof(T); \
    static_assert(offsetof(T, structSize) == 0 && firstSize <= sizeof(T), "members are appended to structSize"); \
  }

/*! ExtensibleStruct at run time, for functions that are no templates. */
struct StructInfo {
  const char* name;
  size_t firstSize, size; //!< sizeof in the first version and in this one
};

/*! Upper bound of structSize. Larger values indicate uninitialized memory. */
const size_t maxStructSize = 4096;

/*! Implementations of requireStruct, readStruct and writeStruct. */
void checkStructSize(const StructInfo& info, const void* data);
void copyFromApplication(const StructInfo& info, const void* from, void* to);
void copyToApplication(const StructInfo& info, void* to, const void* from);

template<typename T>
StructInfo structInfo() {
  return StructInfo{ExtensibleStruct<T>::name(), ExtensibleStruct<T>::firstSize, sizeof(T)};
}

/*! Returns the application's struct as this version declares it: missing members are zero, structSize is sizeof(T).
 *  Also throws if a byte unknown to this version is not zero. */
template<typename T>
T readStruct(const T* from) {
  T to;
  copyFromApplication(structInfo<T>(), from, &to);
  return to;
}

/*! Call it before computing a result for writeStruct. */
template<typename T>
void requireStruct(const T* to) {
  checkStructSize(structInfo<T>(), to);
}

/*! Writes the members that the application's struct has, except structSize, and zeros its other bytes. */
template<typename T>
void writeStruct(T* to, const T& from) {
  copyToApplication(structInfo<T>(), to, &from);
}
} // namespace embree::core
