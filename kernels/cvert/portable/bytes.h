// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Memory access in code shared by C++ and GLSL. Addresses are pointers in C++, and buffer addresses (two words, lower
 * half first) in GLSL.
 *
 *   CVERT_POINTER(Type)       address of a struct, or of any bytes if Type is void
 *   CVERT_AS(Type,address)    converts an address to the address of a struct
 *   CVERT_AT(Type,address)    the struct at an address, read-only
 *   CVERT_READABLE(Type,A)    after a struct: enables CVERT_AT in GLSL, for addresses that are multiples of A bytes
 *   CVERT_IN(Type)            type of a read-only parameter that is too large to copy
 *   CVERT_PRECISE             before a local float: GLSL neither reorders nor fuses its operations */

#ifndef CVERT_PORTABLE_BYTES_H
#define CVERT_PORTABLE_BYTES_H

#include "language.h"

#ifdef VULKAN

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

#define CVERT_POINTER(Type) uvec2
#define CVERT_AS(Type, address) (address)
#define CVERT_AT(Type, address) Type##At(address).it
#define CVERT_READABLE(Type, alignment) \
  layout(buffer_reference, scalar, buffer_reference_align = alignment) readonly buffer Type##At { Type it; };
#define CVERT_IN(Type) Type
#define CVERT_PRECISE precise

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WordsAt { uint it[]; };

uint wordAt(uvec2 at, uint i) { return WordsAt(at).it[i]; }
uint byteAt(uvec2 at, uint offset) { return (wordAt(at, offset >> 2) >> (8u * (offset & 3u))) & 255u; }
uint uint16At(uvec2 at, uint offset) { return (wordAt(at, offset >> 2) >> (8u * (offset & 2u))) & 65535u; }

uint bitsAt(uvec2 at, uint bit, uint count) {
  uint i = bit >> 5, shift = bit & 31u;
  uint low = wordAt(at, i) >> shift;
  return shift == 0u ? low : low | (wordAt(at, i + 1u) << (32u - shift));
}

uvec2 bytesAfter(uvec2 at, uint offset) {
  uint carry;
  at.x = uaddCarry(at.x, offset, carry);
  at.y += carry;
  return at;
}

#else

#define CVERT_POINTER(Type) const Type*
#define CVERT_AS(Type, address) ((const Type*)(address))
#define CVERT_AT(Type, address) (*CVERT_AS(Type, address))
#define CVERT_READABLE(Type, alignment)
#define CVERT_IN(Type) const Type&
#define CVERT_PRECISE

CVERT_BEGIN

/*! Returns the i-th 32-bit word. In GLSL, `at` must be a multiple of 4, here and below. */
CVERT_INLINE uint32_t wordAt(const void* at, uint32_t i) {
  uint32_t word;
  std::memcpy(&word, (const uint8_t*)at + 4 * i, sizeof(word));
  return word;
}

CVERT_INLINE uint32_t byteAt(const void* at, uint32_t offset) { return ((const uint8_t*)at)[offset]; }

/*! Returns 16 bits. The offset, in bytes, must be even. */
CVERT_INLINE uint32_t uint16At(const void* at, uint32_t offset) {
  uint16_t half;
  std::memcpy(&half, (const uint8_t*)at + offset, sizeof(half));
  return half;
}

/*! Returns `count` bits (at most 32) from bit `bit` on. Higher bits of the result are undefined. C++ reads no byte
 *  after the last bit; GLSL may also read the next word. */
inline uint32_t bitsAt(const void* at, uint32_t bit, uint32_t count) {
  const uint8_t* const first = (const uint8_t*)at + (bit >> 3);
  const uint32_t shift = bit & 7u, bytes = (shift + count + 7u) >> 3;
  uint64_t bits = 0;
  for (uint32_t i = 0; i < bytes; i++) bits |= uint64_t(first[i]) << (8u * i);
  return uint32_t(bits >> shift);
}

CVERT_INLINE const uint8_t* bytesAfter(const void* at, uint32_t offset) { return (const uint8_t*)at + offset; }

CVERT_END

#endif

CVERT_BEGIN

/*! Reinterprets the i-th 32-bit word as a float. */
CVERT_FUNCTION float floatAt(CVERT_POINTER(void) at, uint32_t i) { return floatOfBits(wordAt(at, i)); }

CVERT_END

#endif
