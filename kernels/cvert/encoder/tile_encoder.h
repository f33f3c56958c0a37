// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of tiles (format/tile.h). Lossless in the same sense as block_encoder.h: tile and block of the same vertices
 * decode to the same floats. */

#include "../format/tile.h"
#include "block_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
class TileEncoder {
public:
  /*! Upper bound of the bytes that encode() writes. NumbersEncoder may append more. */
  static const size_t maxBytes =
      vertHeaderBytes + 16 + 2 * tilePartBytes + tileFloatBytes * BlockVertices::maxSide * BlockVertices::maxSide + 4;

  /*! vertices: with setSize() and computeBounds(), and a finite vertex; the other members change. tile: maxBytes,
   *  aligned to 4. Returns the size in bytes, a multiple of 4, or 0 if the vertices must remain a block: they are few,
   *  or too far apart. The caller sets VertHeader::surface and primID. */
  size_t encode(BlockVertices& vertices, const VertPlacement& placement, uint8_t* tile) {
    if (vertices.quads[0] * vertices.quads[1] < minTileQuads) return 0;
    region = placement.region;
    width = tileRowVertices(region);
    height = tileRows(region);
    const bool isOnLattice =
        vertices.allFinite && vertices.chooseSpacings(int(tileExtentBits)) && !vertices.hasRemainders();
    scaleBits = 0;
    if (isOnLattice) {
      vertices.computeCoordinates();
      while (largestCoordinate(vertices) >> (15 + scaleBits)) scaleBits++;
      for (int k = 0; k < 3; k++) {
        spacing[k] = uint32_t(vertices.exponent[k] + 127);
        fit(vertices, k);
      }
    }
    bytesPerVertex = isOnLattice ? bytesOfResiduals() : tileFloatBytes;
    if (bytesPerVertex == tileFloatBytes) scaleBits = 0;
    for (int k = 0; k < 3; k++)
      if (!(bytesPerVertex == tileFloatBytes ? setFloatBoxes(vertices, k) : setBoxes(vertices, k))) return 0;
    writeHeader(placement, tile);
    uint8_t* const data = tile + tileVerticesOffset(region, ((VertHeader*)tile)->info);
    if (bytesPerVertex == tileFloatBytes) writeFloats(vertices, data);
    else writeResiduals(vertices, data);
    return tileEnd(region, ((VertHeader*)tile)->info, bytesPerVertex);
  }

private:
  /*! Bytes of a vertex. Only residuals on z reach the fifth byte. */
  uint32_t bytesOfResiduals() const {
    const uint32_t lower = residualBits[0] + residualBits[1], all = lower + residualBits[2];
    return lower <= 32 && all <= 8 * maxTileVertexBytes ? std::max((all + 7) / 8, 2u) : tileFloatBytes;
  }

  /*! Vertex stored in a column and row, which are repeated at the end. */
  static uint32_t vertexOf(const BlockVertices& vertices, uint32_t x, uint32_t y) {
    return std::min(y, vertices.quads[1]) * vertices.width + std::min(x, vertices.quads[0]);
  }

  /*! Mean change of an axis' values per column (along 0) or row (along 1), by least squares. value(i): of vertex i. */
  template<typename Value>
  static double meanSlope(const BlockVertices& vertices, int along, const Value& value) {
    const double center = 0.5 * double(vertices.quads[along]);
    double sum = 0, squares = 0;
    for (uint32_t y = 0; y <= vertices.quads[1]; y++)
      for (uint32_t x = 0; x <= vertices.quads[0]; x++) {
        const double offset = double(along == 0 ? x : y) - center;
        sum += offset * value(y * vertices.width + x);
        squares += offset * offset;
      }
    return sum / squares;
  }

  static int largestCoordinate(const BlockVertices& vertices) {
    int largest = 0;
    for (int k = 0; k < 3; k++) largest = std::max(largest, largestCoordinate(vertices, k));
    return largest;
  }
  static int largestCoordinate(const BlockVertices& vertices, int k) {
    return *std::max_element(vertices.coordinates[k], vertices.coordinates[k] + vertices.numVertices());
  }

  /*! Sets slopes, base and residualBits of an axis. */
  void fit(const BlockVertices& vertices, int k) {
    auto coordinate = [&](uint32_t i) { return double(vertices.coordinates[k][i]); };
    for (int along = 0; along < 2; along++) {
      slope[along][k] = int(std::lround(meanSlope(vertices, along, coordinate)));
      gradient[along][k] = std::ldexp(double(slope[along][k]), vertices.exponent[k]);
    }
    for (;;) {
      int least = std::numeric_limits<int>::max(), most = std::numeric_limits<int>::min();
      for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
          const int residual = vertices.coordinates[k][vertexOf(vertices, x, y)] - predicted(k, x, y);
          least = std::min(least, residual);
          most = std::max(most, residual);
        }
      base[k] = least >> scaleBits;
      residualBits[k] = 0;
      while ((most - base[k] * (1 << scaleBits)) >> residualBits[k]) residualBits[k]++;
      if (isInt16(base[k]) && isInt16(slope[0][k]) && isInt16(slope[1][k])) return;
      slope[0][k] = slope[1][k] = 0;
    }
  }

  static bool isInt16(int x) { return x >= -32768 && x <= 32767; }

  int predicted(int k, uint32_t x, uint32_t y) const { return int(x) * slope[0][k] + int(y) * slope[1][k]; }

  /*! Sets origin, boxStep and planes of an axis. Returns false if the spacing does not fit. */
  bool setBoxes(const BlockVertices& vertices, int k) {
    origin[k] = vertices.origin[k];
    const uint32_t leastStep = maxBoxByte << scaleBits;
    boxStep[k] = std::max((uint32_t(largestCoordinate(vertices, k)) + leastStep - 1) / leastStep, 1u);
    const int step = int(boxStep[k] << scaleBits);
    setPlanes(vertices, k, [&](uint32_t i, int& below, int& above) {
      below = vertices.coordinates[k][i] / step;
      above = (vertices.coordinates[k][i] + step - 1) / step;
    });
    return true;
  }

  /*! The same for a tile with floats, and its gradients. */
  bool setFloatBoxes(const BlockVertices& vertices, int k) {
    const double span = double(vertices.upper[k]) - double(vertices.lower[k]);
    const int exponent = span > 0 ? std::max(std::ilogb(span) - 7, minSpacingExponent) : minSpacingExponent;
    if (exponent > maxSpacingExponent - 8) return false;
    origin[k] = vertices.lower[k];
    spacing[k] = uint32_t(exponent + 127);
    // below 255 steps, although differences are rounded
    boxStep[k] = uint32_t(std::ldexp(span, -exponent) / (maxBoxByte - 1)) + 1;
    const double unit = std::ldexp(double(boxStep[k]), exponent);
    setPlanes(vertices, k, [&](uint32_t i, int& below, int& above) {
      const float* p = vertices.vertices[i];
      if (!isFinite(p)) return;
      const double at = (double(p[k]) - double(origin[k])) / unit, rounding = 1e-3;
      below = std::max(int(std::floor(at - rounding)), 0);
      above = int(std::ceil(at + rounding));
    });
    auto value = [&](uint32_t i) { return isFinite(vertices.vertices[i]) ? double(vertices.vertices[i][k]) : 0.0; };
    for (int along = 0; along < 2; along++) gradient[along][k] = meanSlope(vertices, along, value);
    return true;
  }

  /*! planesOf(i,below,above): sets planes below and above vertex i, or neither. */
  template<typename PlanesOf>
  void setPlanes(const BlockVertices& vertices, int k, const PlanesOf& planesOf) {
    for (uint32_t leaf = 0; leaf < 2 * leavesPerPart; leaf++) {
      int lower = int(maxBoxByte), upper = 0;
      const uint32_t x0 = leafQuadsX * (leaf % tileLeavesX), y0 = leafQuadsY * (leaf / tileLeavesX);
      if (x0 < vertices.quads[0] && y0 < vertices.quads[1])
        for (uint32_t y = y0; y <= y0 + leafQuadsY; y++)
          for (uint32_t x = x0; x <= x0 + leafQuadsX; x++) {
            int below = int(maxBoxByte), above = 0;
            planesOf(vertexOf(vertices, x, y), below, above);
            lower = std::min(lower, below);
            upper = std::max(upper, above);
          }
      planes[leaf / leavesPerPart][k][0][leaf % leavesPerPart] = uint8_t(lower);
      planes[leaf / leavesPerPart][k][1][leaf % leavesPerPart] = uint8_t(upper);
    }
  }

  void writeHeader(const VertPlacement& placement, uint8_t* tile) const {
    VertHeader& header = *(VertHeader*)tile;
    const uint32_t info = placement.info() | tileInfo, boxes = tileBoxesOffset(info);
    memset(tile, 0, boxes);
    placement.write(header, info);
    header.bounds = order() | bytesPerVertex << 16 | scaleBits << 20;
    memcpy(header.origin, origin, sizeof(origin));
    for (uint32_t k = 0; k < 3; k++) {
      if (bytesPerVertex != tileFloatBytes) {
        put16(tile + tileSlopeXOffset + 2 * k, slope[0][k]);
        put16(tile + tileSlopeYOffset + 2 * k, slope[1][k]);
        put16(tile + tileBaseOffset + 2 * k, base[k]);
        header.word |= residualBits[k] << (5 * k);
      }
      tile[tileSpacingOffset + k] = uint8_t(spacing[k]);
      tile[tileBoxStepOffset + k] = uint8_t(boxStep[k]);
    }
    memcpy(tile + boxes, planes, tilePartBytes * tileParts(region));
  }

  static void put16(uint8_t* out, int value) {
    const uint16_t bits = uint16_t(value);
    memcpy(out, &bits, sizeof(bits));
  }

  /*! For each octant of directions, whether columns and rows run against it. */
  uint32_t order() const {
    uint32_t order = 0;
    for (uint32_t octant = 0; octant < 8; octant++)
      for (uint32_t along = 0; along < 2; along++) {
        double dot = 0;
        for (uint32_t k = 0; k < 3; k++) dot += (octant >> k) & 1 ? -gradient[along][k] : gradient[along][k];
        order |= uint32_t(dot < 0) << (2 * octant + along);
      }
    return order;
  }

  void writeResiduals(const BlockVertices& vertices, uint8_t* out) const {
    const uint32_t stride = std::min(bytesPerVertex, 4u);
    uint8_t* const high = out + 4 * width * height;
    for (uint32_t y = 0, i = 0; y < height; y++)
      for (uint32_t x = 0; x < width; x++, i++) {
        uint64_t packed = 0;
        for (int k = 2; k >= 0; k--)
          packed = packed << residualBits[k] | uint32_t(vertices.coordinates[k][vertexOf(vertices, x, y)] -
                                                        predicted(k, x, y) - base[k] * (1 << scaleBits));
        memcpy(out + stride * i, &packed, stride);
        if (bytesPerVertex == 5) high[i] = uint8_t(packed >> 32);
      }
    pad(out + bytesPerVertex * width * height);
  }

  void writeFloats(const BlockVertices& vertices, uint8_t* out) const {
    for (int k = 0; k < 3; k++)
      for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++, out += sizeof(float)) {
          const float* p = vertices.vertices[vertexOf(vertices, x, y)];
          const float value = isFinite(p) ? p[k] : NAN; // see BlockVertices::copyTo
          memcpy(out, &value, sizeof(value));
        }
    pad(out);
  }

  /*! Clears the bytes up to a multiple of 4. */
  static void pad(uint8_t* end) {
    while (size_t(end) % 4 != 0) *end++ = 0;
  }

  uint32_t region, width, height; //!< width, height: of the stored vertices
  uint32_t bytesPerVertex, scaleBits;
  float origin[3];
  int slope[2][3], base[3]; //!< slope: [along][axis]
  double gradient[2][3];    //!< the slopes in world units
  uint32_t residualBits[3] = {0, 0, 0}, spacing[3], boxStep[3];
  uint8_t planes[2][3][2][leavesPerPart]; //!< [part][axis][side][leaf]
};
}} // namespace cvert::CVERT_ISA
