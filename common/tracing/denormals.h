// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace programs {

/* Sets the mode of the thread that constructs it, until destruction. */
class DenormalMode {
public:
  explicit DenormalMode(bool areZero) : saved(control()) { setControl(areZero ? saved | zeroBits : saved & ~zeroBits); }
  ~DenormalMode() { setControl(saved); }
  DenormalMode(const DenormalMode&) = delete;
  DenormalMode& operator=(const DenormalMode&) = delete;

private:
#if defined(__x86_64__)
  using Control = unsigned;
  static constexpr Control zeroBits = 1u << 15 | 1u << 6; // FTZ: results; DAZ: operands
  static Control control() { return _mm_getcsr(); }
  static void setControl(Control bits) { _mm_setcsr(bits); }
#elif defined(__aarch64__)
  using Control = uint64_t;
  static constexpr Control zeroBits = 1u << 24; // FZ: both
  static Control control() {
    Control bits;
    asm volatile("mrs %0, fpcr" : "=r"(bits));
    return bits;
  }
  static void setControl(Control bits) { asm volatile("msr fpcr, %0" : : "r"(bits)); }
#endif

  const Control saved;
};

/* Embree's manual recommends this for tracing. */
struct FlushDenormals : DenormalMode {
  FlushDenormals() : DenormalMode(true) {}
};

} // namespace programs
