// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds the top-level primitives of one patch in cVERT: its vertices are GRID's, those on
 * its border come from the faces that own them, all are snapped to their lattices, and the
 * blocks hold them exactly. */

#include "../../bvh/bvh.h"
#include "../base/primitive_type.h"
#include "../scene/statistics.h"
#include "../surface/shared_border.h"
#include "snapped_vertices.h"
#include "encoder.h"

namespace embree
{
  namespace isa
  {
    class VertPatchBuilder
    {
    public:
      typedef FastAllocator::CachedAllocator Allocator;

      cbvh::BuildStatistics statistics;
      cbvh::WorldBounds hitBounds;

      VertPatchBuilder (const CompressionPlan& plan, const SharedVertices& shared, Scene* scene, const Allocator& alloc)
        : plan(plan), shared(shared), alloc(alloc), grid(scene->device), bytes(scene->device,0) {}

      /*! As PatchBuilder::buildBlocks; one piece of memory a patch.
       *  evaluated: the patch's vertices, if they are known, or null */
      size_t buildBlocks (size_t face, const PatchOfFace& patch, const PatchTiling& tiling, const float (*evaluated)[3], PrimRef* out)
      {
        const SubdivPatch1Base base = patch.make(plan.mesh,plan.geomID,face);
        if (evaluated) grid.set(tiling.quadsX(),tiling.quadsY(),evaluated);
        else grid.evalPart(base,plan.mesh,tiling.quadsX(),tiling.quadsY(),{ 0,tiling.quadsX(),0,tiling.quadsY() });
        const cbvh::WorldLattice lattice(shared.exponent(face));
        snapVertices(face,patch,tiling,lattice);

        const uint32_t edgeRates = ratesOf(patch);
        const size_t count = tiling.size();
        size_t used = 0;
        starts.clear();
        for (size_t i=0; i<count; i++)
        {
          bytes.resize(max(bytes.size(),used + cbvh::VertEncoder::maxBytes));
          const unsigned x = unsigned(i % tiling.x) << tiling.height, y = unsigned(i / tiling.x) << tiling.height;
          const unsigned quads[2] = { min(1u << tiling.height,tiling.quadsX()-x), min(1u << tiling.height,tiling.quadsY()-y) };
          gather(x,y,quads);
          const uint32_t place = cbvh::vertPlace(quads[0],quads[1],x,y,uint32_t(2*base.getUV(0).x),uint32_t(2*base.getUV(0).y));
          cbvh::VertStatistics block;
          const size_t n = encoder.encode(place,lattice.spacing,bytes.data()+used,block);
          starts.push_back(used);
          if (n == 0) {
            statistics.sums.numInvalidQuads += size_t(quads[0])*quads[1];
            out[i] = PrimRef(BBox3fa(Vec3fa(zero),Vec3fa(zero)),size_t(0)); // dropped
            continue;
          }
          cbvh::VertHeader* header = (cbvh::VertHeader*)(bytes.data()+used);
          header->geomID = plan.geomID;
          header->primID = unsigned(face);
          header->rates = edgeRates;
          statistics.addVertBlock(place,n,lattice.spacing,block);
          if (plan.kind() != cbvh::Kind::VERT) statistics.sums.numExactQuads += size_t(quads[0])*quads[1];
          out[i] = PrimRef(bounds(),size_t(1));
          used += (n + cbvh::blockAlignment-1) & ~size_t(cbvh::blockAlignment-1);
        }
        place(count,used,out);
        return count;
      }

    private:
      static const size_t maxPieceBytes = 1 << 20;
      static const size_t readBehind = 16; //!< bytes that decoders may read behind a block

      static uint32_t ratesOf (const PatchOfFace& patch)
      {
        uint32_t rates = 0;
        for (int s=0; s<4; s++) rates |= (uint32_t(patch.rate[s])-1u) << (8*s);
        return rates;
      }

      /*! copies the blocks to memory of the BVH's and makes references to them */
      void place (size_t count, size_t used, PrimRef* out)
      {
        size_t begin = 0;
        while (begin < count)
        {
          size_t end = begin+1;
          while (end < count && starts[end]-starts[begin] < maxPieceBytes) end++;
          const size_t size = (end < count ? starts[end] : used) - starts[begin];
          char* memory = size ? (char*)alloc.malloc1(size+readBehind,cbvh::blockAlignment) : nullptr;
          if (size) memcpy(memory,bytes.data()+starts[begin],size);
          for (size_t i=begin; i<end; i++)
            if (out[i].ID() != 0)
              out[i] = PrimRef(out[i].bounds(),size_t(BVH4::encodeTypedLeaf(memory+(starts[i]-starts[begin]),cbvh::VERT_BLOCK)));
          begin = end;
        }
      }

      void snapVertices (size_t face, const PatchOfFace& patch, const PatchTiling& tiling, const cbvh::WorldLattice& lattice)
      {
        float (*p)[3] = grid.displaced();
        memcpy(grid.undisplaced(),p,grid.width*grid.height*sizeof(*p)); // as the face evaluates them
        const float (*own)[3] = grid.undisplaced();
        for (size_t y=1; y<grid.height-1; y++)
        {
          size_t i = y*grid.width + 1;
          const size_t end = i + grid.width-2;
          for (; i+4 <= end; i+=4) statistics.addDeviation(cbvh::snapFour(lattice,own+i,p+i));
          for (; i<end; i++)
          {
            for (int k=0; k<3; k++) p[i][k] = lattice.snap(own[i][k]);
            statistics.addVertex(own[i],p[i]);
          }
        }
        float rate[4];
        shareBorder(shared,face,patch,tiling.quadsX(),tiling.quadsY(),own,p,rate,[&](const float mine[3], const float position[3], const float stored[3]) {
            statistics.addBorderVertex(mine,position,stored);
          });
        statistics.sums.numFlippedQuads += countFlipped(own,p);
      }

      /*! quads with a triangle that the lattice turned by more than 90 degrees */
      size_t countFlipped (const float (*own)[3], const float (*stored)[3]) const
      {
        size_t n = 0;
        for (size_t y=0; y+1<grid.height; y++)
        {
          size_t x = 0;
          for (; x+4 < grid.width; x+=4) n += cbvh::countFlippedOfFour(own+y*grid.width+x,stored+y*grid.width+x,grid.width);
          for (; x+1<grid.width; x++)
          {
            const size_t a = y*grid.width + x, b = a+1, c = a+grid.width, d = c+1;
            n += isFlipped(own,stored,a,b,c) || isFlipped(own,stored,b,d,c);
          }
        }
        return n;
      }

      static bool isFlipped (const float (*own)[3], const float (*stored)[3], size_t a, size_t b, size_t c)
      {
        auto normal = [&](const float (*p)[3]) {
          auto edge = [&](size_t i) { return Vec3fa(p[i][0],p[i][1],p[i][2]) - Vec3fa(p[a][0],p[a][1],p[a][2]); };
          return cross(edge(b),edge(c));
        };
        return dot(normal(own),normal(stored)) < 0.0f;
      }

      void gather (unsigned x, unsigned y, const unsigned quads[2])
      {
        for (unsigned r=0; r<=quads[1]; r++)
          memcpy(encoder.vertices[r*(quads[0]+1)],grid.displaced()[(y+r)*grid.width+x],(quads[0]+1)*sizeof(float[3]));
      }

      BBox3fa bounds ()
      {
        const Vec3fa lower(encoder.lower[0],encoder.lower[1],encoder.lower[2]), upper(encoder.upper[0],encoder.upper[1],encoder.upper[2]);
        hitBounds.extend(lower.x,lower.y,lower.z);
        hitBounds.extend(upper.x,upper.y,upper.z);
        return BBox3fa(lower,upper);
      }

      const CompressionPlan& plan;
      const SharedVertices& shared;
      Allocator alloc;
      PatchGrid grid;
      cbvh::VertEncoder encoder;
      mvector<uint8_t> bytes;      //!< of the patch's blocks
      std::vector<size_t> starts;  //!< of each in bytes
    };
  }
}
