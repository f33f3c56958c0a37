// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tests which triangles of a cVERT group a ray's line may pass through, by the sides of cvert/rule/rule.h: with quads
 * in lanes for a single ray, or with rays in lanes for a packet. hits1.h and hitsK.h process these triangles. */

#include "decoder.h"
#include "ray.h"

namespace embree::isa::cbvh {
/*! One triangle of a group, and the exact tests of cvert/rule/rule.h for it. */
struct VertTriangle {
  typedef TriangleSides<float> Sides;

  /*! index: of the triangle in the group, see VertTables::triangles. */
  __forceinline VertTriangle(const CellVertices& group, uint32_t index) {
    const uint8_t* const lanes = vertTables.triangles[index];
    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) vertices[k][i] = group.at[k][lanes[i]];
  }

  /*! axes: by axis, the vertices of several triangles. lanes: of this triangle's vertices. */
  template<size_t n>
  __forceinline VertTriangle(const float (&axes)[3][n], const uint8_t lanes[3]) {
    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) vertices[k][i] = axes[k][lanes[i]];
  }

  __forceinline Sides sides(const VertRay& ray) const {
    const Sheared s(*this, ray);
    return triangleSides(s.x[0], s.y[0], s.x[1], s.y[1], s.x[2], s.y[2]);
  }

  /*! True if the ray's line passes through the triangle. sides: result of sides(). Requires mayContain. */
  __forceinline bool contains(const VertRay& ray, const Sides& sides) const {
    return likely(haveExactSigns(sides)) || containsExactly(ray);
  }

  __noinline bool containsExactly(const VertRay& ray) const {
    const Sheared s(*this, ray);
    return cbvh::contains(s.x[0], s.y[0], s.x[1], s.y[1], s.x[2], s.y[2]);
  }

  __forceinline WideTriangle<double> wide() const {
    WideTriangle<double> w;
    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) w.at[k][i] = double(vertices[k][i]);
    return w;
  }

  __forceinline WideNormal<double> normal() const { return normalOf(wide()); }

  /*! Bounds of a hit's distance, from the vertices on axis kz. */
  __forceinline TriangleSpan<double> span(const VertRay& ray) const {
    const float* z = vertices[ray.kz];
    return spanOf(double(z[0]), double(z[1]), double(z[2]), double(ray.org[ray.kz]), double(ray.dir[ray.kz]));
  }

  /*! See distanceOfHit. Requires contains(). */
  __forceinline double distance(const VertRay& ray, const WideNormal<double>& normal, float tnear) const {
    const double org[3] = {ray.org[0], ray.org[1], ray.org[2]}, dir[3] = {ray.dir[0], ray.dir[1], ray.dir[2]};
    return distanceOfHit(wide(), normal, span(ray), org, dir, double(tnear));
  }

  /*! Geometric normal of a hit, not normalized; minus the ray's direction if this is 0 in float. */
  static __forceinline Vec3fa Ng(const VertRay& ray, const WideNormal<double>& normal) {
    const float x = float(normal.at[0]), y = float(normal.at[1]), z = float(normal.at[2]);
    return likely(x != 0.0f || y != 0.0f || z != 0.0f) ? Vec3fa(x, y, z) : -Vec3fa(ray.dir[0], ray.dir[1], ray.dir[2]);
  }

private:
  /*! Vertices in the sheared space in which the ray is the z axis. The fourth lane is unused. */
  struct Sheared {
    alignas(16) float x[4], y[4];

    __forceinline Sheared(const VertTriangle& t, const VertRay& ray) {
      auto relative = [&](int k) {
        return vfloat4(t.vertices[k][0], t.vertices[k][1], t.vertices[k][2], t.vertices[k][2]) - vfloat4(ray.org[k]);
      };
      const vfloat4 z = relative(ray.kz);
      vfloat4::store(x, nmadd(vfloat4(ray.sx), z, relative(ray.kx)));
      vfloat4::store(y, nmadd(vfloat4(ray.sy), z, relative(ray.ky)));
    }
  };

  float vertices[3][3]; //!< [axis][vertex]
};

/*! Sides of the edges of quads, one quad per lane. */
struct QuadSides {
  vfloatV diag, left, bottom, right, top;

  __forceinline QuadSides() {}

  /*! x, y: sheared vertices at corner c (column + 2 row). */
  __forceinline QuadSides(const vfloatV x[4], const vfloatV y[4])
    : diag(edgeSide(x[1], y[1], x[2], y[2])),
      left(edgeSide(x[2], y[2], x[0], y[0])),
      bottom(edgeSide(x[0], y[0], x[1], y[1])),
      right(edgeSide(x[1], y[1], x[3], y[3])),
      top(edgeSide(x[3], y[3], x[2], y[2])) {}

  __forceinline vboolV mayContainFirst() const { return mayContain(diag, left, bottom); }
  __forceinline vboolV mayContainSecond() const { return mayContain(right, top, -diag); }
};

/*! Moves bit q, below 16, to bit 2q. */
__forceinline uint32_t everySecondBit(uint32_t x) {
  x = (x | (x << 8)) & 0x00FF00FFu;
  x = (x | (x << 4)) & 0x0F0F0F0Fu;
  x = (x | (x << 2)) & 0x33333333u;
  return (x | (x << 1)) & 0x55555555u;
}

/*! Triangles of a group that a ray's line may pass through. */
class GroupTriangles {
public:
  uint32_t mask; //!< bits 2q and 2q+1: first and second triangle of quad q

  /*! Sides of a triangle. index: of the triangle in the group and of its bit in the mask. */
  __forceinline TriangleSides<float> sides(uint32_t index) const { return halves[index & 1u].at(index >> 1); }

  __forceinline GroupTriangles(const VertRay& ray, const CellVertices& group) : mask(0) {
    const CellVector z = relativeToRay(ray, group, ray.kz);
    const QuadCornersV cornersX(shearToRay(relativeToRay(ray, group, ray.kx), ray.sx, z));
    const QuadCornersV cornersY(shearToRay(relativeToRay(ray, group, ray.ky), ray.sy, z));
    vboolV first[QuadCornersV::vectors], second[QuadCornersV::vectors];
    for (int j = 0; j < QuadCornersV::vectors; j++) {
      vfloatV x[4], y[4];
      for (int c = 0; c < 4; c++) {
        x[c] = cornersX.at(j, c);
        y[c] = cornersY.at(j, c);
      }
      const QuadSides sides(x, y);
      first[j] = sides.mayContainFirst();
      second[j] = sides.mayContainSecond();
      halves[0].set(j, sides.diag, sides.left, sides.bottom);
      halves[1].set(j, sides.right, sides.top, -sides.diag);
    }
    const uint32_t firstMask = movemasks(first), secondMask = movemasks(second);
    const uint32_t candidateMask = firstMask | (secondMask << 16);
    if (candidateMask == 0) return;
    const uint32_t lowest = uint32_t(bsf(candidateMask));
    const bool isSingle = (candidateMask & (candidateMask - 1)) == 0;
    mask = likely(isSingle) ? 1u << (2 * (lowest & 15u) + (lowest >> 4))
                            : everySecondBit(firstMask) | (everySecondBit(secondMask) << 1);
  }

private:
  SidesInLanes halves[2]; //!< of first and second triangles of quads

  static __forceinline CellVector relativeToRay(const VertRay& ray, const CellVertices& group, int k) {
    const vfloatV org(ray.org[k]);
    return CellVector(group.at[k]).map([&](const vfloatV& x) { return x - org; });
  }

  static __forceinline CellVector shearToRay(const CellVector& x, float shear, const CellVector& z) {
    const vfloatV s(shear);
    return CellVector::combine(x, z, [&](const vfloatV& x, const vfloatV& z) { return nmadd(s, z, x); });
  }
};

/*! GroupTriangles for rays with the same kz, one per lane. Evaluates each edge between quads once: its side in
 *  the other direction is the exact negative. */
template<int K>
class GroupTrianglesK {
  const vfloat<K> orgX, orgY, orgZ, sx, sy;
  const size_t kx, ky, kz;
  const CellVertices& group;

public:
  vint<K> mask; //!< GroupTriangles::mask per ray

  __forceinline GroupTrianglesK(const VertRays<K>& rays, size_t kz, const CellVertices& group)
    : GroupTrianglesK(rays, size_t(axisAfter(int(kz), 1)), size_t(axisAfter(int(kz), 2)), kz, group) {}

private:
  struct Point {
    vfloat<K> x, y;
  };

  GroupTrianglesK(const VertRays<K>& rays, size_t kx, size_t ky, size_t kz, const CellVertices& group)
    : orgX(rays.org[kx]),
      orgY(rays.org[ky]),
      orgZ(rays.org[kz]),
      sx(rays.sx),
      sy(rays.sy),
      kx(kx),
      ky(ky),
      kz(kz),
      group(group),
      mask(zero) {
    Point below[5];
    vfloat<K> bottom[4];
    for (size_t i = 0; i < 5; i++) below[i] = vertex(i, 0);
    for (size_t i = 0; i < 4; i++) bottom[i] = side(below[i], below[i + 1]);
    for (size_t j = 0; j < 4; j++) {
      Point left = vertex(0, j + 1);
      vfloat<K> leftSide = side(left, below[0]);
      for (size_t i = 0; i < 4; i++) {
        const Point right = vertex(i + 1, j + 1);
        const vfloat<K> diag = side(below[i + 1], left), rightSide = side(below[i + 1], right), top = side(right, left);
        const vbool<K> first = mayContain(diag, leftSide, bottom[i]), second = mayContain(rightSide, top, -diag);
        if (unlikely(any(first | second)))
          mask |= select(first, vint<K>(int(1u << (2 * (4 * j + i)))), vint<K>(zero)) |
                  select(second, vint<K>(int(2u << (2 * (4 * j + i)))), vint<K>(zero));
        bottom[i] = -top;
        leftSide = -rightSide;
        below[i] = left;
        left = right;
      }
      below[4] = left;
    }
  }

  static __forceinline vfloat<K> side(const Point& a, const Point& b) { return edgeSide(a.x, a.y, b.x, b.y); }

  __forceinline Point vertex(size_t i, size_t j) const {
    const size_t lane = laneOfVertex(uint32_t(i), uint32_t(j));
    const vfloat<K> z = vfloat<K>(group.at[kz][lane]) - orgZ;
    return Point{nmadd(sx, z, vfloat<K>(group.at[kx][lane]) - orgX),
                 nmadd(sy, z, vfloat<K>(group.at[ky][lane]) - orgY)};
  }
};
} // namespace embree::isa::cbvh
