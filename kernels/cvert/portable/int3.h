// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Coordinates of vertices in a block: ivec3 in GLSL. Arithmetic is modulo 2^32, because coordinates of damaged blocks
 * may overflow. */

#ifndef CVERT_PORTABLE_INT3_H
#define CVERT_PORTABLE_INT3_H

#include "language.h"

#ifdef VULKAN

#define Int3 ivec3

#else

CVERT_BEGIN

struct Int3 {
  int x, y, z;

  CVERT_INLINE Int3() {}
  CVERT_INLINE explicit Int3(int a) : x(a), y(a), z(a) {}
  CVERT_INLINE Int3(int x, int y, int z) : x(x), y(y), z(z) {}
  CVERT_INLINE int operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }

  friend CVERT_INLINE Int3 operator+(const Int3& a, const Int3& b) {
    return Int3(int(uint32_t(a.x) + uint32_t(b.x)), int(uint32_t(a.y) + uint32_t(b.y)),
                int(uint32_t(a.z) + uint32_t(b.z)));
  }
  friend CVERT_INLINE Int3 operator-(const Int3& a, const Int3& b) {
    return Int3(int(uint32_t(a.x) - uint32_t(b.x)), int(uint32_t(a.y) - uint32_t(b.y)),
                int(uint32_t(a.z) - uint32_t(b.z)));
  }
  friend CVERT_INLINE Int3 operator+(const Int3& a, int b) { return a + Int3(b); }
  friend CVERT_INLINE Int3 operator*(int a, const Int3& b) {
    return Int3(int(uint32_t(a) * uint32_t(b.x)), int(uint32_t(a) * uint32_t(b.y)), int(uint32_t(a) * uint32_t(b.z)));
  }
  friend CVERT_INLINE Int3 operator>>(const Int3& a, int b) { return Int3(a.x >> b, a.y >> b, a.z >> b); }
};

CVERT_END

#endif

#endif
