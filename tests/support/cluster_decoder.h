// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoders of clusters, written bit by bit from the public specifications only, without code of the kernels:
 *
 * - COMPRESSED1: DirectX Raytracing Functional Spec, Part 2, v0.19, "Compressed1 position encoding"; from v0.28 on
 *   vertices are finite: with exponent 232, anchor plus offset lies within +-8,388,607
 * - DGF1: the Vulkan specification, VK_AMDX_dense_geometry_format, "Dense Geometry Format Version 1"
 *
 * They throw if a rule of the specification is violated, and for micromaps, palettes of geometries and user data. */

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace programs::test {

struct DecodedCluster {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<unsigned, 3>> triangles;
  unsigned primitives = 0; // index of the first triangle (DGF)
  size_t numIndices = 0;
  unsigned bitsPerIndex = 0;
};

class BitReader {
public:
  BitReader(const void* data, size_t bytes) : data((const uint8_t*)data), bytes(bytes) {}

  uint32_t read(size_t position, unsigned count) const {
    uint32_t value = 0;
    for (unsigned i = 0; i < count; i++) {
      if ((position + i) / 8 >= bytes) throw std::runtime_error("a field is past the end");
      value |= uint32_t(data[(position + i) / 8] >> (position + i) % 8 & 1) << i;
    }
    return value;
  }

  // in two's complement
  int32_t readSigned(size_t position, unsigned count) const {
    const uint32_t value = read(position, count);
    return value >> (count - 1) ? int32_t(value) - (1 << count) : int32_t(value);
  }

private:
  const uint8_t* const data;
  const size_t bytes;
};

inline void demand(bool holds, const char* rule) {
  if (!holds) throw std::runtime_error(rule);
}

// The common part of COMPRESSED1 and DGF.
struct LatticeHeader {
  int32_t anchor[3];
  unsigned bits[3];
  unsigned exponent;

  void check() const { demand(exponent >= 1 && exponent <= 232, "the exponent is not from 1 to 232"); }

  std::array<float, 3> vertex(const BitReader& from, size_t& position) const {
    const float scale = std::ldexp(1.0f, int(exponent) - 127);
    std::array<float, 3> v;
    for (int k = 0; k < 3; k++) {
      const int32_t steps = anchor[k] + int32_t(from.read(position, bits[k]));
      demand(exponent < 232 || (steps >= -8388607 && steps <= 8388607), "a vertex is not finite");
      v[k] = float(steps) * scale;
      position += bits[k];
    }
    return v;
  }
};

inline DecodedCluster decodeCompressed1(const void* data, size_t bytes, unsigned numVertices) {
  demand((uintptr_t)data % 4 == 0, "the header is not aligned to 4 bytes");
  const BitReader from(data, bytes);
  LatticeHeader header;
  header.exponent = from.read(0, 8);
  header.anchor[0] = from.readSigned(8, 24);
  header.bits[0] = from.read(32, 4) + 1;
  header.bits[1] = from.read(36, 4) + 1;
  header.anchor[1] = from.readSigned(40, 24);
  header.bits[2] = from.read(64, 4) + 1;
  demand(from.read(68, 4) == 0, "unused bits are not zero");
  header.anchor[2] = from.readSigned(72, 24);
  header.check();
  DecodedCluster cluster;
  size_t position = 96;
  for (unsigned i = 0; i < numVertices; i++) cluster.vertices.push_back(header.vertex(from, position));
  demand((position + 7) / 8 <= bytes && bytes < (position + 7) / 8 + 4, "more bytes than vertices take");
  return cluster;
}

inline DecodedCluster decodeDgf(const void* data, size_t bytes) {
  demand(bytes == 128, "a block is not 128 bytes");
  const BitReader from(data, bytes);
  demand(from.read(0, 8) == 6, "the magic is not 6");
  DecodedCluster cluster;
  const unsigned bitsPerIndex = cluster.bitsPerIndex = from.read(8, 2) + 3, numVertices = from.read(10, 6) + 1,
                 numTriangles = from.read(16, 6) + 1;
  LatticeHeader header;
  header.exponent = from.read(32, 8);
  header.anchor[0] = from.readSigned(40, 24);
  header.bits[0] = from.read(64, 4) + 1;
  header.bits[1] = from.read(68, 4) + 1;
  header.anchor[1] = from.readSigned(72, 24);
  header.bits[2] = from.read(96, 4) + 1;
  demand(from.read(100, 3) == 0, "there are micromaps");
  demand(from.read(103, 1) == 0, "there is a palette of geometries");
  header.anchor[2] = from.readSigned(104, 24);
  header.check();
  cluster.primitives = from.read(128, 29);
  demand(from.read(157, 3) == 0, "there is user data, or unused bits are not zero");

  /* the front buffer */
  demand((header.bits[0] + header.bits[1] + header.bits[2]) % 4 == 0, "vertices do not take a multiple of 4 bits");
  size_t position = 8 * 20;
  for (unsigned i = 0; i < numVertices; i++) cluster.vertices.push_back(header.vertex(from, position));
  for (; position % 8 != 0; position++) demand(from.read(position, 1) == 0, "bits after the vertices are not zero");
  demand(position <= 8 * (20 + 96), "the front buffer is larger than 96 bytes");

  /* controls, from the end of the block to the front; the first triangle's is implicit */
  enum { RESTART, EDGE1, EDGE2, BACKTRACK };
  std::vector<unsigned> control = {RESTART};
  size_t back = 8 * 128;
  for (unsigned t = 1; t < numTriangles; t++) control.push_back(from.read(back -= 2, 2));
  size_t& numIndices = cluster.numIndices;
  for (unsigned c : control) numIndices += c == RESTART ? 3 : 1;

  /* Indices: the first three are implicit. One bit for each of the others, also from the end, is set if the index
   * refers to a new vertex. The other indices follow the vertices. */
  std::vector<unsigned> indices = {0, 1, 2};
  unsigned next = 3;
  const size_t reuse = position;
  while (indices.size() < numIndices) {
    if (from.read(--back, 1)) {
      indices.push_back(next++);
      continue;
    }
    indices.push_back(from.read(position, bitsPerIndex));
    demand(indices.back() < next, "a vertex is reused before its first use");
    position += bitsPerIndex;
  }
  demand(next == numVertices, "a vertex is in no triangle");
  demand(position - reuse <= 8 * 24, "the reuse buffer is larger than 24 bytes");
  demand(position <= back, "the index buffer and the bits of first uses overlap");
  for (; position < back; position++) demand(from.read(position, 1) == 0, "bits that nothing uses are not zero");

  size_t i = 0;
  for (unsigned t = 0; t < numTriangles; t++) {
    const auto& all = cluster.triangles;
    std::array<unsigned, 3> triangle{};
    switch (control[t]) {
    case RESTART:
      for (unsigned& v : triangle) v = indices[i++];
      break;
    case EDGE1: // 1->2 of the previous triangle, reversed
      triangle = {all[t - 1][2], all[t - 1][1], indices[i++]};
      break;
    case EDGE2: // 2->0
      triangle = {all[t - 1][0], all[t - 1][2], indices[i++]};
      break;
    case BACKTRACK: // the other of these two edges of the triangle before the previous one
      demand(t >= 2 && (control[t - 1] == EDGE1 || control[t - 1] == EDGE2), "BACKTRACK where it is not allowed");
      if (control[t - 1] == EDGE1) triangle = {all[t - 2][0], all[t - 2][2], indices[i++]};
      else triangle = {all[t - 2][2], all[t - 2][1], indices[i++]};
      break;
    }
    cluster.triangles.push_back(triangle);
  }
  return cluster;
}

} // namespace programs::test
