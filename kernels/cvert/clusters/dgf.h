// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Triangles as blocks of 128 bytes of AMD's Dense Geometry Format, DGF1:
 *
 *   header, 20 bytes | offsets of vertices | indices of reused vertices -> ... <- first uses | <- controls of triangles
 *
 * Each triangle shares an edge with one of the two triangles before it, or restarts the strip. Vertices are in the
 * order of their first use, so only reused vertices need an index.
 *
 * Based on: the Vulkan specification, VK_AMDX_dense_geometry_format, "Dense Geometry Format Version 1", Khronos 2025;
 * Barczak, Benthin, McAllister, "DGF: A Dense, Hardware-Friendly Geometry Format for Lossily Compressing Meshlets with
 * Arbitrary Topologies", 2024. */

#include "lattice_points.h"
#include "quad_triangles.h"

namespace cvert { namespace dgf {
enum : uint32_t {
  blockBytes = 128,
  headerBytes = 20,
  maxVertices = 64,
  maxTriangles = 64,
  maxFrontBytes = 96,
  maxReuseBits = 192,
  maxPrimitives = 1u << 29
};

enum Control : uint8_t { RESTART = 0, EDGE1 = 1, EDGE2 = 2, BACKTRACK = 3 };

/*! bits: receives the bits of offsets per axis. Returns their sum, in DGF a multiple of 4. Requires a span that is
 *  empty or fits(). */
inline uint32_t offsetBits(const LatticeSpan& span, uint32_t bits[3]) {
  for (int k = 0; k < 3; k++) bits[k] = span.bits(k);
  for (int k = 0; (bits[0] + bits[1] + bits[2]) % 4 != 0; k = (k + 1) % 3)
    if (bits[k] < 16) bits[k]++;
  return bits[0] + bits[1] + bits[2];
}

/*! Bits of an index, 3 to 6. highest: largest index of a reused vertex. */
inline uint32_t indexBits(uint32_t highest) { return highest < 8 ? 3 : bitWidth(highest); }

/*! True if a block has room. vertexBits: bits per vertex. indices: number of indices of the strip; `reused` of them
 *  refer to earlier vertices. */
inline bool hasRoom(uint32_t vertices, uint32_t triangles, uint32_t vertexBits, uint32_t indices, uint32_t reused,
                    uint32_t bitsOfIndex) {
  const uint32_t front = (vertices * vertexBits + 7) / 8;
  return vertices <= maxVertices && triangles <= maxTriangles && front <= maxFrontBytes &&
         reused * bitsOfIndex <= maxReuseBits &&
         8 * (headerBytes + front) + reused * bitsOfIndex + (indices - 3) + 2 * (triangles - 1) <= 8 * blockBytes;
}

/*! hasRoom() for a grid of quads as one strip, which uses each inner vertex twice. */
inline bool hasRoomForQuads(uint32_t width, uint32_t height, const LatticeSpan& span) {
  uint32_t bits[3];
  const uint32_t vertices = (width + 1) * (height + 1), triangles = 2 * width * height;
  return (span.isEmpty() || span.fits()) && hasRoom(vertices, triangles, offsetBits(span, bits), triangles + 2,
                                                    (width - 1) * (height - 1), indexBits(vertices - 1));
}

/*! Triangles are rotated to begin with the edge that they share with an earlier one. */
class Block {
public:
  uint8_t bytes[blockBytes];
  uint8_t order[maxVertices]; //!< vertices of QuadTriangles, in the block's order
  uint32_t numVertices;
  uint8_t indices[maxTriangles][3]; //!< indices into order

  /*! Encodes a cluster of at least one triangle. firstPrimitive: number of its first triangle, below
   *  maxPrimitives. Returns false if there is no room or offsets do not fit. */
  bool write(const QuadTriangles& cluster, const LatticePoints& points, uint32_t firstPrimitive) {
    if (cluster.numTriangles > maxTriangles || cluster.numVertices > maxVertices) return false;
    numTriangles = cluster.numTriangles;
    memcpy(indices, cluster.indices, 3 * numTriangles);
    makeStrip();
    numberVertices();
    LatticeSpan span;
    for (uint32_t i = 0; i < numVertices; i++) span.add(points.at[cluster.vertices[order[i]]]);
    if (!span.fits()) return false;
    uint32_t bits[3];
    const uint32_t vertexBits = offsetBits(span, bits), bitsOfIndex = indexBits(highestReused);
    if (!hasRoom(numVertices, numTriangles, vertexBits, numIndices, numReused, bitsOfIndex)) return false;

    memset(bytes, 0, sizeof(bytes));
    const uint32_t magic = 6, isOpaque = 1;
    writeWord(bytes,
              magic | (bitsOfIndex - 3) << 8 | (numVertices - 1) << 10 | (numTriangles - 1) << 16 | isOpaque << 22);
    writeWord(bytes + 4, points.exponent | uint32_t(span.lower[0]) << 8);
    writeWord(bytes + 8, (bits[0] - 1) | (bits[1] - 1) << 4 | uint32_t(span.lower[1]) << 8);
    writeWord(bytes + 12, (bits[2] - 1) | uint32_t(span.lower[2]) << 8);
    writeWord(bytes + 16, firstPrimitive);
    size_t position = 8 * headerBytes;
    for (uint32_t i = 0; i < numVertices; i++)
      for (int k = 0; k < 3; k++) {
        writeBits(bytes, position, bits[k], uint32_t(points.at[cluster.vertices[order[i]]][k] - span.lower[k]));
        position += bits[k];
      }
    position = (position + 7) / 8 * 8;
    for (uint32_t i = 0; i < numReused; i++, position += bitsOfIndex)
      writeBits(bytes, position, bitsOfIndex, reused[i]);
    for (uint32_t t = 1; t < numTriangles; t++) writeBits(bytes, 8 * blockBytes - 2 * t, 2, control[t]);
    for (uint32_t i = 3; i < numIndices; i++)
      writeBits(bytes, 8 * blockBytes - 2 * (numTriangles - 1) - (i - 2), 1, isFirst[i]);
    return true;
  }

private:
  uint32_t numTriangles, numIndices, numReused, highestReused;
  Control control[maxTriangles];
  bool isFirst[3 * maxTriangles];
  uint8_t reused[3 * maxTriangles];

  /*! Rotates a triangle to begin with edge (a,b). Returns false if it has no such edge. */
  static bool rotateTo(uint8_t triangle[3], uint8_t a, uint8_t b) {
    for (int i = 0; i < 3; i++)
      if (triangle[i] == a && triangle[(i + 1) % 3] == b) {
        rotate(triangle, i);
        return true;
      }
    return false;
  }

  static void rotate(uint8_t triangle[3], int first) {
    const uint8_t old[3] = {triangle[0], triangle[1], triangle[2]};
    for (int i = 0; i < 3; i++) triangle[i] = old[(first + i) % 3];
  }

  static bool hasEdge(const uint8_t triangle[3], uint8_t a, uint8_t b) {
    for (int i = 0; i < 3; i++)
      if (triangle[i] == a && triangle[(i + 1) % 3] == b) return true;
    return false;
  }

  /*! Chooses the shared edge of triangle t, and rotates the triangle to it. */
  Control controlOf(uint32_t t) {
    uint8_t* const next = indices[t];
    const uint8_t* const last = indices[t - 1];
    if (rotateTo(next, last[2], last[1])) return EDGE1;
    if (rotateTo(next, last[0], last[2])) return EDGE2;
    if (t < 2 || (control[t - 1] != EDGE1 && control[t - 1] != EDGE2)) return RESTART;
    const uint8_t* const before = indices[t - 2];
    if (control[t - 1] == EDGE1 ? rotateTo(next, before[0], before[2]) : rotateTo(next, before[2], before[1]))
      return BACKTRACK;
    return RESTART;
  }

  void makeStrip() {
    for (uint32_t t = 0; t < numTriangles; t++) {
      control[t] = t == 0 ? RESTART : controlOf(t);
      // the next triangle cannot share this one's first edge
      if (control[t] == RESTART && t + 1 < numTriangles && hasEdge(indices[t + 1], indices[t][1], indices[t][0]))
        rotate(indices[t], 2);
    }
  }

  void numberVertices() {
    uint8_t number[QuadTriangles::maxVertices];
    bool isNumbered[QuadTriangles::maxVertices] = {};
    numVertices = numIndices = numReused = highestReused = 0;
    for (uint32_t t = 0; t < numTriangles; t++) {
      for (int c = control[t] == RESTART ? 0 : 2; c < 3; c++) {
        const uint8_t v = indices[t][c];
        isFirst[numIndices++] = !isNumbered[v];
        if (isNumbered[v]) {
          reused[numReused++] = number[v];
          highestReused = highestReused > number[v] ? highestReused : number[v];
          continue;
        }
        isNumbered[v] = true;
        number[v] = uint8_t(numVertices);
        order[numVertices++] = v;
      }
    }
    for (uint32_t t = 0; t < numTriangles; t++)
      for (int c = 0; c < 3; c++) indices[t][c] = number[indices[t][c]];
  }
};
}} // namespace cvert::dgf
