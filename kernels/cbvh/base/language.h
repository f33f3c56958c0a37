// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What lets the headers of this folder compile as C++11 and as GLSL 4.60: they are the
 * one description of the format and of the hit rule, for the CPU's scalar path, for the
 * SIMD path as far as it is scalar, for the tests, and for shaders.
 *
 * Shared code is free functions on plain values. It has no references and pointers, no
 * member functions, no 64-bit integers, no doubles, no recursion, and no braces around
 * values but in the initializers of constants.
 *
 * Quantities whose precision the user chooses are of type Real: CBVH_REAL comes before
 * a function or a struct of such, CBVH_OF(Type) names a struct of the same precision.
 * In GLSL Real is float; in C++ it is float, double (the scalar path) or, in some
 * functions, a vector of Embree. */

#ifndef CBVH_LANGUAGE_H
#define CBVH_LANGUAGE_H

#ifdef VULKAN // as glslc defines it

#define CBVH_BEGIN
#define CBVH_END
#define CBVH_FUNCTION
#define CBVH_CONSTANT const
#define CBVH_REAL
#define CBVH_OF(Type) Type
#define Real float
#define uint32_t uint

#else

#include "isa_namespace.h"
#include <cmath>
#include <cstdint>
#include <cstring>

#define CBVH_BEGIN namespace embree { namespace cbvh { inline namespace CBVH_ISA {
#define CBVH_END }}}
#define CBVH_FUNCTION inline
#define CBVH_CONSTANT static constexpr
#define CBVH_REAL template<typename Real>
#define CBVH_OF(Type) Type<Real>

#endif

CBVH_BEGIN

/* Not by the names of the standard library or of GLSL: NaN and equal operands are the same
 * everywhere, and in C++ no call is made. */
CBVH_REAL CBVH_FUNCTION Real lesser (Real a, Real b) { return a < b ? a : b; }
CBVH_REAL CBVH_FUNCTION Real greater (Real a, Real b) { return a > b ? a : b; }
CBVH_REAL CBVH_FUNCTION Real magnitude (Real a) { return a < Real(0) ? -a : a; }
CBVH_REAL CBVH_FUNCTION Real clampToUnit (Real a) { return a < Real(0) ? Real(0) : a > Real(1) ? Real(1) : a; }
#ifdef VULKAN
float squareRoot (float a) { return sqrt(a); }
float floatOfBits (uint bits) { return uintBitsToFloat(bits); }
#else
CBVH_REAL inline Real squareRoot (Real a) { return std::sqrt(a); }
inline float floatOfBits (uint32_t bits) { float f; std::memcpy(&f,&bits,sizeof(f)); return f; }
#endif

/*! relative spacing of floats */
CBVH_CONSTANT float floatUlp = 1.1920929e-7f;

CBVH_END

#endif
