// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* cvert/portable/language.h for Embree's vectors, so that shared code supports vectors of rays or quads. Products are
 * fused exactly where the code says so, because compilers could fuse differently in different places. */

#include "codec_names.h"
#include "intrinsics.h"
#include "../../cvert/rule/reciprocal.h"
#include "../embree/simd.h"

namespace embree {
template<int N>
__forceinline vfloat_impl<N> minimum(const vfloat_impl<N>& a, const vfloat_impl<N>& b) {
  return min(a, b);
}
template<int N>
__forceinline vfloat_impl<N> maximum(const vfloat_impl<N>& a, const vfloat_impl<N>& b) {
  return max(a, b);
}
template<int N> __forceinline vfloat_impl<N> magnitude(const vfloat_impl<N>& a) { return abs(a); }
template<int N>
__forceinline vfloat_impl<N> choose(const vboolf_impl<N>& condition, const vfloat_impl<N>& a, const vfloat_impl<N>& b) {
  return select(condition, a, b);
}
/*! a b, rounded: the empty assembly prevents fusing with a later sum. */
template<int N> __forceinline vfloat_impl<N> product(const vfloat_impl<N>& a, const vfloat_impl<N>& b) {
  vfloat_impl<N> p = a * b;
#if defined(__GNUC__) && defined(__AVX512F__)
  asm("" : "+v"(p.v));
#elif defined(__GNUC__) && defined(__x86_64__)
  asm("" : "+x"(p.v));
#endif // elsewhere: -ffp-contract=off, kernels/upstream/arm64.cmake
  return p;
}

namespace isa::cbvh {
using namespace embree::cbvh;

#if defined(__AVX512F__)
static const int vectorWidth = 16;
#elif defined(__AVX__)
static const int vectorWidth = 8;
#else
static const int vectorWidth = 4;
#endif
typedef vfloat<vectorWidth> vfloatV;
typedef vint<vectorWidth> vintV;
typedef vboolf<vectorWidth> vboolV;

/*! Lane i of v in all lanes. */
template<int i>
__forceinline vfloatV broadcast(const vfloat4& v) {
#if defined(__AVX512F__)
  return _mm512_broadcastss_ps(shuffle<i>(v));
#elif defined(__AVX__)
  return vfloatV(shuffle<i>(v));
#else
  return shuffle<i>(v);
#endif
}

/*! Loads a byte per lane, and no further bytes. */
__forceinline vintV loadBytes(const uint8_t* p) {
#if defined(__AVX512F__)
  return vintV(_mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i*)p)));
#elif defined(__AVX2__)
  return vintV(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)p)));
#elif defined(__AVX__)
  return vintV(vint4(extend8(loadFour(p))), vint4(extend8(loadFour(p + 4))));
#else
  return vintV(extend8(loadFour(p)));
#endif
}

/*! Replaces the fourth lane, which is not used, by the first: it might contain 0 or a denormal number, for which
 *  programs may trap. */
__forceinline vfloat4 withoutFourth(const vfloat4& v) { return shuffle<0, 1, 2, 0>(v); }

/*! x, y, z and z of an origin or direction at the beginning of a query, by loads of 4 bytes: the application has often
 *  just stored floats, and a load of 16 bytes would wait until they have reached the cache. */
__forceinline vfloat4 loadOfRay(const float* v) {
  const __m128 xy = _mm_unpacklo_ps(_mm_load_ss(v), _mm_load_ss(v + 1)), z = _mm_load_ss(v + 2);
  return _mm_shuffle_ps(xy, z, _MM_SHUFFLE(0, 0, 1, 0));
}

/*! cvert's directionReciprocal of three components. The fourth lane must contain one of them, see withoutFourth.
 *  If all magnitudes are 1e-9 to 1e9, clamping would change a component by at most an ulp, so it is skipped. */
__forceinline vfloat4 directionReciprocals(const vfloat4& d) {
  const vfloat4 size = abs(d);
  if (likely(all((size >= vfloat4(1e-9f)) & (size <= vfloat4(1e9f))))) return vfloat4(1.0f) / d;
  return directionReciprocal(d, max(max(shuffle<0>(size), shuffle<1>(size)), shuffle<2>(size)));
}

/*! a b + c and c - a b, fused where supported. Embree's madd of floats would clear the rest of a vector first. */
__forceinline float fused(float a, float b, float c) {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return __builtin_fmaf(a, b, c);
#else
  return product(a, b) + c;
#endif
}
__forceinline float fusedNegative(float a, float b, float c) { return fused(-a, b, c); }
template<typename Vector>
__forceinline Vector fused(const Vector& a, const Vector& b, const Vector& c) {
  return madd(a, b, c);
}
template<typename Vector>
__forceinline Vector fusedNegative(const Vector& a, const Vector& b, const Vector& c) {
  return nmadd(a, b, c);
}
} // namespace isa::cbvh
} // namespace embree
