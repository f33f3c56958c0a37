// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which triangles and boxes may be within a distance of a point, with triangles or boxes in lanes. Nothing that is
 * within the distance is left out; cvert/decoder/closest_point.h then decides. */

#include "../base/intrinsics.h"
#include "../base/vectors.h"
#include "moving_block.h"

namespace embree::isa::cbvh {
/*! Vectors from a point. */
struct OffsetsV {
  vfloatV x, y, z;

  __forceinline OffsetsV() {}
  __forceinline OffsetsV(const vfloatV& x, const vfloatV& y, const vfloatV& z) : x(x), y(y), z(z) {}

  __forceinline OffsetsV operator-(const OffsetsV& b) const { return OffsetsV(x - b.x, y - b.y, z - b.z); }
  __forceinline OffsetsV along(const vfloatV& t, const OffsetsV& b) const {
    return OffsetsV(madd(t, b.x, x), madd(t, b.y, y), madd(t, b.z, z));
  }
  __forceinline vfloatV largest() const { return max(max(abs(x), abs(y)), abs(z)); }
};
__forceinline vfloatV dot(const OffsetsV& a, const OffsetsV& b) { return madd(a.x, b.x, madd(a.y, b.y, a.z * b.z)); }
__forceinline OffsetsV cross(const OffsetsV& a, const OffsetsV& b) {
  return OffsetsV(msub(a.y, b.z, a.z * b.y), msub(a.z, b.x, a.x * b.z), msub(a.x, b.y, a.y * b.x));
}
__forceinline OffsetsV select(const vboolV& condition, const OffsetsV& a, const OffsetsV& b) {
  return OffsetsV(select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z));
}

/*! Bounds of the distances of triangles. For any vector q, a triangle has at least the distance that the plane through
 *  the nearest of its vertices in this direction has, min(q v) / |q|. Here q is the triangle's closest point, computed
 *  with rounding errors, which can only decrease the bound. */
class TriangleDistances {
public:
  __forceinline TriangleDistances() {}

  /*! a, b, c: vertices minus the point. */
  __forceinline TriangleDistances(const OffsetsV& a, const OffsetsV& b, const OffsetsV& c) {
    const OffsetsV ab = b - a, ac = c - a, n = cross(ab, ac);
    OffsetsV q = pointOfEdge(a, ab);
    vfloatV best = dot(q, q);
    considerPoint(pointOfEdge(a, ac), q, best);
    considerPoint(pointOfEdge(b, c - b), q, best);
    const vfloatV nn = dot(n, n), w1 = dot(n, cross(ac, a)), w2 = dot(n, cross(a, ab));
    const vboolV inside = (w1 >= vfloatV(0.0f)) & (w2 >= vfloatV(0.0f)) & (w1 + w2 <= nn) & (nn > vfloatV(0.0f));
    const vfloatV height = dot(a, n) / max(nn, vfloatV(leastSquare));
    q = select(inside, OffsetsV(n.x * height, n.y * height, n.z * height), q);
    squared = dot(q, q);
    least = min(min(dot(q, a), dot(q, b)), dot(q, c));
    length = sqrt(squared);
    // rounding errors of dot products and of offsets: 5 of 2^-24 times |q| and the farthest vertex, below 1.75 largest
    slack = max(max(a.largest(), b.largest()), c.largest()) * vfloatV(16.0f * floatUlp);
  }

  /*! False for triangles that are farther. True if a number is not finite. */
  __forceinline vboolV mayBeWithin(float distance) const {
    // Embree's `<` is false for NaN, its `>` is true
    return !(length * (vfloatV(distance * (1.0f + 16.0f * floatUlp)) + slack) < least);
  }

  vfloatV squared; //!< square of the distance, roughly

private:
  static constexpr float leastSquare = 1e-37f; //!< instead of 0, as programs may trap divisions by it

  /*! Point of an edge that is closest to the origin. */
  static __forceinline OffsetsV pointOfEdge(const OffsetsV& begin, const OffsetsV& edge) {
    const vfloatV t = -dot(begin, edge) / max(dot(edge, edge), vfloatV(leastSquare));
    return begin.along(min(max(t, vfloatV(0.0f)), vfloatV(1.0f)), edge);
  }

  static __forceinline void considerPoint(const OffsetsV& other, OffsetsV& q, vfloatV& best) {
    const vfloatV squared = dot(other, other);
    q = select(squared < best, other, q);
    best = min(squared, best);
  }

  vfloatV least, length, slack;
};

/*! Lower bounds of the squared distances of a block's boxes from a point. */
class BoxDistances {
public:
  uint32_t lanes; //!< mask of boxes

  /*! Boxes of groups. */
  __forceinline BoxDistances(const float p[3], const GroupBoxes& boxes) : lanes(boxes.lanes) {
    const int m = boxes.shearedAxis;
    vfloatV sums[16 / vectorWidth];
    for (vfloatV& sum : sums) sum = vfloatV(0.0f);
    for (int k = 0; k < 3; k++)
      if (k != m) addAxis(boxes.planes[k], p[k], boxSlack(p[k], boxes.origin[k], boxes.extent[k]), sums);
    if (m < 3) {
      ShearedCoordinate<float> at = zeroShearedCoordinate<float>();
      float square = 0.0f;
      for (int k = 0; k < 3; k++) {
        at = addSheared(at, p[k], 0.0f, boxes.origin[k], boxes.extent[k], boxes.shear[k]);
        square += boxes.shear[k] * boxes.shear[k];
      }
      const float slack = shearedSlack(at.size), scale = 1.0f / square;
      for (int j = 0; j < 16 / vectorWidth; j++) {
        const vfloatV d = distance(boxes.planes[m], j, at.org, slack);
        sums[j] = max(sums[j], d * d * vfloatV(scale));
      }
    }
    for (int j = 0; j < 16 / vectorWidth; j++) store(j, sums[j]);
  }

  /*! Boxes of leaves. */
  __forceinline BoxDistances(const float p[3], const VertHeader* tile) : lanes(tileLeaves(tile->region)) {
    const int vectors = int(tileParts(tile->region) * leavesPerPart) / vectorWidth;
    const uint8_t* const planes = (const uint8_t*)tile + tileBoxesOffset(tile->info);
    float unit[3], farthest[3], largestSpacing = 0.0f;
    for (int k = 0; k < 3; k++) {
      unit[k] = tileBoxUnit(tile, k);
      farthest[k] = std::fabs(p[k] - tile->origin[k]);
      largestSpacing = max(largestSpacing, tileSpacing(tile, k) * float(tileScale(tile)));
    }
    for (int j = 0; j < vectors; j++) {
      const uint8_t* const part = planes + tilePartBytes * (uint32_t(j) * vectorWidth / leavesPerPart) +
                                  uint32_t(j) * vectorWidth % leavesPerPart;
      vfloatV sum(0.0f);
      for (uint32_t k = 0; k < 3; k++) {
        // at least tileSlackUlps (tile_intersector1.h)
        const float slack = 16.0f * floatUlp * (farthest[k] + float((maxBoxByte + 1) * maxBoxByte) * largestSpacing);
        const vfloatV at(p[k] - tile->origin[k]), units(unit[k]);
        const vfloatV below = madd(vfloatV(loadBytes(part + leavesPerPart * (2 * k))), units, -at),
                      above = nmadd(vfloatV(loadBytes(part + leavesPerPart * (2 * k + 1))), units, at);
        const vfloatV d = max(max(below, above) - vfloatV(slack), vfloatV(0.0f));
        sum = madd(d, d, sum);
      }
      store(j, sum);
    }
  }

  /*! Boxes of leaves of a moving tile. planes: at the time. */
  __forceinline BoxDistances(const float p[3], const VertHeader* tile, const MovingLeafPlanes& planes)
    : lanes(tileLeaves(tile->region)) {
    const int vectors = int(tileParts(tile->region) * leavesPerPart) / vectorWidth;
    alignas(16) float offset[4], slack[4], units[2][4];
    const vfloat4 distance = planes.origin - vfloat4(p[0], p[1], p[2], 0.0f);
    vfloat4::store(offset, distance);
    vfloat4::store(slack, planes.slackOf(distance));
    for (int e = 0; e < 2; e++) vfloat4::store(units[e], planes.units[e]);
    for (int j = 0; j < vectors; j++) {
      const uint32_t part =
          tilePartBytes * (uint32_t(j) * vectorWidth / leavesPerPart) + uint32_t(j) * vectorWidth % leavesPerPart;
      vfloatV sum(0.0f);
      for (uint32_t k = 0; k < 3; k++) {
        auto plane = [&](uint32_t side) { // relative to p
          const uint32_t at = part + leavesPerPart * (2 * k + side);
          return madd(vfloatV(loadBytes(planes.boxes[0] + at)), vfloatV(units[0][k]),
                      madd(vfloatV(loadBytes(planes.boxes[1] + at)), vfloatV(units[1][k]), vfloatV(offset[k])));
        };
        const vfloatV d = max(max(plane(0), -plane(1)) - vfloatV(slack[k]), vfloatV(0.0f));
        sum = madd(d, d, sum);
      }
      store(j, sum);
    }
  }

  /*! Removes the nearest box of `lanes` within a distance, and returns true. Returns false without one. */
  __forceinline bool popNearest(double squaredDistance, uint32_t& lane) {
    uint32_t within = 0;
    for (uint32_t rest = lanes; rest; rest &= rest - 1) {
      const uint32_t i = uint32_t(bsf(rest));
      if (double(squared[i]) > squaredDistance) continue; // a NaN is within
      if (within == 0 || squared[i] < squared[lane]) lane = i;
      within |= 1u << i;
    }
    lanes = within;
    if (within == 0) return false;
    lanes &= ~(1u << lane);
    return true;
  }

private:
  /*! Distances on an axis, 0 between the planes. */
  static __forceinline vfloatV distance(const GroupPlanes& planes, int j, float p, float slack) {
    const vfloatV at(p), lower = vfloatV::load(planes.at[0] + vectorWidth * j),
                         upper = vfloatV::load(planes.at[1] + vectorWidth * j);
    return max(max(lower - at, at - upper) - vfloatV(slack), vfloatV(0.0f));
  }

  static __forceinline void addAxis(const GroupPlanes& planes, float p, float slack,
                                    vfloatV (&sums)[16 / vectorWidth]) {
    for (int j = 0; j < 16 / vectorWidth; j++) {
      const vfloatV d = distance(planes, j, p, slack);
      sums[j] = madd(d, d, sums[j]);
    }
  }

  __forceinline void store(int j, const vfloatV& sum) {
    vfloatV::store(squared + vectorWidth * j, sum * vfloatV(1.0f - 16.0f * floatUlp));
  }

  alignas(64) float squared[32];
};
} // namespace embree::isa::cbvh
