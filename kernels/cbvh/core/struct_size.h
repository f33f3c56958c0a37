// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Public structs that may grow: the rule that include/cbvh/cbvh.h and include/embree3/rtcore_compression.h state. Each
 * of them begins with size_t structSize, the sizeof that the application was compiled with. Later versions append
 * members, for which zero means what the library did before, and begin them at the sizeof of the version before:
 * structs that the library reads have no padding at their end.
 *
 * An application's struct may be smaller than the type that this version declares. Functions therefore accept a pointer
 * to it, and their callers may access only its structSize directly.
 *
 * All functions throw RTC_ERROR_INVALID_ARGUMENT with the struct's name if structSize is out of range. */

#include <cstddef>

namespace embree
{
  namespace core
  {
    /*! Specialized by CBVH_GROWING_STRUCT: name(), and firstSize, the size of the struct in the first version that had
     *  it. */
    template<typename T> struct GrowingStruct;

    /*! Declares a struct that may grow. lastOfFirst: the last member in the first version. For use in namespace
     *  embree::core. */
#define CBVH_GROWING_STRUCT(T,lastOfFirst) \
    template<> struct GrowingStruct<T> \
    { \
      static const char* name () { return #T; } \
      static const size_t end = offsetof(T,lastOfFirst) + sizeof(((T*)nullptr)->lastOfFirst); \
      static const size_t firstSize = (end + alignof(T)-1)/alignof(T)*alignof(T); \
      static_assert(offsetof(T,structSize) == 0 && firstSize <= sizeof(T),"members are appended to structSize"); \
    }

    struct KnownStruct
    {
      const char* name;
      size_t firstSize, size;  //!< in the first version, and in this one
    };

    /*! A larger structSize is taken for memory that was not initialized. */
    const size_t maxStructSize = 1024;

    void checkStructSize (const KnownStruct& known, const void* data);
    void copyFromApplication (const KnownStruct& known, const void* from, void* to);
    void copyToApplication (const KnownStruct& known, void* to, const void* from);

    template<typename T>
    KnownStruct knownStruct () { return KnownStruct{ GrowingStruct<T>::name(),GrowingStruct<T>::firstSize,sizeof(T) }; }

    /*! Returns a struct that an application passed, as this version knows it: members that the application lacks are
     *  zero, structSize is sizeof(T). Also throws if a byte that this version does not know is not zero. */
    template<typename T>
    T readStruct (const T* from)
    {
      T to;
      copyFromApplication(knownStruct<T>(),from,&to);
      return to;
    }

    /*! Checks a struct that will be written. Call it before the work whose result it receives. */
    template<typename T>
    void requireStruct (const T* to) { checkStructSize(knownStruct<T>(),to); }

    /*! Writes the members that the application has, and zeros after the members that this version knows. Keeps
     *  structSize. */
    template<typename T>
    void writeStruct (T* to, const T& from) { copyToApplication(knownStruct<T>(),to,&from); }
  }
}
