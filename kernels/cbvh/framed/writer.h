// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds the top-level primitives of one patch: blocks, or, where it cannot be
 * compressed, Embree's GridSOA. A task owns one builder and reuses its memory from
 * patch to patch. */

#include "../../bvh/bvh.h"
#include "../../geometry/grid_soa.h"
#include "../surface/shared_border.h"
#include "../base/primitive_type.h"
#include "../scene/statistics.h"

namespace embree
{
  namespace isa
  {
    /*! rounded outwards */
    inline BBox3fa toBBox (const cbvh::WorldBounds& b)
    {
      auto below = [](double x) { const float f = float(x); return double(f) <= x ? f : std::nextafter(f,-std::numeric_limits<float>::infinity()); };
      return BBox3fa(Vec3fa(below(b.lower[0]),below(b.lower[1]),below(b.lower[2])),Vec3fa(-below(-b.upper[0]),-below(-b.upper[1]),-below(-b.upper[2])));
    }

    class PatchBuilder
    {
    public:
      typedef FastAllocator::CachedAllocator Allocator;

      /*! GRID cuts patches into grids of 8 x 8 quads */
      static const unsigned gridQuads = 8;

      cbvh::BuildStatistics statistics;
      cbvh::WorldBounds hitBounds;  //!< of all that a ray may hit in the blocks

      /*! shared: borders of faces, if faces may be stored exactly; else null */
      PatchBuilder (const CompressionPlan& plan, const SharedVertices* shared, Scene* scene, const Allocator& alloc)
        : plan(plan), shared(shared), scene(scene), alloc(alloc), grid(scene->device), own(scene->device,0), vertices(scene->device,0), scratch(scene->device,0), encoded(scene->device,0) {}

      static unsigned numGrids (Vec2i resolution) {
        return ((resolution.x-2)/gridQuads + 1)*((resolution.y-2)/gridQuads + 1);
      }

      /*! smallest frame level at which no leaf of the patch is thicker than the bound */
      unsigned boundedFrameLevel (size_t face, const PatchOfFace& patch)
      {
        const SubdivPatch1Base base = patch.make(plan.mesh,plan.geomID,face);
        const unsigned level = plan.level(patch.rate);
        PatchTiling evaluated;
        for (unsigned n=0; n<level; n++)
        {
          const PatchTiling tiling = plan.tiling(patch.rate,n);
          if (tiling.quadsX() != evaluated.quadsX() || tiling.quadsY() != evaluated.quadsY())
            evaluate(base,face,patch,tiling);
          evaluated = tiling;
          cbvh::BlockStatistics worst;
          for (unsigned i=0; i < tiling.size() && worst.maxThickness <= plan.settings.maxError; i++)
          {
            Encoding e(plan.kind(),tiling,i);
            encoded.resize(e.layout.bytes/sizeof(Vec3fa)+1);
            gather(e);
            cbvh::BlockEncoder encoder(e.kind,e.height,vertexData(),scratch.data());
            if (encoder.fit(e.corners)) encoder.encode((cbvh::Block*)encoded.data(),e.x,e.y,worst);
          }
          if (worst.maxThickness <= plan.settings.maxError) return n;
        }
        return level;
      }

      /*! Writes the primitives of a patch, the blocks of a tiling; a dropped one has no
       *  reference, see isDropped. Returns their number; 0 where the patch is better stored
       *  exactly, and may be. */
      size_t buildBlocks (size_t face, const PatchOfFace& patch, const PatchTiling& tiling, PrimRef* out)
      {
        const SubdivPatch1Base base = patch.make(plan.mesh,plan.geomID,face);
        evaluate(base,face,patch,tiling);
        /* a node has no code for a child without surface: where quads are left out, leaves say so */
        float lower[3], upper[3];
        const bool hasHoles = !grid.bound(lower,upper);
        const cbvh::Kind kind = hasHoles && !cbvh::describe(plan.kind()).takesHoles ? kindForHoles : plan.kind();
        const uint32_t sharpSides = sharpSidesOf(plan.mesh,face,patch);
        const size_t count = tiling.size(), stride = cbvh::blockLayout(uint32_t(kind),tiling.height).stride;
        encoded.resize(count*stride/sizeof(Vec3fa));
        cbvh::BuildStatistics ofPatch;
        cbvh::WorldBounds hitBoundsOfPatch;
        if (!hasHoles) { /* what is in the bounds of the vertices need not be looked at */
          hitBoundsOfPatch.extend(lower[0],lower[1],lower[2]);
          hitBoundsOfPatch.extend(upper[0],upper[1],upper[2]);
        }
        fit = cbvh::LeafFit();
        const size_t quads = size_t(tiling.quadsX())*size_t(tiling.quadsY());
        const size_t edges = 4*(size_t(tiling.quadsX())+size_t(tiling.quadsY())); // two of each quad on the border, where it is cut into leaves
        for (size_t k=0; k<count; k++) {
          const unsigned y = unsigned(k) % tiling.y, x = (y + unsigned(k)/tiling.y) % tiling.x; // by diagonals: the first ones tell of the whole patch
          Encoding e(kind,tiling,y*tiling.x+x);
          e.sharpSides = sharpSides & e.sidesOfPatch();
          out[e.index] = buildBlock(base,e,(cbvh::Block*)((char*)encoded.data()+e.index*stride),ofPatch,hitBoundsOfPatch);
          if (shared && (ofPatch.refusedQuads || fit.isGivenUp(quads,edges))) return 0;
        }
        if (shared && fit.isPoor()) return 0;
        if (kind != plan.kind()) statistics.quadsForHoles += quads;
        statistics.merge(ofPatch);
        hitBounds.extend(hitBoundsOfPatch);
        place(count,stride,out);
        return count;
      }

      /*! The vertices of the last patch as its face evaluates them, if it was evaluated as so many quads; else null.
       *  Of a builder that shares borders. */
      const float (*evaluated (unsigned quadsX, unsigned quadsY) const)[3] {
        return grid.width == quadsX+1 && grid.height == quadsY+1 ? (const float(*)[3])own.data() : nullptr;
      }

      /*! patch as stock Embree has it */
      size_t buildGrids (const SubdivPatch1Base& patch, PrimRef* out)
      {
        size_t n = 0;
        const unsigned x1 = patch.grid_u_res-1, y1 = patch.grid_v_res-1;
        for (unsigned y=0; y<y1; y+=gridQuads)
          for (unsigned x=0; x<x1; x+=gridQuads)
            out[n++] = buildGrid(patch,x,min(x+gridQuads,x1),y,min(y+gridQuads,y1),statistics);
        statistics.highRateQuads += plan.compresses() ? size_t(x1)*size_t(y1) : 0;
        return n;
      }

      static PrimRef dropped () { return PrimRef(BBox3fa(Vec3fa(zero),Vec3fa(zero)),size_t(0)); }
      static bool isDropped (const PrimRef& prim) { return prim.ID() == 0; }

    private:
      static const size_t maxPieceBytes = 1 << 20;
      static const cbvh::Kind kindForHoles = cbvh::Kind::LEAF; //!< of patches whose own kind cannot leave a quad out

      /*! one block of a patch */
      struct Encoding
      {
        cbvh::Kind kind;
        PatchTiling tiling;
        unsigned height;
        unsigned index, x, y;   //!< position in the tiling
        uint32_t sharpSides = 0;
        cbvh::BlockLayout layout;
        float corners[4][3];    //!< that the frame aligns to

        Encoding (cbvh::Kind kind, const PatchTiling& tiling, unsigned index)
          : kind(kind), tiling(tiling), height(tiling.height), index(index), x(index % tiling.x), y(index / tiling.x), layout(cbvh::blockLayout(uint32_t(kind),height)) {}

        size_t width () const { return (size_t(1) << height) + 1; }

        /*! bits of sides of the patch that the block is on */
        uint32_t sidesOfPatch () const {
          return uint32_t(y == 0) | uint32_t(x+1 == tiling.x) << 1 | uint32_t(y+1 == tiling.y) << 2 | uint32_t(x == 0) << 3;
        }
      };

      static const size_t placedLater = 1; //!< reference of a block that place() copies

      void evaluate (const SubdivPatch1Base& base, size_t face, const PatchOfFace& patch, const PatchTiling& tiling)
      {
        if (!shared) { grid.eval(base,plan.mesh,tiling.quadsX(),tiling.quadsY()); return; }
        grid.evalPart(base,plan.mesh,tiling.quadsX(),tiling.quadsY(),{ 0,tiling.quadsX(),0,tiling.quadsY() });
        const size_t count = 3*grid.width*grid.height;
        own.resize(count);
        memcpy(own.data(),grid.displaced(),count*sizeof(float));
        float rate[4];
        shareBorder(*shared,face,patch,tiling.quadsX(),tiling.quadsY(),(const float(*)[3])own.data(),grid.displaced(),rate,
                    [&](const float mine[3], const float position[3], const float stored[3]) { statistics.addBorderVertex(mine,position,stored); });
        grid.spreadBorders(patch.rate,grid.undisplaced());
        grid.spreadBorders(rate,grid.displaced());
      }

      /*! Copies blocks to memory of the BVH's. One piece a patch: small pieces cost the allocator's rounding
       *  each; several for a large patch, as it takes none above 2 MiB. */
      void place (size_t count, size_t stride, PrimRef* out)
      {
        const size_t piece = max(maxPieceBytes/stride,size_t(1));
        for (size_t begin=0; begin<count; begin+=piece)
        {
          const size_t size = min(piece,count-begin)*stride;
          char* memory = (char*)alloc.malloc1(size,cbvh::blockAlignment);
          memcpy(memory,(const char*)encoded.data()+begin*stride,size);
          for (size_t i=begin; i<min(begin+piece,count); i++)
            if (out[i].ID() == placedLater)
              out[i] = PrimRef(out[i].bounds(),size_t(BVH4::encodeTypedLeaf(memory+(i-begin)*stride,cbvh::FRAMED_BLOCK)));
        }
      }

      const float (*vertexData () const)[3] { return (const float(*)[3])vertices.data(); }

      /*! vertices and corners of a block */
      void gather (Encoding& e)
      {
        const size_t w = e.width();
        const size_t x0 = size_t(e.x) << e.height, y0 = size_t(e.y) << e.height;
        vertices.resize(3*w*w);
        scratch.resize((cbvh::BlockEncoder::scratchBytes(e.height)+sizeof(Vec3fa)-1)/sizeof(Vec3fa));
        for (size_t r=0; r<w; r++)
          memcpy(&vertices[3*r*w],grid.displaced()[(y0+r)*grid.width+x0],3*w*sizeof(float));
        float (*aligned)[3] = cbvh::describe(e.kind).alignsToLimit ? grid.undisplaced() : grid.displaced();
        for (size_t c=0; c<4; c++)
          memcpy(e.corners[c],aligned[(y0 + (c>>1)*(w-1))*grid.width + x0 + (c&1)*(w-1)],sizeof(float[3]));
      }

      size_t countFinite (const Encoding& e) const
      {
        size_t finite = 0;
        for (size_t i=0; i<e.width()*e.width(); i++) finite += cbvh::isFinite(vertexData()[i]);
        return finite;
      }

      PrimRef buildBlock (const SubdivPatch1Base& patch, Encoding& e, cbvh::Block* block, cbvh::BuildStatistics& ofPatch, cbvh::WorldBounds& hitBoundsOfPatch)
      {
        gather(e);
        const size_t count = e.width()*e.width(), finite = countFinite(e);
        if (finite == 0) return drop(e,ofPatch);

        cbvh::BlockEncoder encoder(e.kind,e.height,vertexData(),scratch.data());
        const bool fits = encoder.fit(e.corners);
        const bool refused = !fits || encoder.isDegenerate();
        const unsigned quads = 1u << e.height;
        if (refused && shared) {
          ofPatch.refusedQuads += size_t(quads)*size_t(quads);
          return dropped(); // of a patch that is stored exactly
        }
        if (refused && finite == count && !grid.stitched) {
          ofPatch.refusedQuads += size_t(quads)*size_t(quads);
          return buildGrid(patch,e.x*quads,(e.x+1)*quads,e.y*quads,(e.y+1)*quads,ofPatch);
        }
        if (!fits) return drop(e,ofPatch);
        if (refused && e.kind != cbvh::Kind::GRID) {
          /* GridSOA takes no holes, and on stitched borders it has other vertices than the
           * blocks around, but cGRID's triangles are as exact in any frame */
          ofPatch.refusedQuads += size_t(quads)*size_t(quads);
          Encoding exact(cbvh::Kind::GRID,e.tiling,e.index);
          cbvh::Block* memory = (cbvh::Block*)alloc.malloc1(exact.layout.stride,cbvh::blockAlignment);
          const PrimRef prim = buildBlock(patch,exact,memory,ofPatch,hitBoundsOfPatch);
          if (isDropped(prim)) return prim;
          return PrimRef(prim.bounds(),size_t(BVH4::encodeTypedLeaf(memory,cbvh::FRAMED_BLOCK)));
        }

        cbvh::BlockStatistics blockStatistics;
        blockStatistics.maxThickness = statistics.sums.maxLeafThickness; // leaves that are no thicker need no look
        encoder.encode(block,e.x,e.y,blockStatistics,e.sharpSides);
        block->geomID = patch.geomID();
        block->primID = patch.primID();
        block->tiling = cbvh::blockTiling(e.tiling.x-1,e.tiling.y-1,uint32_t(2*patch.getUV(0).x),uint32_t(2*patch.getUV(0).y));
        ofPatch.addBlock(e.kind,e.height,blockStatistics);
        fit.merge(blockStatistics.fit);
        encoder.extendByHits(hitBoundsOfPatch,block);
        return PrimRef(toBBox(encoder.surfaceBounds()),placedLater);
      }

      static PrimRef drop (const Encoding& e, cbvh::BuildStatistics& ofPatch)
      {
        ofPatch.sums.numInvalidQuads += size_t(1) << (2*e.height);
        return dropped();
      }

      PrimRef buildGrid (const SubdivPatch1Base& patch, unsigned x0, unsigned x1, unsigned y0, unsigned y1, cbvh::BuildStatistics& sum)
      {
        BBox3fa bounds;
        GridSOA* soa = GridSOA::create(&patch,1,x0,x1,y0,y1,scene,alloc,&bounds);
        sum.sums.gridBytes += offsetof(GridSOA,data) + soa->rootOffset + sizeof(BVH4::NodeRef);
        sum.sums.numGridQuads += size_t(x1-x0)*size_t(y1-y0);
        return PrimRef(bounds,size_t(BVH4::encodeTypedLeaf(soa,cbvh::GRID_SOA_ROOT)));
      }

    private:
      const CompressionPlan& plan;
      const SharedVertices* shared;
      Scene* scene;
      Allocator alloc;
      PatchGrid grid;
      cbvh::LeafFit fit;        //!< of the patch
      mvector<float> own;       //!< vertices of a patch as its face evaluates them
      mvector<float> vertices;  //!< of one block
      mvector<Vec3fa> scratch;  //!< the encoder's, aligned
      mvector<Vec3fa> encoded;  //!< blocks of a patch, or one that is encoded to see how thick it gets
    };
  }
}
