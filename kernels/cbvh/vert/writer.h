// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writer of cVERT: the vertices of a patch are snapped to their lattices, those on its border come from the faces
 * that own them, and blocks hold them exactly. A patch is written in strips of rows, so that a patch of any rate takes
 * no more memory than one of 256 x 256 quads, and several tasks may write it. Who writes flushes the store behind the last patch. */

#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../surface/plan.h"
#include "../surface/source.h"
#include "../surface/shared_border.h"
#include "encoder.h"
#include "numbers_encoder.h"
#include "snapped_vertices.h"
#include "validate.h"

namespace embree
{
  namespace isa
  {
    class VertWriter
    {
    public:
      VertWriter (const CompressionPlan& plan, Device* device, BlockStore& store, cbvh::BuildStatistics& statistics)
        : plan(plan), store(store), statistics(statistics), given(device) {}

      /*! rows of a patch that are written together, a multiple of a block's: of most patches all */
      static unsigned rowsOfStrip (const SurfacePatch& patch) {
        return max(fullStrip*fullStrip/(patch.quads[0]*cbvh::vertBlockQuads),1u)*cbvh::vertBlockQuads;
      }

      /*! Writes the blocks of a patch that is one strip. evaluated: its vertices as the face evaluates them, if they are known, or null. */
      template<typename Patch>
      void write (Patch& patch, const float (*evaluated)[3])
      {
        const PatchPart all = { 0,patch.quads[0],0,patch.quads[1] };
        VertexGrid* grid = &given;
        if (evaluated) given.set(patch.quads[0],patch.quads[1],evaluated);
        else grid = &patch.evaluate(patch.quads[0],patch.quads[1],all);
        writeStrip(patch,all,*grid);
      }

      /*! Writes the blocks of a strip. begin, end: its first and last row as they were evaluated for both strips that have it, or null at
       *  the border of the patch: a displacement may answer differently the second time. */
      template<typename Patch>
      void write (Patch& patch, const PatchPart& strip, const float (*begin)[3], const float (*end)[3])
      {
        VertexGrid& grid = patch.evaluate(patch.quads[0],patch.quads[1],strip);
        if (begin) memcpy(grid.displaced(),begin,grid.width*sizeof(*begin));
        if (end) memcpy(grid.displaced()[(grid.height-1)*grid.width],end,grid.width*sizeof(*end));
        writeStrip(patch,strip,grid);
      }

    private:
      static const unsigned fullStrip = 256; //!< rows of a patch of as many columns

      template<typename Patch>
      void writeStrip (const Patch& patch, const PatchPart& strip, VertexGrid& grid)
      {
        const cbvh::WorldLattice lattice(patch.latticeExponent());
        for (int s=0; s<4; s++) sideRates[s] = patch.side(s).rate;
        snapVertices(patch,strip,lattice,grid);
        for (unsigned y=strip.y0; y<strip.y1; y+=cbvh::vertBlockQuads)
          for (unsigned x=0; x<patch.quads[0]; x+=cbvh::vertBlockQuads)
            writeBlock(patch,x,y,strip.y0,grid,lattice.spacing);
        store.flushIfFull();
      }

      void writeBlock (const SurfacePatch& patch, unsigned x, unsigned y, unsigned firstRow, VertexGrid& grid, float spacing)
      {
        const unsigned w = min(cbvh::vertBlockQuads,patch.quads[0]-x), h = min(cbvh::vertBlockQuads,patch.quads[1]-y);
        for (unsigned r=0; r<=h; r++)
          memcpy(encoder.vertices[r*(w+1)],grid.displaced()[(y-firstRow+r)*grid.width+x],(w+1)*sizeof(float[3]));
        if (patch.numbers) numbers.set(*patch.numbers,x,y,w,h);
        const cbvh::VertPlacement at = patch.numbers ? cbvh::VertPlacement(cbvh::vertRegion(w,h,x,y),numbers.form,numbers.pattern) : placement(patch,x,y,w,h);
        cbvh::VertStatistics block;
        uint8_t* const bytes = store.begin(cbvh::VertEncoder::maxBytes + NumbersEncoder::maxBytes);
        size_t size = encoder.encode(at,spacing,bytes,block);
        if (size == 0) {
          statistics.sums.numInvalidQuads += size_t(w)*h;
          return;
        }
        cbvh::VertHeader* header = (cbvh::VertHeader*)bytes;
        header->surface = patch.surface;
        header->primID = patch.primID;
        if (patch.numbers) size = numbers.finish(header,size);
        addBlock(header,size,block);
        if (patch.numbers) addMeshQuads(patch,size_t(w)*h);
        const Vec3fa lower(encoder.lower[0],encoder.lower[1],encoder.lower[2]), upper(encoder.upper[0],encoder.upper[1],encoder.upper[2]);
        store.hitBounds.extend(lower.x,lower.y,lower.z);
        store.hitBounds.extend(upper.x,upper.y,upper.z);
        store.end(size,BBox3fa(lower,upper),cbvh::VERT_BLOCK,cbvh::readBehindVert);
      }

      /*! bytes: of the block, without those that align the next */
      void addBlock (const cbvh::VertHeader* header, size_t bytes, const cbvh::VertStatistics& block)
      {
        const cbvh::VertLayout layout = cbvh::vertLayout(header->region,header->boxForm);
        const size_t stride = (bytes + cbvh::blockAlignment-1) & ~size_t(cbvh::blockAlignment-1);
        const size_t nodesEnd = block.raw ? layout.margins : layout.cell;
        const size_t quads = size_t(cbvh::vertQuadsX(header->region))*size_t(cbvh::vertQuadsY(header->region));
        RTCCompressionStatistics& sums = statistics.sums;
        sums.frameBytes += layout.margins;
        sums.nodeBytes += nodesEnd - layout.margins;
        sums.leafBytes += stride - nodesEnd;
        sums.numBlocks++;
        sums.numRawBlocks += block.raw;
        sums.numQuads += quads;
        sums.numInvalidQuads += block.invalidQuads;
        sums.maxVertexSpacing = max(sums.maxVertexSpacing,cbvh::vertSpacing(header->word));
        if (plan.kind() != cbvh::Kind::VERT) sums.numExactQuads += quads;
      }

      void addMeshQuads (const SurfacePatch& patch, size_t quads)
      {
        statistics.sums.numMeshQuads += quads;
        if (min(patch.quads[0],patch.quads[1]) < looseSide) statistics.sums.numLooseQuads += quads;
      }

      /*! where a block is, with the patch's edges if it needs them */
      cbvh::VertPlacement placement (const SurfacePatch& patch, unsigned x, unsigned y, unsigned w, unsigned h) const
      {
        const uint32_t region = cbvh::vertRegion(w,h,x,y), quads = cbvh::vertPatch(patch.quads[0],patch.quads[1]);
        const bool touches[4] = { y == 0,x+w == patch.quads[0],y+h == patch.quads[1],x == 0 };
        bool needsEdges = patch.corner[0] != 0 || patch.corner[1] != 0;
        for (int s=0; s<4; s++) needsEdges |= touches[s] && sideRates[s] != patch.quads[s & 1];
        if (!needsEdges) return cbvh::VertPlacement(region,quads);
        return cbvh::VertPlacement(region,quads,cbvh::vertEdges(sideRates[0],sideRates[1],sideRates[2],sideRates[3],patch.corner[0],patch.corner[1]));
      }

      template<typename Patch>
      void snapVertices (const Patch& patch, const PatchPart& strip, const cbvh::WorldLattice& lattice, VertexGrid& grid)
      {
        float (*p)[3] = grid.displaced();
        memcpy(grid.undisplaced(),p,grid.width*grid.height*sizeof(*p)); // as the face evaluates them
        const float (*own)[3] = grid.undisplaced();
        for (size_t y=strip.y0 == 0; y<grid.height - (strip.y1 == patch.quads[1]); y++)
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
        shareBorder(patch,patch.quads[0],patch.quads[1],strip,own,p,[&](const float mine[3], const float position[3], const float stored[3]) {
            statistics.addBorderVertex(mine,position,stored);
          });
        statistics.sums.numFlippedQuads += countFlipped(grid,own,p);
      }

      /*! quads with a triangle that the lattice turned by more than 90 degrees */
      static size_t countFlipped (const VertexGrid& grid, const float (*own)[3], const float (*stored)[3])
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

      const CompressionPlan& plan;
      BlockStore& store;
      cbvh::BuildStatistics& statistics;
      VertexGrid given;             //!< vertices that were evaluated before
      unsigned sideRates[4];        //!< of the patch, as its faces share them
      cbvh::VertEncoder encoder;
      NumbersEncoder numbers;
    };
  }
}
