// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles of a cluster, which is a rectangle of quads in a decoded part of a surface. Neighboring vertices at the
 * same point, as at stitched edges, become one. Triangles are omitted if two corners are at the same point or a corner
 * is not finite. */

#include <cstddef>
#include <cstdint>
#include <cmath>

namespace cvert {
/*! In quads of a part. */
struct QuadRectangle {
  uint32_t x, y, width, height;
};

class QuadTriangles {
public:
  static const uint32_t maxQuadsPerSide = 8;
  static const uint32_t maxVertices = 81, maxTriangles = 128;

  uint32_t numVertices, numTriangles;
  uint32_t vertices[maxVertices];   //!< (width+1) y + x in the rectangle, ascending
  uint8_t indices[maxTriangles][3]; //!< indices into vertices
  uint32_t triangles[maxTriangles]; //!< indices in the part: 2 (quads per row * y + x), plus 1 for the
                                    //!< second triangle of a quad
  bool isComplete;                  //!< has all vertices and triangles of the rectangle

  /*! points: x, y and z of the part's vertices, `stride` per row; not read later. rectangle: has at most maxVertices
   *  vertices. isStrip: alternates the direction of rows, so that a triangle shares an edge with one of the two
   *  triangles before it, unless one of these is omitted. */
  QuadTriangles(const float* points, uint32_t stride, const QuadRectangle& rectangle, bool isStrip)
    : numVertices(0),
      numTriangles(0),
      points(points + 3 * (size_t(rectangle.y) * stride + rectangle.x)),
      stride(stride),
      width(rectangle.width + 1) {
    const uint32_t count = width * (rectangle.height + 1);
    bool isFused = false;
    for (uint32_t i = 0; i < count; i++) {
      const uint32_t x = i % width;
      number[i] = uint8_t(x > 0 && areSame(i, i - 1)            ? number[i - 1]
                          : i >= width && areSame(i, i - width) ? number[i - width]
                                                                : i);
      isFused |= number[i] != i;
      isUsed[i] = false;
    }
    for (uint32_t y = 0; y < rectangle.height; y++)
      for (uint32_t n = 0; n < rectangle.width; n++) {
        const bool isBack = isStrip && (y & 1);
        const uint32_t x = isBack ? rectangle.width - 1 - n : n;
        const uint32_t id = 2 * ((rectangle.y + y) * (stride - 1) + rectangle.x + x), a = y * width + x;
        // From right to left, the strip enters the first quad by its first triangle, continues to the second and
        // backtracks. It enters other quads by their second triangle.
        const bool isSecondFirst = isBack && n > 0;
        for (uint32_t t = 0; t < 2; t++)
          if (isSecondFirst == (t == 0)) add(a + width, a + 1, a + width + 1, id + 1);
          else add(a, a + 1, a + width, id);
      }
    uint8_t position[maxVertices];
    for (uint32_t i = 0; i < count; i++)
      if (isUsed[i]) {
        position[i] = uint8_t(numVertices);
        vertices[numVertices++] = i;
      }
    for (uint32_t t = 0; t < numTriangles; t++)
      for (int c = 0; c < 3; c++) indices[t][c] = position[indices[t][c]];
    isComplete = !isFused && numTriangles == 2 * rectangle.width * rectangle.height;
  }

private:
  const float* at(uint32_t i) const { return points + 3 * (size_t(i / width) * stride + i % width); }

  bool areSame(uint32_t i, uint32_t j) const {
    const float *a = at(i), *b = at(j);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
  }

  bool isFinite(uint32_t i) const {
    return std::isfinite(at(i)[0]) && std::isfinite(at(i)[1]) && std::isfinite(at(i)[2]);
  }

  void add(uint32_t a, uint32_t b, uint32_t c, uint32_t id) {
    if (!isFinite(a) || !isFinite(b) || !isFinite(c) || areSame(a, b) || areSame(b, c) || areSame(c, a)) return;
    const uint32_t corners[3] = {a, b, c};
    for (int i = 0; i < 3; i++) isUsed[indices[numTriangles][i] = number[corners[i]]] = true;
    triangles[numTriangles++] = id;
  }

  const float* const points;
  const uint32_t stride, width;
  uint8_t number[maxVertices]; //!< by vertex: its replacement, or itself
  bool isUsed[maxVertices];    //!< by a triangle
};
} // namespace cvert
