// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Input of a block's encoders: its vertices in world space and in its frame, and bounds of all nodes.
 *
 * A cell is a quad, or a quarter of the only quad of a cLEAF block, whose groups have four leaves. */

#include "leaf/format.h"
#include "frame_fit.h"
#include "node_encoder.h"
#include "../base/codec_names.h"
#include "../../cvert/portable/vertices4.h"
#include <algorithm>
#include <cstring>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Smallest area of a quad in the frame, relative to an equal share of the unit square. Leaves are more than 16
 *  times as wide as smaller quads. */
static constexpr double minQuadArea = 1.0 / 256;

class BlockGeometry {
public:
  const uint32_t height;
  const uint32_t width;             //!< vertices along a side
  const uint32_t cellLevels;        //!< log2 of cells along a side
  const float (*const vertices)[3]; //!< world positions
  Frame frame;
  InverseFrame inverse;
  float lower[4], upper[4];    //!< bounds of the finite vertices, in world space; set by fit()
  double maxAbsCoordinate = 0; //!< of the finite vertices; set by computeBounds()
  double rounding[4];          //!< per axis of the frame: largest distance of two faces' evaluations of a vertex
  ExactBox* boxes;             //!< of all quadtree levels down to cells; set by computeBounds()
  double (*local)[4];          //!< vertices of cells in the frame, row by row; set by fit()
  uint32_t invalidQuads = 0;   //!< quads with a vertex that is not finite; set by computeBounds()

  /*! Bytes of scratch memory for blocks of this height, of any kind. */
  static size_t scratchBytes(uint32_t height) {
    BlockGeometry geometry(Kind::CLEAF, height, nullptr, nullptr); // cLEAF has the smallest cells
    return geometry.layoutScratch(nullptr);
  }

  /*! vertices: (2^height+1)^2 world positions, row by row. scratch: scratchBytes(height) bytes, aligned to 16. Both
   *  must outlive the object. */
  BlockGeometry(Kind kind, uint32_t height, const float (*vertices)[3], void* scratch)
    : height(height),
      width((1u << height) + 1),
      cellLevels(std::max(height, kindFormats[uint32_t(kind)].minNodeLevels)),
      vertices(vertices) {
    layoutScratch((char*)scratch);
  }

  /*! Fits the frame. Returns false if no vertex is finite, or floats cannot represent a frame. corners: world
   *  positions to which the frame is aligned, in the order (0,0), (1,0), (0,1), (1,1). */
  bool fit(const float corners[4][3]) {
    const size_t numVertices = size_t(width) * width, numFinite = boundVertices();
    allFinite = numFinite == numVertices;
    if (numFinite == 0) return false;
    if (!allFinite) {
      size_t n = 0;
      for (uint32_t i = 0; i < numVertices; i++)
        if (isFinite(i)) memcpy(finiteCopies[n++], vertices[i], sizeof(float[3]));
    }
    const float(*const finite)[3] = allFinite ? vertices : finiteCopies;

    float aligned[4][3];
    memcpy(aligned, corners, sizeof(aligned));
    bool areCornersFinite = true;
    for (int c = 0; c < 4; c++) areCornersFinite &= cbvh::isFinite(corners[c]);
    if (!areCornersFinite) // four finite vertices instead: the frame is then not aligned
      for (int c = 0; c < 4; c++) memcpy(aligned[c], finite[size_t(c) * (numFinite - 1) / 3], sizeof(float[3]));
    if (!fitFrame(aligned, finite, numFinite, fitScratch, frame)) return false;
    const FrameLanes lanes(frame.columns);
    for (uint32_t i = 0; i < numVertices; i++) {
      frame.transform(lanes, vertices[i]).store(local[i]);
      if (!allFinite && !isFinite(i)) local[i][0] = NAN; // also a float that counts as not finite
    }
    if (cellLevels > height) splitQuad();
    return true;
  }

  /*! True if leaves would be much larger than most quads, so that the block should not be compressed: vertices are
   *  on a line, or a few are far from the others. Requires fit(). */
  bool isDegenerate() const {
    const uint32_t side = 1u << cellLevels, numCells = side * side;
    const double minTwiceArea = 2 * minQuadArea / numCells;
    if (frame.degenerate) return true;
    uint32_t numSmall = 0, numValid = 0;
    for (uint32_t y = 0; y < side; y++) {
      if (allFinite && 2 * (numValid - numSmall) >= numCells) return false; // more cells cannot change the result
      for (uint32_t x = 0; x < side; x++) {
        const double(*const v)[4] = local + y * (side + 1) + x;
        const double twiceArea =
            cross2D(Double4::load(v[side + 2]) - Double4::load(v[0]), Double4::load(v[side + 1]) - Double4::load(v[1]));
        numSmall += std::fabs(twiceArea) < minTwiceArea;
        numValid += twiceArea == twiceArea; // not NaN
      }
    }
    return 2 * numSmall > numValid;
  }

  /*! Sets `boxes`, `inverse`, `maxAbsCoordinate`, `rounding` and `invalidQuads`. Requires fit(). */
  void computeBounds() {
    inverse = InverseFrame(frameMap(frame.columns));
    computeRounding();
    uint32_t invalidCells = 0;
    boundNode(0, 0, 0, 0, invalidCells);
    invalidQuads = cellLevels > height ? invalidCells != 0 : invalidCells; // cells may be parts of the only quad
  }

  /*! Bounds of node m of a level, or of cell m if level is cellLevels, see boundCell(). */
  ExactBox& boxOf(uint32_t level, uint32_t m) { return boxes[nodesOfLevels(level) + m]; }
  const ExactBox& boxOf(uint32_t level, uint32_t m) const { return boxes[nodesOfLevels(level) + m]; }

  bool areAllFinite() const { return allFinite; }
  bool isFinite(uint32_t i) const { return cbvh::isFinite(vertices[i]); }

private:
  /*! Sets pointers into the scratch memory. Returns its size in bytes. */
  size_t layoutScratch(char* scratch) {
    const size_t side = (size_t(1) << cellLevels) + 1, numPoints = side * side;
    size_t bytes = 0;
    auto allocate = [&](size_t n) {
      const uintptr_t p = uintptr_t(scratch) + bytes;
      bytes += (n + 15) & ~size_t(15);
      return p;
    };
    boxes = (ExactBox*)allocate(nodesOfLevels(cellLevels + 1) * sizeof(ExactBox));
    local = (double(*)[4])allocate(numPoints * sizeof(*local));
    fitScratch = (Double3*)allocate(numPoints * sizeof(Double3));
    finiteCopies = (float(*)[3])allocate(numPoints * 3 * sizeof(float));
    return bytes;
  }

  /*! False for vertices that are not finite, and for points that splitQuad() computed from them. */
  bool isLocalFinite(uint32_t i) const {
    return std::isfinite(local[i][0]) && std::isfinite(local[i][1]) && std::isfinite(local[i][2]);
  }

  /*! Divides the only quad into 2 x 2 cells, bilinearly. */
  void splitQuad() {
    double quad[4][4];
    memcpy(quad, local, sizeof(quad));
    for (int v = 0; v < 9; v++)
      for (int k = 0; k < 4; k++)
        local[v][k] = 0.25 * ((2 - v % 3) * ((2 - v / 3) * quad[0][k] + (v / 3) * quad[2][k]) +
                              (v % 3) * ((2 - v / 3) * quad[1][k] + (v / 3) * quad[3][k]));
  }

  /*! Sets maxAbsCoordinate and `rounding`: vertexRounding in the frame. A world-space step of r on each axis moves
   *  x = X/W by at most r (|dX| + |dW|)/W, where |dX| and |dW| are sums of absolute derivatives. */
  void computeRounding() {
    maxAbsCoordinate = 0;
    for (int k = 0; k < 3; k++) maxAbsCoordinate = std::max(maxAbsCoordinate, double(std::max(-lower[k], upper[k])));
    double maxRcpW = 0; // in the frame's box: 1/W is linear there
    for (int corner = 0; corner < 8; corner++)
      maxRcpW = std::max(maxRcpW, inverse.rcpW({double(corner & 1), double((corner >> 1) & 1), double(corner >> 2)}));
    auto sumOfDerivatives = [&](int k) {
      return std::fabs(double(frame.columns[0][k])) + std::fabs(double(frame.columns[1][k])) +
             std::fabs(double(frame.columns[2][k]));
    };
    rounding[3] = 0;
    for (int k = 0; k < 3; k++)
      rounding[k] = vertexRounding * maxAbsCoordinate * (sumOfDerivatives(k) + sumOfDerivatives(3)) * maxRcpW;
  }

  /*! Sets the boxes of node m at (x,y) of its level, and of all nodes below it. Cells with a vertex that is not
   *  finite are empty; invalidCells counts them. */
  void boundNode(uint32_t level, uint32_t m, uint32_t x, uint32_t y, uint32_t& invalidCells) {
    if (level == cellLevels) {
      boxOf(level, m) = boundCell(y * ((1u << cellLevels) + 1) + x, invalidCells);
      return;
    }
    for (uint32_t c = 0; c < 4; c++) boundNode(level + 1, 4 * m + c, 2 * x + (c & 1), 2 * y + (c >> 1), invalidCells);
    const ExactBox* const children = &boxOf(level + 1, 4 * m);
    ExactBox box = children[0];
    for (uint32_t c = 1; c < 4; c++) box.extend(children[c]);
    boxOf(level, m) = box;
  }

  /*! Bounds of a cell, enlarged by `rounding` but inside of the frame. v: index of its first vertex. */
  ExactBox boundCell(uint32_t v, uint32_t& invalidCells) const {
    const uint32_t next = v + (1u << cellLevels) + 1; // in the next row
    if (!allFinite && !(isLocalFinite(v) && isLocalFinite(v + 1) && isLocalFinite(next) && isLocalFinite(next + 1))) {
      invalidCells++;
      return ExactBox();
    }
    const Double4 p[4] = {Double4::load(local[v]), Double4::load(local[v + 1]), Double4::load(local[next]),
                          Double4::load(local[next + 1])};
    const Double4 lower = min(min(p[0], p[1]), min(p[2], p[3])), upper = max(max(p[0], p[1]), max(p[2], p[3]));
    const Double4 r = Double4::load(rounding);
    return ExactBox(min(lower, max(lower - r, frameMargin)), max(upper, min(upper + r, 1 - frameMargin)));
  }

  /*! Sets lower and upper. Returns the number of finite vertices. */
  size_t boundVertices() {
    const size_t numVertices = size_t(width) * width;
    if (cbvh::boundsOfVertices(vertices, numVertices, lower, upper)) return numVertices;
    Float4 low = maxCoordinate, high = -maxCoordinate;
    size_t numFinite = 0;
    for (size_t i = 0; i < numVertices; i++) {
      if (!isFinite(uint32_t(i))) continue;
      const Float4 p = loadVertex(vertices, i, numVertices);
      low = min(low, p);
      high = max(high, p);
      numFinite++;
    }
    low.store(lower);
    high.store(upper);
    return numFinite;
  }

  bool allFinite = false;
  Double3* fitScratch;      //!< memory for fitFrame()
  float (*finiteCopies)[3]; //!< the finite vertices, if some are not
};
}} // namespace embree::cbvh::CBVH_ISA
