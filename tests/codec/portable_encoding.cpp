// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// The encoder in plain C++, as on machines without SSE; for portable_bytes.cpp.

#define CVERT_PORTABLE
#define HERE portable
#include "encode_here.h"

namespace programs::test {

std::vector<uint8_t> encodePortably(const std::vector<std::vector<float>>& steps, uint32_t width, uint32_t height,
                                    int exponent) {
  return portable::encode(steps, width, height, exponent);
}

} // namespace programs::test
