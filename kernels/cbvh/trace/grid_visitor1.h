// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cGRID: full-precision vertices. */

#include "block_visitor1.h"
#include "../../geometry/grid_soa.h"
#include "../../geometry/triangle_intersector_pluecker.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! cGRID: 2 x 2 quads of full-precision vertices, the very triangles and the very
       *  test of Embree's GRID */
      template<typename RayType>
      struct GridVisitor1 : public BlockVisitor1<RayType>
      {
        using BlockVisitor1<RayType>::BlockVisitor1;

        /*! barycentrics of a triangle to parameters of the face, as GridSOA::MapUV does
         *  from stored parameters; lanes are ordered as its loaders order triangles */
        template<typename Loader>
        struct MapUV
        {
          typedef typename Loader::vfloat vfloat;
          const Block* block;
          vfloat x0, y0, x1, y1, x2, y2; //!< in quads of the block

          __forceinline MapUV (const Block* block, float x, float y) : block(block)
          {
            static const float X0[8] = {0,0,1,1,0,0,1,1}, Y0[8] = {0,1,0,1,1,2,1,2};
            static const float X1[8] = {1,1,2,2,1,1,2,2}, Y1[8] = {0,0,0,0,1,1,1,1};
            static const float X2[8] = {0,1,1,2,0,1,1,2}, Y2[8] = {1,1,1,1,2,2,2,2};
            x0 = vfloat::loadu(X0) + x; x1 = vfloat::loadu(X1) + x; x2 = vfloat::loadu(X2) + x;
            y0 = vfloat::loadu(Y0) + y; y1 = vfloat::loadu(Y1) + y; y2 = vfloat::loadu(Y2) + y;
          }

          __forceinline void operator() (vfloat& u, vfloat& v, Vec3<vfloat>& Ng) const
          {
            const vfloat w = vfloat(1.0f)-u-v;
            const vfloat x = u*x1 + v*x2 + w*x0;
            const vfloat y = u*y1 + v*y2 + w*y0;
            u = block->faceU(x); v = block->faceV(y);
          }
        };

        /*! epilogue of closest hit or of any hit for M triangles */
        template<int M>
        static __forceinline Intersect1EpilogMU<M,true> epilog (RayHit& ray, IntersectContext* context, const Block* block) {
          return Intersect1EpilogMU<M,true>(ray,context,block->geomID,block->primID);
        }
        template<int M>
        static __forceinline Occluded1EpilogMU<M,true> epilog (Ray& ray, IntersectContext* context, const Block* block) {
          return Occluded1EpilogMU<M,true>(ray,context,block->geomID,block->primID);
        }

        template<typename Loader>
        __forceinline bool quads (size_t width, size_t x, size_t y, size_t lines)
        {
          typedef typename Loader::vfloat vfloat;
          const size_t plane = width*width;
          const float* p = (const float*)this->block->leaves() + y*width + x;
          Vec3<vfloat> v0, v1, v2;
          Loader::gather(p,p+plane,p+2*plane,width,lines,v0,v1,v2);
          const MapUV<Loader> mapUV(this->block,float(x),float(y));
          const PlueckerIntersector1<Loader::M> intersector(this->ray,nullptr);
          return intersector.intersect(this->ray,v0,v1,v2,mapUV,epilog<Loader::M>(this->ray,this->context,this->block));
        }

        __forceinline bool leaf (const NodeEntries::Tile&, uint32_t m, uint32_t child, const BoxRanges<16>&)
        {
          const size_t width = (size_t(1) << this->block->height()) + 1;
          const size_t lines = min(width,size_t(3));
          const uint32_t g = 16*m + child;
          const size_t x = 2*mortonX(g), y = 2*mortonY(g);
          bool found;
#if defined(__AVX__)
          found = quads<GridSOA::Gather3x3>(width,x,y,lines);
#else
          found = quads<GridSOA::Gather2x3>(width,x,y,lines);
          if (IsAnyHit<RayType>::value && found) return this->isHit = true;
          if (lines > 2) found |= quads<GridSOA::Gather2x3>(width,x,y+1,lines);
#endif
          if (!found) return false;
          this->isHit = true;
          this->sBest = this->local.localS(this->pre,this->ray.tfar) + 1e-5f;
          return IsAnyHit<RayType>::value;
        }
      };
    }
  }
}
