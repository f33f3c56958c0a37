// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Macros for headers that compile as C++11 and as GLSL 4.60, so that CPUs and GPUs share the format and the hit rule.
 *
 * Shared code consists of free functions on plain values: no member functions, references or pointers (except in
 * bytes.h and int3.h), 64-bit integers or recursion. Braces initialize only constants.
 *
 * In C++, Real is a template parameter: float, double, or a vector type of Embree. In GLSL it is float.
 *
 *   CVERT_BEGIN, CVERT_END        around all shared code: namespaces in C++
 *   CVERT_FUNCTION                before a function
 *   CVERT_CONSTANT                before a constant
 *   CVERT_REAL                    before a function or struct that uses Real
 *   CVERT_OF(Type)                Type<Real>, a struct of CVERT_REAL
 *   CVERT_BOOL(Type)              result type of comparisons of Type: bool or a mask
 *   CVERT_AS_FLOAT(Function)      Function<float>, a function or struct of CVERT_REAL
 *   Wide                          a type in which products of two Reals are exact: double or a vector of doubles; float
 *                                 in shaders without CBVH_FLOAT64, which compute exact signs with integers
 *   CVERT_WIDE, CVERT_OF_WIDE     as CVERT_REAL and CVERT_OF, for Wide
 *   CVERT_INLINE                  CVERT_FUNCTION that C++ compilers must inline
 *   CVERT_LIKELY(condition)       hint that a condition is usually true */

#ifndef CVERT_PORTABLE_LANGUAGE_H
#define CVERT_PORTABLE_LANGUAGE_H

#ifdef VULKAN // glslc defines it

#define CVERT_BEGIN
#define CVERT_END
#define CVERT_FUNCTION
#define CVERT_CONSTANT const
#define CVERT_REAL
#define CVERT_OF(Type) Type
#define CVERT_BOOL(Type) bool
#define CVERT_AS_FLOAT(Function) Function
#define CVERT_INLINE
#define CVERT_LIKELY(condition) (condition)
#define CVERT_WIDE
#define CVERT_OF_WIDE(Type) Type
#define Real float
#define uint32_t uint
#ifdef CBVH_FLOAT64
#define Wide double
#else
#define Wide float
#endif

#else

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

/* One inline namespace per instruction set. In a common namespace, the linker would keep one copy of each inline
 * function, which might use AVX on machines without it. */
#if defined(CVERT_PORTABLE)
#define CVERT_ISA isa_portable
#elif defined(__AVX512F__)
#define CVERT_ISA isa_avx512
#elif defined(__AVX2__)
#define CVERT_ISA isa_avx2
#elif defined(__AVX__)
#define CVERT_ISA isa_avx
#elif defined(__SSE4_2__)
#define CVERT_ISA isa_sse42
#else
#define CVERT_ISA isa_lowest
#endif

// clang-format off
#define CVERT_BEGIN namespace cvert { inline namespace CVERT_ISA {
#define CVERT_END }}
// clang-format on
#define CVERT_FUNCTION inline
#define CVERT_CONSTANT static constexpr
#define CVERT_REAL template<typename Real>
#define CVERT_OF(Type) Type<Real>
#define CVERT_BOOL(Type) decltype(std::declval<Type>() < std::declval<Type>())
#define CVERT_AS_FLOAT(Function) Function<float>
#define CVERT_INLINE inline __attribute__((always_inline))
#define CVERT_LIKELY(condition) __builtin_expect(condition, 1)
#define CVERT_WIDE template<typename Wide>
#define CVERT_OF_WIDE(Type) Type<Wide>

#endif

CVERT_BEGIN

/* Instead of min and max, which C++ and GLSL define differently for NaN and equal operands. std::fmin and std::fmax can
 * be function calls. choose() is Embree's select(), by a name that hides none of Embree's overloads. */
CVERT_REAL CVERT_FUNCTION Real minimum(Real a, Real b) { return a < b ? a : b; }
CVERT_REAL CVERT_FUNCTION Real maximum(Real a, Real b) { return a > b ? a : b; }
CVERT_REAL CVERT_FUNCTION Real magnitude(Real a) { return a < Real(0) ? -a : a; }
CVERT_REAL CVERT_FUNCTION Real clampToUnit(Real a) { return a < Real(0) ? Real(0) : a > Real(1) ? Real(1) : a; }
CVERT_REAL CVERT_FUNCTION Real choose(bool condition, Real a, Real b) { return condition ? a : b; }

/* nonZero: a divisor, or NaN if it is 0. A quotient by 0 that is not used, or that may be NaN instead of infinite,
 * must be divided by nonZero(): programs may trap divisions by zero, as Embree's device setting float_exceptions does.
 * NaN raises no exception. */

/* both, either: logical operators, also for masks.
 * product: never fused with a sum into one instruction, which would round differently. */
#ifdef VULKAN
bool both(bool a, bool b) { return a && b; }
bool either(bool a, bool b) { return a || b; }
float squareRoot(float a) { return sqrt(a); }
float floatOfBits(uint bits) { return uintBitsToFloat(bits); }
uint bitsOfFloat(float f) { return floatBitsToUint(f); }
float product(float a, float b) {
  precise float p = a * b;
  return p;
}
float nonZero(float a) { return a; } // shaders do not trap
const float infinity = 1.0 / 0.0;
#ifdef CBVH_FLOAT64
double minimum(double a, double b) { return a < b ? a : b; }
double maximum(double a, double b) { return a > b ? a : b; }
double magnitude(double a) { return a < 0.0 ? -a : a; }
double product(double a, double b) {
  precise double p = a * b;
  return p;
}
double nonZero(double a) { return a; }
#endif
#else
template<typename Bool> CVERT_INLINE Bool both(Bool a, Bool b) { return a & b; }
template<typename Bool> CVERT_INLINE Bool either(Bool a, Bool b) { return a | b; }
inline float magnitude(float a) { return std::fabs(a); }
inline double magnitude(double a) { return std::fabs(a); }
CVERT_REAL inline Real squareRoot(Real a) { return std::sqrt(a); }
inline float floatOfBits(uint32_t bits) {
  float f;
  std::memcpy(&f, &bits, sizeof(f));
  return f;
}
inline uint32_t bitsOfFloat(float f) {
  uint32_t bits;
  std::memcpy(&bits, &f, sizeof(f));
  return bits;
}
static constexpr float infinity = std::numeric_limits<float>::infinity();
CVERT_REAL CVERT_INLINE Real nonZero(Real a) {
  return choose(a == Real(0.0f), Real(std::numeric_limits<float>::quiet_NaN()), a);
}
/* Hides from the compiler that p is a product, so that it cannot fuse it with a sum. The option -ffp-contract=off would
 * apply to the whole file: in files that trace rays, cGRID's leaves must fuse products exactly as GRID does. */
template<typename Scalar>
CVERT_INLINE Scalar unfused(Scalar p) {
#if defined(__GNUC__) && defined(__SSE2__)
  asm("" : "+x"(p));
#elif defined(__GNUC__) && defined(__aarch64__)
  asm("" : "+w"(p));
#endif // elsewhere: -ffp-contract=off, cvert/CMakeLists.txt
  return p;
}
CVERT_INLINE float product(float a, float b) { return unfused(a * b); }
CVERT_INLINE double product(double a, double b) { return unfused(a * b); }
#endif

/*! 2^-23, the largest distance between neighboring normal floats, relative to their magnitude. */
CVERT_CONSTANT float floatUlp = 1.1920929e-7f;

CVERT_END

#endif
