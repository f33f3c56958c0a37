// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices as D3D12_VERTEX_FORMAT_COMPRESSED1, DirectX's input format for builds from clusters of triangles on GPUs: a
 * header of 12 bytes, then offsets from its anchor without gaps. docs/formats/clusters.md lists the bits.
 *
 * Based on: DirectX Raytracing Functional Spec, Part 2, v0.28, "Compressed1 position encoding", Microsoft 2026. For the
 * largest spacing, 2^105, the specification requires anchor plus offset within +-8,388,607. This always holds, because
 * vertices are finite floats and 8,388,608 * 2^105 = 2^128 is not. */

#include "lattice_points.h"

namespace cvert {
/*! Writes `count` vertices and returns their size in bytes, a multiple of 4. span: bounds of these vertices; fits()
 *  must be true. order: their indices in `points`. out: at least maxCompressed1Bytes(count) bytes, all 0. */
inline size_t writeCompressed1(const LatticePoints& points, const LatticeSpan& span, const uint32_t* order,
                               uint32_t count, uint8_t* out) {
  const uint32_t bits[3] = {span.bits(0), span.bits(1), span.bits(2)};
  writeWord(out, points.exponent | uint32_t(span.lower[0]) << 8);
  writeWord(out + 4, (bits[0] - 1) | (bits[1] - 1) << 4 | uint32_t(span.lower[1]) << 8);
  writeWord(out + 8, (bits[2] - 1) | uint32_t(span.lower[2]) << 8);
  size_t position = 8 * 12;
  for (uint32_t i = 0; i < count; i++)
    for (int k = 0; k < 3; k++) {
      writeBits(out, position, bits[k], uint32_t(points.at[order[i]][k] - span.lower[k]));
      position += bits[k];
    }
  return (position + 31) / 32 * 4;
}

/*! Bound of the size of `count` vertices: header, 3 x 16 bits per vertex, padding. */
constexpr size_t maxCompressed1Bytes(size_t count) { return 12 + 6 * count + 4; }
} // namespace cvert
