// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of a block: vertices -> frame -> bounds bottom-up -> nodes top-down ->
 * leaves. Top-down, because a node's planes are relative to what its parent
 * decodes to, not to what the parent holds: rounding cannot add up. */

#include "block.h"
#include "frame.h"
#include "leaf_codec.h"
#include <cstring>
#include <cmath>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    struct BlockStatistics
    {
      uint32_t invalidQuads = 0;   //!< with a vertex that is not finite
      uint32_t solidLeaves = 0;
      bool affine = false;
      float maxThickness = 0;      //!< world units
    };

    /*! area of a quad in the frame, relative to that of a leaf, below which it is much
     *  smaller: leaves 16 times as wide as their quads are no picture of them */
    static constexpr double minQuadArea = 1.0/256;

    class BlockEncoder
    {
    public:
      /*! bytes of scratch memory for blocks of this height, 16-byte aligned */
      static size_t scratchBytes(uint32_t height) {
        BlockEncoder encoder(Kind::LEAF,height,nullptr,nullptr);
        return encoder.layoutScratch(nullptr);
      }

      /*! height:  log2 of quads along a side;
       *  vertices: (2^height+1)^2 world positions, row by row, kept by reference;
       *  scratch: see scratchBytes, kept by reference */
      BlockEncoder(Kind kind, uint32_t height, const float (*vertices)[3], void* scratch)
        : kind(kind), height(height), width((1u << height)+1), vertices(vertices) { layoutScratch((char*)scratch); }

      /*! Fits the block's frame; false when nothing is left to encode: no quad is
       *  finite, or floats cannot hold a frame.
       *  corners: world positions to align to, (0,0), (1,0), (0,1), (1,1) */
      bool fit(const float corners[4][3])
      {
        size_t count = 0;
        for (uint32_t i=0; i<width*width; i++)
          if (isFinite(i)) { memcpy(finite[count++],vertices[i],sizeof(float[3])); }
        if (count == 0) return false;
        allFinite = count == width*width;

        float aligned[4][3];
        memcpy(aligned,corners,sizeof(aligned));
        bool ok = true;
        for (int c=0; c<4; c++) ok &= cbvh::isFinite(corners[c]);
        if (!ok) /* no corners to align to: any frame around the vertices */
          for (int c=0; c<4; c++) memcpy(aligned[c],finite[size_t(c)*(count-1)/3],sizeof(float[3]));
        if (!fitFrame(aligned,finite,count,fitted,frame)) return false;
        for (uint32_t i=0; i<width*width; i++)
          frame.transform(vertices[i],local[i]);
        return true;
      }

      /*! Whether leaves would be much larger than most of their quads: the vertices lie on
       *  a line, or some are far away from all others. Better not compressed. */
      bool isDegenerate() const
      {
        const uint32_t quads = 1u << (2*height);
        uint32_t small = 0, valid = 0;
        for (uint32_t m=0; m<quads; m++)
        {
          double quad[4][3];
          gatherQuad(m,quad);
          const double area = 0.5*std::fabs((quad[3][0]-quad[0][0])*(quad[2][1]-quad[1][1]) - (quad[3][1]-quad[0][1])*(quad[2][0]-quad[1][0]));
          small += area*quads < minQuadArea;
          valid += area >= 0; // not NaN
        }
        return frame.degenerate || 2*small > valid;
      }

      /*! Writes frame, info, nodes and leaves; IDs and face parameters are the caller's.
       *  block:  BlockLayout(kind,height).bytes of room, 16-byte aligned;
       *  x, y:   position in the patch, in blocks. */
      void encode(Block* block, uint32_t x, uint32_t y, BlockStatistics& stats)
      {
        block->info = Block::encodeInfo(kind,height,x,y);
        memcpy(block->centre,frame.centre,sizeof(frame.centre));
        memcpy(block->columns,frame.columns,sizeof(frame.columns));
        stats.affine = !frame.projective;

        boundQuads(stats);
        invertW();
        nodes = block->nodes();
        encodeNodes(0,0,NodeBox::root());

        switch (kind) {
        case Kind::LEAF : encodeLeaves(block,stats); break;
        case Kind::VOXEL: voxelThickness(stats); break;
        case Kind::GRID : storeVertices((float*)block->leaves()); break;
        }
      }

    private:
      /*! places the arrays in scratch memory; returns the end */
      size_t layoutScratch(char* scratch)
      {
        const size_t quads = size_t(1) << (2*height), points = size_t(width)*width;
        size_t bytes = 0;
        auto take = [&](size_t n) { const uintptr_t p = uintptr_t(scratch) + bytes; bytes += (n+15) & ~size_t(15); return p; };
        boxes   = (ExactBox*)take((nodesOfLevels(height)+quads)*sizeof(ExactBox));
        local   = (double(*)[3])take(points*3*sizeof(double));
        fitted  = (Double3*)take(points*sizeof(Double3));
        leafBox = (NodeBox*)take(quads*sizeof(NodeBox));
        corner  = (CornerHeights*)take(quads*sizeof(CornerHeights));
        finite  = (float(*)[3])take(points*3*sizeof(float));
        return bytes;
      }

      bool isFinite(uint32_t i) const { return cbvh::isFinite(vertices[i]); }

      uint32_t vertexOfQuad(uint32_t m, int corner) const {
        return (mortonY(m)+(corner>>1))*width + mortonX(m)+(corner&1);
      }

      ExactBox& boxOf(uint32_t level, uint32_t m) { return boxes[nodesOfLevels(level)+m]; }

      void boundQuads(BlockStatistics& stats)
      {
        for (uint32_t m=0; m < 1u << (2*height); m++)
        {
          ExactBox box;
          bool valid = true;
          for (int c=0; c<4; c++) {
            const uint32_t i = vertexOfQuad(m,c);
            valid &= allFinite || isFinite(i);
            if (valid) box.extend(local[i]);
          }
          boxOf(height,m) = valid ? box : ExactBox();
          stats.invalidQuads += !valid;
        }
        for (uint32_t level=height; level-- > 0;)
          for (uint32_t m=0; m < 1u << (2*level); m++)
          {
            ExactBox box;
            for (uint32_t c=0; c<4; c++) box.extend(boxOf(level+1,4*m+c));
            boxOf(level,m) = box;
          }
      }

      void encodeNodes(uint32_t level, uint32_t m, const NodeBox& box)
      {
        if (level == (kind == Kind::GRID && height > 0 ? height-1 : height)) {
          if (kind != Kind::GRID) leafBox[m] = box;
          return;
        }
        const uint32_t word = encodeNode(box,&boxOf(level+1,4*m));
        nodes[nodesOfLevels(level)+m] = word;
        for (uint32_t c=0; c<4; c++)
          encodeNodes(level+1,4*m+c,decodeChild(word,int(c),box));
      }

      void gatherQuad(uint32_t m, double quad[4][3]) const {
        for (int c=0; c<4; c++) memcpy(quad[c],local[vertexOfQuad(m,c)],sizeof(double[3]));
      }

      /*! The z scale that makes the bins thinnest on average. A larger scale makes
       *  every bin of the block thicker, a smaller one leaves more leaves solid, which
       *  then are as thick as their box. */
      uint32_t chooseZScale() const
      {
        double inRange[zScaleCodes] = {}, all = 0;
        for (uint32_t m=0; m < 1u << (2*height); m++)
        {
          if (!corner[m].valid) continue;
          const double required = requiredZScale(leafBox[m],corner[m])*1.0001;
          uint32_t code = 0;
          while (code < zScaleCodes && decodeZScale(code) < required) code++;
          if (code == zScaleCodes) continue;
          inRange[code] += leafBox[m].extent[2];
          all += leafBox[m].extent[2];
        }
        double best = DBL_MAX, held = 0;
        uint32_t bestCode = 0;
        for (uint32_t code=0; code<zScaleCodes; code++) {
          held += inRange[code];
          const double cost = held*decodeZScale(code)/heightBins + (all-held);
          if (cost < best) { best = cost; bestCode = code; }
        }
        return bestCode;
      }

      void encodeLeaves(Block* block, BlockStatistics& stats)
      {
        uint16_t* leaves = (uint16_t*)block->leaves();
        double quad[4][3];
        const uint32_t quads = 1u << (2*height);
        for (uint32_t m=0; m<quads; m++)
        {
          corner[m].valid = false;
          if (boxOf(height,m).empty()) continue;
          gatherQuad(m,quad);
          corner[m] = extrapolateQuad(leafBox[m],quad);
        }
        const uint32_t code = chooseZScale();
        const float zScale = decodeZScale(code);
        block->info |= code << 28;
        for (uint32_t m=0; m<quads; m++)
        {
          leaves[m] = emptyLeaf;
          if (boxOf(height,m).empty()) continue;
          gatherQuad(m,quad);
          leaves[m] = encodeLeaf(leafBox[m],zScale,quad,corner[m]);
          const LeafBins bins(leafBox[m],zScale);
          const bool solid = leaves[m] == solidLeaf;
          stats.solidLeaves += solid;
          const double slope[2] = {
            0.5*(corner[m].z[1]+corner[m].z[3]-corner[m].z[0]-corner[m].z[2])/leafBox[m].extent[0],
            0.5*(corner[m].z[2]+corner[m].z[3]-corner[m].z[0]-corner[m].z[1])/leafBox[m].extent[1] };
          const double flat[2] = { 0,0 };
          addThickness(leafBox[m], solid ? flat : slope, solid ? leafBox[m].extent[2] : bins.size, stats);
        }
        for (uint32_t m=quads; m<4; m++) leaves[m] = emptyLeaf;
      }

      void voxelThickness(BlockStatistics& stats)
      {
        const double flat[2] = { 0,0 };
        for (uint32_t m=0; m < 1u << (2*height); m++)
          if (!boxOf(height,m).empty()) addThickness(leafBox[m],flat,leafBox[m].extent[2],stats);
      }

      /*! World distance between the planes z = slope (x,y) and the same moved up by
       *  thickness. A plane a.(x,y,z) = k of the frame is the plane
       *  (a_x Rx + a_y Ry + a_z Rz - k Rw).p = const of the world, R the rows of the
       *  map; its normal's length over W is the frame's distance a unit of the world. */
      void addThickness(const NodeBox& box, const double slope[2], double thickness, BlockStatistics& stats) const
      {
        const double c[3] = { box.lower[0]+0.5*box.extent[0], box.lower[1]+0.5*box.extent[1], box.lower[2]+0.5*box.extent[2] };
        const double k = c[2] - slope[0]*c[0] - slope[1]*c[1];
        double n2 = 0;
        for (int i=0; i<3; i++) {
          const float* col = frame.columns[i];
          const double n = -slope[0]*col[0] - slope[1]*col[1] + col[2] - k*col[3];
          n2 += n*n;
        }
        const float t = float(thickness/(inverseW({ c[0],c[1],c[2] })*std::sqrt(n2)));
        if (t > stats.maxThickness) stats.maxThickness = t;
      }

      /*! 1/W as a linear form of the frame's position: the inverse of a projective map
       *  is one, and its last row is this. Sampled at four points. */
      void invertW()
      {
        auto row = [&](int k, double d) { return Form{ { frame.columns[0][k], frame.columns[1][k], frame.columns[2][k] }, d }; };
        const FrameMap map = { row(0,0.5), row(1,0.5), row(2,0.5), row(3,1.0), frame.projective };
        auto rcpW = [&](double x, double y, double z) {
          Double3 p;
          return frame.projective && unproject(map,x,y,z,p) ? 1.0/map.W(p) : 1.0;
        };
        const double o = rcpW(0,0,0);
        inverseW = Form{ { rcpW(1,0,0)-o, rcpW(0,1,0)-o, rcpW(0,0,1)-o }, o };
      }

      void storeVertices(float* out) const
      {
        for (int k=0; k<3; k++)
          for (uint32_t i=0; i<width*width; i++)
            out[k*width*width+i] = isFinite(i) ? vertices[i][k] : NAN; // a triangle with NaN has no hit, one with infinity might
        for (int i=0; i<3; i++) out[3*width*width+i] = 0.0f;
      }

    private:
      Kind kind;
      uint32_t height, width;
      bool allFinite = false;
      const float (*vertices)[3];
      Frame frame;
      Form inverseW = { { 0,0,0 }, 1 };
      uint32_t* nodes = nullptr;
      ExactBox* boxes;          //!< of all quadtree levels, level by level
      double (*local)[3];       //!< vertices in the frame
      Double3* fitted;          //!< vertices, relative, while the frame is fitted
      float (*finite)[3];
      NodeBox* leafBox;         //!< decoded
      CornerHeights* corner;
    };
  }}
}
