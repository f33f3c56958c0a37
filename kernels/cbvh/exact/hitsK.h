// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* hits1.h for packets of K rays. Rays with exactly one triangle, which most have, are processed together; the others,
 * and rays with uncertain hits, one by one. */

#include "../base/codec_names.h"
#include "../../cvert/portable/double4.h"
#include "hits1.h"
#include "../base/report_hit.h"
#include <tuple>

namespace embree::isa::cbvh {
/*! Ray k of a packet as the Target of VertHitReporter. */
template<int K, typename Rays>
struct VertTargetK {
  Rays& rays;
  IntersectContext* context;
  const size_t k;

  __forceinline float tnear() const { return rays.tnear()[k]; }
  __forceinline float tfar() const { return rays.tfar[k]; }
  __forceinline const SurfaceIDs& ids() const { return context->scene->surfaceIDs; }
  __forceinline bool needsHitData(const VertHeader* block) const {
    return cbvh::needsHitData(rays, context, block->surface);
  }
  __forceinline bool report(const VertHeader* block, uint32_t primID, SurfaceHit1& hit) const {
    return cbvh::report(rays, k, context, block->surface, primID, hit);
  }
};

template<int K, typename Rays>
class VertHitsK {
public:
  __forceinline VertHitsK(Rays& rays, IntersectContext* context, VertRays<K>& vertRays, const VertHeader* block,
                          const CachedVertBlock& cached)
    : rays(rays),
      context(context),
      vertRays(vertRays),
      block(block),
      cached(cached) {}

  /*! Returns the mask of rays that accepted a hit in group g. mask: rays with triangles. triangleMasks:
   *  GroupTrianglesK::mask. kz: VertRay::kz, the same for all rays of the mask. */
  __forceinline uint32_t report(uint32_t mask, size_t kz, uint32_t g, const vint<K>& triangleMasks) {
    uint32_t accepted = 0;
    const uint32_t singles = mask & uint32_t(movemask((triangleMasks & (triangleMasks - vint<K>(1))) == vint<K>(zero)));
    // (u,v) at edges of a lower rate are computed per ray
    if (popcnt(singles) > 1 && (likely(!hasEdges(block->info)) || !hasStitchedEdge(block->patchQuads, edgesOf(block))))
      mask &= ~reportTogether(singles, kz, g, triangleMasks, accepted);
    for (; mask; mask &= mask - 1) {
      const uint32_t k = uint32_t(bsf(mask));
      if (report(k, g, TriangleMask{uint32_t(triangleMasks[k])})) accepted |= 1u << k;
    }
    return accepted;
  }

  /*! VertHitReporter::report for ray k. */
  template<typename Triangles>
  __noinline bool report(size_t k, uint32_t g, const Triangles& triangles) {
    typedef VertTargetK<K, Rays> Target;
    return VertHitReporter<Target, CachedVertBlock>(Target{rays, context, k}, vertRays.ray(k), vertRays.nearest(k),
                                                    block, cached)
        .report(g, triangles);
  }

private:
  /*! One triangle per ray, and the intersection of its plane with the ray. Triangles of rays outside of the mask
   *  are zeros. */
  struct RayTriangles {
    alignas(64) float vertices[3][3][K];  //!< [axis][vertex][ray]
    alignas(64) float x[K], y[K];         //!< position of the quad in the patch
    alignas(64) float normal[3][K], t[K]; //!< set by intersectPlanes, as the following members
    uint32_t hitMask;                     //!< rays with an intersection not before tnear
    uint32_t inPlaneMask;                 //!< rays for which isPlaneDecisive is false

    /*! firstX, firstY: position of the group's first quad in the patch. */
    __forceinline RayTriangles(uint32_t mask, const CellVertices& group, const vint<K>& triangleMasks, float firstX,
                               float firstY) {
      for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) vfloat<K>::store(vertices[k][i], vfloat<K>(zero));
      vfloat<K>::store(x, vfloat<K>(firstX));
      vfloat<K>::store(y, vfloat<K>(firstY));
      for (; mask; mask &= mask - 1) {
        const uint32_t ray = uint32_t(bsf(mask)), index = uint32_t(bsf(uint32_t(triangleMasks[ray])));
        for (int i = 0; i < 3; i++)
          for (int k = 0; k < 3; k++) vertices[k][i][ray] = group.at[k][vertTables.triangles[index][i]];
        x[ray] += float((index >> 1) & 3);
        y[ray] += float(index >> 3);
      }
    }

    __forceinline void intersectPlanes(const VertRays<K>& vertRays, size_t kz, const vfloat<K>& tnear) {
      hitMask = inPlaneMask = 0;
      for (int j = 0; j < K; j += 4) {
        const FourRays fourRays(*this, vertRays, j);
        const WideNormal<Double4> n = normalOf(fourRays.triangle);
        const PlaneIntersection<Double4> at = intersectPlane(fourRays.triangle, n, fourRays.org, fourRays.dir);
        const TriangleSpan<Double4> span = fourRays.span(kz);
        const Double4 distance = clampToSpan(span, at.t);
        toFloat(distance).store(t + j);
        for (int k = 0; k < 3; k++) toFloat(n.at[k]).store(normal[k] + j);
        hitMask |= (Double4(lanesFrom(tnear, j)) <= distance).bits() << j;
        inPlaneMask |= (15u & ~isPlaneDecisive(at, span).bits()) << j;
      }
    }

    /*! Mask of rays whose entire triangle is between tnear and tfar. */
    __forceinline uint32_t entirelyInRange(const VertRays<K>& vertRays, size_t kz, const vfloat<K>& tnear,
                                           const vfloat<K>& tfar) const {
      uint32_t mask = 0;
      for (int j = 0; j < K; j += 4) {
        const FourRays fourRays(*this, vertRays, j);
        const TriangleSpan<Double4> span = fourRays.span(kz);
        mask |= ((Double4(lanesFrom(tnear, j)) <= span.nearest) & (span.farthest < Double4(lanesFrom(tfar, j)))).bits()
                << j;
      }
      return mask;
    }

  private:
    static __forceinline Float4 lanesFrom(const vfloat<K>& x, int j) { return Float4::load((const float*)&x + j); }

    /*! Rays j to j+3, in double precision. */
    struct FourRays {
      WideTriangle<Double4> triangle;
      Double4 org[3], dir[3];

      __forceinline FourRays(const RayTriangles& source, const VertRays<K>& vertRays, int j) {
        for (int k = 0; k < 3; k++) {
          for (int i = 0; i < 3; i++) triangle.at[k][i] = Double4(Float4::load(source.vertices[k][i] + j));
          org[k] = Double4(lanesFrom(vertRays.org[k], j));
          dir[k] = Double4(lanesFrom(vertRays.dir[k], j));
        }
      }

      /*! Rays outside of the mask may have a component kz of 0. */
      __forceinline TriangleSpan<Double4> span(size_t kz) const {
        return spanOf(triangle.at[kz][0], triangle.at[kz][1], triangle.at[kz][2], org[kz], nonZero(dir[kz]));
      }
    };
  };

  /*! Processes rays with one triangle each together. Returns the mask of rays that are done, and adds rays with
   *  an accepted hit to the mask `accepted`. Other rays need single tests: a side may have rounded to 0, the ray
   *  may lie in the triangle's plane, another hit may have the same distance, or, without hit data, the triangle
   *  may extend beyond tnear or tfar. */
  uint32_t reportTogether(uint32_t mask, size_t kz, uint32_t g, const vint<K>& triangleMasks, uint32_t& accepted) {
    RayTriangles batch(mask, cached.vertices(g), triangleMasks, float(firstQuadX(block->region, g)),
                       float(firstQuadY(block->region, g)));
    const TriangleSides<vfloat<K>> sides = sidesOf(batch, kz);
    const vfloat<K> tfar = rays.tfar;
    if (!needsHitData(rays, context, block->surface)) {
      const uint32_t certain =
          mask & uint32_t(movemask(haveExactSigns(sides))) & batch.entirelyInRange(vertRays, kz, rays.tnear(), tfar);
      const vfloat<K> unused(zero); // see needsHitData
      const vbool<K> lanes = vbool<K>(int(certain));
      accepted |= uint32_t(movemask(lanes & cbvh::report(rays, lanes, context, block->surface, block->primID, [&] {
                                      return std::make_tuple(unused, unused, unused, Vec3vf<K>(unused, unused, unused));
                                    })));
      return certain;
    }
    batch.intersectPlanes(vertRays, kz, rays.tnear());
    const vfloat<K> t = vfloat<K>::load(batch.t);
    const uint32_t done = mask & uint32_t(movemask(haveExactSigns(sides) & (t != tfar))) & ~batch.inPlaneMask;
    const vbool<K> hit = vbool<K>(int(done & batch.hitMask)) & (t < tfar);
    if (none(hit)) return done;

    Vec3vf<K> Ng(vfloat<K>::load(batch.normal[0]), vfloat<K>::load(batch.normal[1]), vfloat<K>::load(batch.normal[2]));
    const vbool<K> isLine = (Ng.x == vfloat<K>(zero)) & (Ng.y == vfloat<K>(zero)) & (Ng.z == vfloat<K>(zero));
    if (unlikely(any(hit & isLine)))
      Ng = select(isLine, Vec3vf<K>(-vertRays.dir[0], -vertRays.dir[1], -vertRays.dir[2]), Ng);
    // odd bits of the mask: second triangles of quads
    const QuadPosition<vfloat<K>> at =
        positionInQuad(sides, (triangleMasks & vint<K>(int(0xAAAAAAAAu))) != vint<K>(zero));
    if (hasPrimIDs(block->info)) {
      accepted |= reportNumbered(uint32_t(movemask(hit)), g, triangleMasks, at, t, Ng);
      return done;
    }
    const VertEdges edges = edgesOf(block);
    const vfloat<K> u =
        faceParameterOfQuad(vertCornerU(edges), vfloat<K>::load(batch.x), at.a, patchQuadsX(block->patchQuads));
    const vfloat<K> v =
        faceParameterOfQuad(vertCornerV(edges), vfloat<K>::load(batch.y), at.b, patchQuadsY(block->patchQuads));
    const uint32_t acceptedNow = uint32_t(movemask(hit & cbvh::report(rays, hit, context, block->surface, block->primID,
                                                                      [&] { return std::make_tuple(u, v, t, Ng); })));
    for (uint32_t rest = acceptedNow; rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      vertRays.nearest(k) = NearestVertHit(block, 32 * g + uint32_t(bsf(uint32_t(triangleMasks[k]))), t[k]);
    }
    accepted |= acceptedNow;
    return done;
  }

  /*! Reports hits in a block whose quads have primitive numbers. Returns the mask of rays that accepted one. */
  uint32_t reportNumbered(uint32_t mask, uint32_t g, const vint<K>& triangleMasks, const QuadPosition<vfloat<K>>& at,
                          const vfloat<K>& t, const Vec3vf<K>& Ng) {
    uint32_t accepted = 0;
    for (; mask; mask &= mask - 1) {
      const uint32_t k = uint32_t(bsf(mask)), index = uint32_t(bsf(uint32_t(triangleMasks[k])));
      SurfaceHit1 hit;
      hit.t = t[k];
      hit.Ng = Vec3fa(Ng.x[k], Ng.y[k], Ng.z[k]);
      const SurfacePoint point = pointOfNumberedQuad(block, g, index, QuadPosition<float>{at.a[k], at.b[k]});
      hit.u = point.u;
      hit.v = point.v;
      if (!cbvh::report(rays, k, context, block->surface, point.primID, hit)) continue;
      vertRays.nearest(k) = NearestVertHit(block, 32 * g + index, t[k]);
      accepted |= 1u << k;
    }
    return accepted;
  }

  /*! The same floats as GroupTrianglesK computes. */
  __forceinline TriangleSides<vfloat<K>> sidesOf(const RayTriangles& batch, size_t kz) const {
    const size_t kx = size_t(axisAfter(int(kz), 1)), ky = size_t(axisAfter(int(kz), 2));
    vfloat<K> x[3], y[3];
    for (int i = 0; i < 3; i++) {
      const vfloat<K> z = vfloat<K>::load(batch.vertices[kz][i]) - vertRays.org[kz];
      x[i] = nmadd(vertRays.sx, z, vfloat<K>::load(batch.vertices[kx][i]) - vertRays.org[kx]);
      y[i] = nmadd(vertRays.sy, z, vfloat<K>::load(batch.vertices[ky][i]) - vertRays.org[ky]);
    }
    return triangleSides(x[0], y[0], x[1], y[1], x[2], y[2]);
  }

  Rays& rays;
  IntersectContext* context;
  VertRays<K>& vertRays;
  const VertHeader* block;
  const CachedVertBlock& cached;
};
} // namespace embree::isa::cbvh
