// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Data of a ray for all cVERT and mesh blocks that it reaches, owned by traversal: the shear that maps the ray to the z
 * axis, for triangles; its reciprocal direction, for boxes; its nearest hit, for hits at the same distance. See
 * cvert/rule/rule.h. */

#include "cache.h"
#include "../base/surface_ids.h"
#include "../base/vectors.h"
#include "../base/codec_names.h"
#include "../../cvert/rule/rule.h"
#include "../embree/traversal.h"

namespace embree::isa::cbvh {
/*! Members that VertRay and VertRays share: a ray, or rays in lanes, in world space. */
template<typename Real>
struct VertRayBase {
  /* A single ray's arrays have an unused fourth element, so that one vector store writes them. After several
   * smaller stores, a vector load would wait. */
  static const int stride = sizeof(Real) == sizeof(float) ? 4 : 3;
  alignas(Real) alignas(16) Real org[stride], dir[stride], rcp[stride]; //!< rcp: directionReciprocal of dir
  Real largestComponent;                                                //!< largest absolute component of dir

  /*! Sets all members but rcp. */
  template<typename Vector>
  __forceinline void set(const Vector& o, const Vector& d) {
    org[0] = o.x;
    org[1] = o.y;
    org[2] = o.z;
    dir[0] = d.x;
    dir[1] = d.y;
    dir[2] = d.z;
    largestComponent = max(max(abs(dir[0]), abs(dir[1])), abs(dir[2]));
  }
};

/*! The nearest hit of a ray in cVERT and mesh blocks. */
struct NearestVertHit {
  const VertHeader* block; //!< null without a hit; points to a MeshHeader in mesh blocks, see cached_mesh.h
  uint32_t triangle;       //!< see TriangleKey::triangle
  float t;

  __forceinline NearestVertHit() : block(nullptr) {}
  __forceinline NearestVertHit(const VertHeader* block, uint32_t triangle, float t)
    : block(block),
      triangle(triangle),
      t(t) {}

  /*! True if another triangle, hit at the same distance, has precedence. Requires a hit. */
  __forceinline bool losesTieTo(const VertHeader* other, uint32_t otherTriangle, const SurfaceIDs& ids) const {
    return hasPrecedence(keyOf(other, otherTriangle, ids), keyOf(block, triangle, ids));
  }

private:
  static __forceinline TriangleKey keyOf(const VertHeader* block, uint32_t triangle, const SurfaceIDs& ids) {
    return TriangleKey{ids[block->surface], block->primID, block->region, triangle};
  }
};

/*! A single ray. Call set() before the first block; many rays reach none. */
struct VertRay : public VertRayBase<float> {
  bool isSet;
  int kx, ky, kz;        //!< kz: axis of the largest component of dir, then the next axes kx and ky
  float sx, sy;          //!< shear: dir[kx]/dir[kz] and dir[ky]/dir[kz]
  uint32_t negativeAxes; //!< bits 0..2: rcp[k] is negative; the other bits are undefined
  VertCache* cache;      //!< cache of the calling thread

  mutable NearestVertHit nearest; //!< updated by accepted hits

  __forceinline VertRay() : isSet(false) {}

  __forceinline void set(const Ray& ray) {
    if (likely(isSet)) return;
    isSet = true;
    cache = &VertCache::ofThread();
    const vfloat4 direction = withoutFourth(Vec3fa(ray.dir).m128), reciprocals = directionReciprocals(direction);
    vfloat4::store(org, withoutFourth(Vec3fa(ray.org).m128));
    vfloat4::store(dir, direction);
    vfloat4::store(rcp, reciprocals);
    negativeAxes = uint32_t(movemask(reciprocals < vfloat4(zero)));
    const Vec3fa a = abs(Vec3fa(ray.dir));
    largestComponent = max(max(a.x, a.y), a.z);
    kz = largestAxis(a.x, a.y, a.z);
    setAxes();
    const float sz = 1.0f / nonZero(dir[kz]);
    sx = dir[kx] * sz;
    sy = dir[ky] * sz;
  }

  /*! Sets kx and ky. Requires kz. */
  __forceinline void setAxes() {
    kx = axisAfter(kz, 1);
    ky = axisAfter(kz, 2);
  }
};

/*! Rays of a packet, one per lane. Call set() before the first block. */
template<int K>
class VertRays : public VertRayBase<vfloat<K>> {
public:
  vfloat<K> sx, sy;
  VertCache* cache; //!< cache of the calling thread
  vint<K> rayClass; //!< bits 0..1: kz; bits 2..4: signs of rcp. Rays of the same class are traced together.

  __forceinline VertRays() : isSet(false), loaded(0) {}

  __forceinline void set(const RayK<K>& rays) {
    if (likely(isSet)) return;
    isSet = true;
    cache = &VertCache::ofThread();
    VertRayBase<vfloat<K>>::set(rays.org, rays.dir);
    for (int k = 0; k < 3; k++) this->rcp[k] = directionReciprocal(this->dir[k], this->largestComponent);
    const vfloat<K>* dir = this->dir;
    const vfloat<K> x = abs(dir[0]), y = abs(dir[1]), z = abs(dir[2]);
    // as largestAxis: with NaN, <= is false on all instruction sets, but > and max differ
    const vbool<K> isX = y <= x, notZ = z <= select(isX, x, y);
    const vfloat<K> sz = vfloat<K>(1.0f) / nonZero(vfloat<K>(select(notZ, select(isX, dir[0], dir[1]), dir[2])));
    sx = select(notZ, select(isX, dir[1], dir[2]), dir[0]) * sz;
    sy = select(notZ, select(isX, dir[2], dir[0]), dir[1]) * sz;
    rayClass = select(notZ, select(isX, vint<K>(zero), vint<K>(1)), vint<K>(2));
    for (int k = 0; k < 3; k++) rayClass |= select(this->rcp[k] < vfloat<K>(zero), vint<K>(4 << k), vint<K>(zero));
  }

  __forceinline NearestVertHit& nearest(size_t k) { return rays[k].nearest; }

  /*! Ray k for tests of triangles: rcp, largestComponent, negativeAxes and cache are not set. */
  __forceinline const VertRay& ray(size_t k) {
    VertRay& ray = rays[k];
    if (likely((loaded >> k) & 1)) return ray;
    loaded |= 1u << k;
    for (int i = 0; i < 3; i++) {
      ray.org[i] = this->org[i][k];
      ray.dir[i] = this->dir[i][k];
    }
    ray.kz = rayClass[k] & 3;
    ray.setAxes();
    ray.sx = sx[k];
    ray.sy = sy[k];
    return ray;
  }

private:
  bool isSet;
  uint32_t loaded; //!< rays that ray() has set
  VertRay rays[K];
};

/*! TriangleSides of up to 16 triangles, one per lane. A group's test stores them for its hits. */
struct alignas(64) SidesInLanes {
  float weights[3][16];

  /*! Sets vector j of the lanes. */
  __forceinline void set(int j, const vfloatV& w0, const vfloatV& w1, const vfloatV& w2) {
    vfloatV::store(weights[0] + vectorWidth * j, w0);
    vfloatV::store(weights[1] + vectorWidth * j, w1);
    vfloatV::store(weights[2] + vectorWidth * j, w2);
  }

  __forceinline TriangleSides<float> at(uint32_t lane) const {
    TriangleSides<float> sides;
    sides.w0 = weights[0][lane];
    sides.w1 = weights[1][lane];
    sides.w2 = weights[2][lane];
    sides.sum = sides.w0 + sides.w1 + sides.w2;
    return sides;
  }
};
} // namespace embree::isa::cbvh
