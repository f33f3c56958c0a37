// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "stored_triangles.h"
#include "../base/primitive_type.h"
#include "../embree/scene.h"
#include "../vert/scalar_block.h"
#include "surface_blocks.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace embree
{
  namespace cbvh
  {
    namespace
    {
      /*! Calls closure(block) for all blocks below a node. */
      template<typename Closure>
      void forEachBlock (BVH4::NodeRef ref, const Closure& closure)
      {
        if (ref == BVH4::emptyNode) return;
        if (!ref.isLeaf()) {
          for (size_t i=0; i<4; i++) forEachBlock(ref.getAABBNode()->child(i),closure);
          return;
        }
        size_t type;
        const void* block = ref.leaf(type);
        if (type != VERT_BLOCK) throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry is not stored as cVERT as a whole: only that hands out triangles");
        closure((const VertHeader*)block);
      }

      template<typename Closure>
      void forEachBlock (const SurfaceBlocks& blocks, const Closure& closure) {
        for (const PrimRef& part : blocks.parts) forEachBlock(BVH4::NodeRef(part.ID()),closure);
      }

      /*! a block, decoded, with the parameters of its vertices */
      struct DecodedBlock
      {
        ScalarVertBlock vertices;
        float parameters[ScalarVertBlock::maxSide*ScalarVertBlock::maxSide][2];

        explicit DecodedBlock (const VertHeader* block)
          : vertices(block)
        {
          const uint32_t quads[2] = { patchQuadsX(block->patchQuads),patchQuadsY(block->patchQuads) }, x0 = vertX(block->region), y0 = vertY(block->region);
          const bool isCut = hasEdges(block->boxForm);
          const VertEdges edges = edgesOf(block);
          for (uint32_t j=0, i=0; j<=vertices.quadsY; j++)
            for (uint32_t k=0; k<=vertices.quadsX; k++, i++)
            {
              const uint32_t x = x0+k, y = y0+j;
              const uint32_t rateX = isCut && y == 0 ? vertRate(edges,0) : isCut && y == quads[1] ? vertRate(edges,2) : quads[0];
              const uint32_t rateY = isCut && x == 0 ? vertRate(edges,3) : isCut && x == quads[0] ? vertRate(edges,1) : quads[1];
              parameters[i][0] = 0.5f*float(vertCornerU(edges)) + vertParameter<float>(x,quads[0],rateX);
              parameters[i][1] = 0.5f*float(vertCornerV(edges)) + vertParameter<float>(y,quads[1],rateY);
            }
        }
      };

      /*! Calls closure(x, y, number) for the quads of a block that numbers them. */
      template<typename Closure>
      void forEachQuad (const VertHeader* block, const Closure& closure)
      {
        for (uint32_t y=0; y<vertQuadsY(block->region); y++)
          for (uint32_t x=0; x<vertQuadsX(block->region); x++) closure(x,y,numberOfQuad(block,x,y));
      }

      /*! the triangles of a primitive that a hit may be on, and which it is most likely */
      class Search
      {
      public:
        Search (float u, float v, const float* Ng, RTCCompressedTriangle& best) : u(u), v(v), Ng(Ng), best(best) {}

        bool found () const { return hasBest; }

        /*! a block that has it */
        void look (const VertHeader* block, uint32_t primID)
        {
          if (hasNumbers(block->boxForm)) lookForPrimitive(block,primID);
          else lookForParameters(block);
        }

      private:
        /*! The triangles of a quad, or one of them, in the application's order of its vertices. */
        void lookForPrimitive (const VertHeader* block, uint32_t primID)
        {
          const uint32_t form = block->patchQuads;
          const ScalarVertBlock vertices(block);
          slack = slackOf(u) + slackOf(v);
          forEachQuad(block,[&](uint32_t x, uint32_t y, uint32_t number) {
              const float* const corners[4] = { vertices.vertex(x,y),vertices.vertex(x+1,y),vertices.vertex(x+1,y+1),vertices.vertex(x,y+1) };
              for (bool isSecond : { false,true }) {
                if (primitiveOfNumber(form,number,isSecond) != primID || (isSecond && isOneTriangle(form))) continue;
                const float* p[3];
                float s[3] = { 0,1,0 }, t[3] = { 0,0,1 };
                for (uint32_t i=0; i<3; i++) {
                  const uint32_t around[] = { isSecond ? 2u : 0u,isSecond ? 3u : 1u,isSecond ? 1u : 3u }; // as ownParameters counts them
                  p[i] = corners[around[(i + turnOfTriangle(form,isSecond)) % 3]];
                  if (!isOfTriangles(form) && isSecond) { s[i] = 1-s[i]; t[i] = 1-t[i]; }
                }
                consider(p,s,t);
              }
            });
        }

        void lookForParameters (const VertHeader* block)
        {
          const uint32_t quadsX = patchQuadsX(block->patchQuads), quadsY = patchQuadsY(block->patchQuads);
          const VertEdges edges = edgesOf(block);
          const double x = (double(u) - 0.5*vertCornerU(edges))*quadsX - vertX(block->region), y = (double(v) - 0.5*vertCornerV(edges))*quadsY - vertY(block->region);
          /* parameters at edges of lower rates are elsewhere, by up to one of their quads */
          const double reachX = reach(block,edges,quadsX,0,u), reachY = reach(block,edges,quadsY,1,v);
          if (!(x >= -reachX && x <= vertQuadsX(block->region)+reachX && y >= -reachY && y <= vertQuadsY(block->region)+reachY)) return;
          const DecodedBlock decoded(block);
          const uint32_t x0 = first(x-reachX), x1 = last(x+reachX,decoded.vertices.quadsX), y0 = first(y-reachY), y1 = last(y+reachY,decoded.vertices.quadsY);
          slack = std::max(slackOf(u)*quadsX,slackOf(v)*quadsY);
          for (uint32_t j=y0; j<y1; j++)
            for (uint32_t i=x0; i<x1; i++) {
              const uint32_t width = decoded.vertices.quadsX+1, a = j*width + i;
              const uint32_t corners[2][3] = { { a,a+1,a+width },{ a+width,a+1,a+width+1 } };
              for (const uint32_t (&triangle)[3] : corners) {
                const float* p[3];
                float s[3], t[3];
                for (int c=0; c<3; c++) {
                  p[c] = decoded.vertices.vertices[triangle[c]];
                  s[c] = decoded.parameters[triangle[c]][0];
                  t[c] = decoded.parameters[triangle[c]][1];
                }
                consider(p,s,t);
              }
            }
        }

        /*! what a parameter may have lost to rounding */
        static double slackOf (float parameter) { return 4.0*std::numeric_limits<float>::epsilon()*(1.0 + std::fabs(double(parameter))); }

        static double reach (const VertHeader* block, VertEdges edges, uint32_t quads, int d, float parameter)
        {
          double reach = slackOf(parameter)*quads;
          if (hasEdges(block->boxForm)) reach += double(quads)/std::min(vertRate(edges,d),vertRate(edges,d+2));
          return reach;
        }

        static uint32_t first (double x) { return uint32_t(std::max(std::floor(x),0.0)); }
        static uint32_t last (double x, uint32_t quads) { return uint32_t(std::min(std::floor(x)+1.0,double(quads))); }

        /*! vertices, and their parameters */
        void consider (const float* const p[3], const float vertexU[3], const float vertexV[3])
        {
          double s[3], t[3];
          for (int c=0; c<3; c++) {
            if (!(std::isfinite(p[c][0]) && std::isfinite(p[c][1]) && std::isfinite(p[c][2]))) return;
            s[c] = vertexU[c];
            t[c] = vertexV[c];
          }
          /* how far outside the hit is, in parts of the triangle */
          const double area = (s[1]-s[0])*(t[2]-t[0]) - (s[2]-s[0])*(t[1]-t[0]);
          if (area == 0) return; // collapsed where edges are stitched
          const double w1 = ((u-s[0])*(t[2]-t[0]) - (s[2]-s[0])*(v-t[0]))/area, w2 = ((s[1]-s[0])*(v-t[0]) - (u-s[0])*(t[1]-t[0]))/area;
          const double outside = std::max(0.0,-std::min(std::min(w1,w2),1.0-w1-w2));
          if (outside > slack) return;
          const double turned = Ng ? angle(p) : outside;
          if (hasBest && turned >= bestTurned) return;
          hasBest = true;
          bestTurned = turned;
          for (int c=0; c<3; c++) {
            memcpy(best.vertices[c],p[c],sizeof(best.vertices[c]));
            best.u[c] = vertexU[c];
            best.v[c] = vertexV[c];
          }
        }

        /*! of its normal to Ng, as 1 less the square of the cosine */
        double angle (const float* const p[3]) const
        {
          double a[3], b[3], n[3], dot = 0, nn = 0, gg = 0;
          for (int k=0; k<3; k++) { a[k] = double(p[1][k])-p[0][k]; b[k] = double(p[2][k])-p[0][k]; }
          for (int k=0; k<3; k++) {
            n[k] = a[(k+1)%3]*b[(k+2)%3] - a[(k+2)%3]*b[(k+1)%3];
            dot += n[k]*Ng[k];
            nn += n[k]*n[k];
            gg += double(Ng[k])*Ng[k];
          }
          return nn > 0 && gg > 0 ? 1.0 - dot*dot/(nn*gg) : 2.0;
        }

        const float u, v;
        const float* const Ng;
        RTCCompressedTriangle& best;
        bool hasBest = false;
        double slack = 0, bestTurned = 0;
      };
    }

    BlockIndex::BlockIndex (const SurfaceBlocks& surface)
    {
      blocks.reserve(surface.numPrimitives);
      forEachBlock(surface,[&](const VertHeader* block) { blocks.push_back(block); });
      std::sort(blocks.begin(),blocks.end(),[](const VertHeader* a, const VertHeader* b) { return a->primID < b->primID; });
      for (size_t i=0; i<blocks.size(); i++)
      {
        if (!hasNumbers(blocks[i]->boxForm)) continue;
        forEachQuad(blocks[i],[&](uint32_t, uint32_t, uint32_t number) {
            const uint32_t last = primitiveOfNumber(blocks[i]->patchQuads,number,true);
            if (last >= blockOf.size()) blockOf.resize(std::max(size_t(last)+1,2*blockOf.size()),uint32_t(none));
            blockOf[number] = blockOf[last] = uint32_t(i);
          });
      }
      blockOf.shrink_to_fit();
    }

    bool BlockIndex::find (uint32_t primID, float u, float v, const float* Ng, RTCCompressedTriangle& triangle) const
    {
      Search search(u,v,Ng,triangle);
      if (!blockOf.empty()) {
        if (primID < blockOf.size() && blockOf[primID] != none) search.look(blocks[blockOf[primID]],primID);
        return search.found();
      }
      for (auto i=std::lower_bound(blocks.begin(),blocks.end(),primID,[](const VertHeader* block, uint32_t id) { return block->primID < id; });
           i != blocks.end() && (*i)->primID == primID; i++)
        search.look(*i,primID);
      return search.found();
    }

    void forEachPart (const SurfaceBlocks& blocks, const std::function<bool(const RTCCompressedPart&)>& closure)
    {
      bool goesOn = true;
      forEachBlock(blocks,[&](const VertHeader* block) {
          if (!goesOn) return;
          RTCCompressedPart part = RTCCompressedPart();
          part.primID = block->primID;
          part.width = vertQuadsX(block->region)+1;
          part.height = vertQuadsY(block->region)+1;
          if (!hasNumbers(block->boxForm)) {
            const DecodedBlock decoded(block);
            part.vertices = decoded.vertices.vertices[0];
            part.parameters = decoded.parameters[0];
            goesOn = closure(part);
            return;
          }
          const ScalarVertBlock decoded(block);
          uint32_t primIDs[2*vertBlockQuads*vertBlockQuads], n = 0;
          forEachQuad(block,[&](uint32_t, uint32_t, uint32_t number) {
              primIDs[n++] = number;
              if (isOfTriangles(block->patchQuads)) primIDs[n++] = primitiveOfNumber(block->patchQuads,number,true);
            });
          part.vertices = decoded.vertices[0];
          part.primIDs = primIDs;
          part.primitivesPerQuad = isOfTriangles(block->patchQuads) ? 2 : 1;
          goesOn = closure(part);
        });
    }
  }
}
