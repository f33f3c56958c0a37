// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of a block: vertices -> frame -> bounds bottom-up -> nodes top-down ->
 * leaves. Top-down, because a node's planes are relative to what its parent
 * decodes to, not to what the parent holds: rounding cannot add up. */

#include "block.h"
#include "frame.h"
#include "leaf_encoder.h"
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
        : kind(kind), height(height), width((1u << height)+1), cellLevels(kind == Kind::LEAF && height == 0 ? 1 : height),
          vertices(vertices) { layoutScratch((char*)scratch); }

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
        if (cellLevels > height) splitQuad();
        return true;
      }

      /*! Whether leaves would be much larger than most of their quads: the vertices lie on
       *  a line, or some are far away from all others. Better not compressed. */
      bool isDegenerate() const
      {
        const uint32_t cells = 1u << (2*cellLevels);
        uint32_t small = 0, valid = 0;
        for (uint32_t m=0; m<cells; m++)
        {
          const double* q[4];
          for (int c=0; c<4; c++) q[c] = local[vertexOfCell(m,c)];
          const double area = 0.5*std::fabs((q[3][0]-q[0][0])*(q[2][1]-q[1][1]) - (q[3][1]-q[0][1])*(q[2][0]-q[1][0]));
          small += area*cells < minQuadArea;
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

        invertFrame();
        boundRounding();
        boundCells(stats);
        nodeLevels = block->layout().nodeLevels;
        nodes = block->nodes();
        groups = (uint64_t*)block->leaves();
        borderWidth = 0;
        encodeNodes(0,0,NodeBox::root(),stats);
        if (kind == Kind::LEAF) block->info |= Block::encodeBorderWidth(borderWidth);
        if (kind == Kind::GRID) storeVertices((float*)block->leaves());
      }

      /*! Bounds in the world of all that a ray may hit in the block that encode() wrote: its
       *  leaves' boxes, which reach past the vertices. cGRID's triangles do not. */
      void worldBounds(const Block* block, double lower[3], double upper[3])
      {
        for (int k=0; k<3; k++) { lower[k] = 1e300; upper[k] = -1e300; }
        for (uint32_t i=0; i<width*width; i++)
          for (int k=0; k<3; k++)
            if (isFinite(i)) {
              lower[k] = std::min(lower[k],double(vertices[i][k]));
              upper[k] = std::max(upper[k],double(vertices[i][k]));
            }
        if (kind != Kind::GRID) extendByLeaves(block,0,0,NodeBox::root(),lower,upper);
      }

    private:
      /*! extends bounds in the world by the leaves below a node; none where its box is inside */
      void extendByLeaves(const Block* block, uint32_t level, uint32_t m, const NodeBox& box, double lower[3], double upper[3]) const
      {
        double l[3] = { 1e300,1e300,1e300 }, u[3] = { -1e300,-1e300,-1e300 };
        for (int c=0; c<8; c++)
        {
          const double x = c & 1 ? box.upper(0) : box.lower[0], y = c & 2 ? box.upper(1) : box.lower[1], z = c & 4 ? box.upper(2) : box.lower[2];
          const double w = 1/inverseW({ x,y,z });
          for (int k=0; k<3; k++) {
            const double p = frame.centre[k] + w*inverse[k]({ x,y,z });
            l[k] = minimum(l[k],p);
            u[k] = maximum(u[k],p);
          }
        }
        bool inside = true;
        for (int k=0; k<3; k++) inside &= lower[k] <= l[k] && u[k] <= upper[k];
        if (inside) return;
        if (level == nodeLevels) {
          for (int k=0; k<3; k++) { lower[k] = minimum(lower[k],l[k]); upper[k] = maximum(upper[k],u[k]); }
          return;
        }
        const uint32_t word = block->nodes()[nodesOfLevels(level)+m];
        const bool isGroup = kind == Kind::LEAF && level+1 == nodeLevels;
        for (uint32_t c=0; c<4; c++)
        {
          if (level+1 == nodeLevels && boxes[nodesOfLevels(cellLevels)+4*m+c].empty()) continue;
          const NodeBox child = isGroup ? decodeLeaf(word,groups[m],int(c),box).box : decodeChild(word,int(c),box);
          extendByLeaves(block,level+1,4*m+c,child,lower,upper);
        }
      }

      /*! places the arrays in scratch memory; returns the end */
      size_t layoutScratch(char* scratch)
      {
        const size_t side = (size_t(1) << cellLevels) + 1, points = side*side;
        size_t bytes = 0;
        auto take = [&](size_t n) { const uintptr_t p = uintptr_t(scratch) + bytes; bytes += (n+15) & ~size_t(15); return p; };
        boxes  = (ExactBox*)take(nodesOfLevels(cellLevels+1)*sizeof(ExactBox));
        local  = (double(*)[3])take(points*3*sizeof(double));
        fitted = (Double3*)take(points*sizeof(Double3));
        finite = (float(*)[3])take(points*3*sizeof(float));
        return bytes;
      }

      bool isFinite(uint32_t i) const { return cbvh::isFinite(vertices[i]); }

      /*! whether a vertex in the frame, of a cell, is finite */
      bool isLocalFinite(uint32_t i) const { return std::isfinite(local[i][0]) && std::isfinite(local[i][1]) && std::isfinite(local[i][2]); }

      uint32_t vertexOfCell(uint32_t m, int corner) const {
        return (mortonY(m)+(corner>>1))*((1u << cellLevels)+1) + mortonX(m)+(corner&1);
      }

      /*! cLEAF's leaves are groups of 2 x 2: a block of one quad is cut into four cells */
      void splitQuad()
      {
        double quad[4][3];
        memcpy(quad,local,sizeof(quad));
        for (int v=0; v<9; v++)
          for (int k=0; k<3; k++)
            local[v][k] = 0.25*((2-v%3)*((2-v/3)*quad[0][k] + (v/3)*quad[2][k]) + (v%3)*((2-v/3)*quad[1][k] + (v/3)*quad[3][k]));
      }

      ExactBox& boxOf(uint32_t level, uint32_t m) { return boxes[nodesOfLevels(level)+m]; }

      /*! vertexRounding in the frame, axis by axis: a world step of r on each axis moves
       *  x = X/W by at most r (|dX| + |dW|)/W */
      void boundRounding()
      {
        double coordinate = 0, rcpW = 0;
        for (uint32_t i=0; i<width*width; i++)
          for (int k=0; k<3; k++)
            if (isFinite(i)) coordinate = std::max(coordinate,std::fabs(double(vertices[i][k])));
        for (int corner=0; corner<8; corner++)
          rcpW = std::max(rcpW,inverseW({ double(corner&1),double((corner>>1)&1),double(corner>>2) }));
        auto sum = [&](int k) { return std::fabs(double(frame.columns[0][k])) + std::fabs(double(frame.columns[1][k])) + std::fabs(double(frame.columns[2][k])); };
        for (int k=0; k<3; k++)
          rounding[k] = vertexRounding*coordinate*(sum(k)+sum(3))*rcpW;
      }

      void boundCells(BlockStatistics& stats)
      {
        uint32_t invalid = 0;
        for (uint32_t m=0; m < 1u << (2*cellLevels); m++)
        {
          ExactBox box;
          bool valid = true;
          for (int c=0; c<4; c++) {
            const uint32_t i = vertexOfCell(m,c);
            valid &= allFinite || isLocalFinite(i);
            if (valid) box.extend(local[i]);
          }
          for (int k=0; k<3; k++) {
            box.lower[k] = std::min(box.lower[k],std::max(box.lower[k]-rounding[k],frameMargin));
            box.upper[k] = std::max(box.upper[k],std::min(box.upper[k]+rounding[k],1-frameMargin));
          }
          boxOf(cellLevels,m) = valid ? box : ExactBox();
          invalid += !valid;
        }
        stats.invalidQuads += cellLevels > height ? invalid != 0 : invalid;
        for (uint32_t level=cellLevels; level-- > 0;)
          for (uint32_t m=0; m < 1u << (2*level); m++)
          {
            ExactBox box;
            for (uint32_t c=0; c<4; c++) box.extend(boxOf(level+1,4*m+c));
            boxOf(level,m) = box;
          }
      }

      void encodeNodes(uint32_t level, uint32_t m, const NodeBox& box, BlockStatistics& stats)
      {
        if (level == nodeLevels) {
          if (kind == Kind::VOXEL) addBoxThickness(m,box,stats);
          return;
        }
        uint32_t& word = nodes[nodesOfLevels(level)+m];
        if (kind == Kind::LEAF && level+1 == nodeLevels) {
          encodeLeaves(m,box,word,stats);
          return;
        }
        word = encodeNode(box,&boxOf(level+1,4*m));
        for (uint32_t c=0; c<4; c++)
          encodeNodes(level+1,4*m+c,decodeChild(word,int(c),box),stats);
      }

      void encodeLeaves(uint32_t m, const NodeBox& box, uint32_t& word, BlockStatistics& stats)
      {
        QuadGroup group;
        const uint32_t side = (1u << cellLevels)+1, x = 2*mortonX(m), y = 2*mortonY(m);
        for (uint32_t v=0; v<9; v++)
          memcpy(group.vertices[v],local[(y+v/3)*side + x+v%3],sizeof(double[3]));
        for (int c=0; c<4; c++) group.boxes[c] = boxOf(cellLevels,4*m+c);
        memcpy(group.rounding,rounding,sizeof(rounding));
        group.border[0][0] = x == 0;
        group.border[1][0] = y == 0;
        group.border[0][1] = x+2 == side-1;
        group.border[1][1] = y+2 == side-1;
        const EncodedGroup encoded = encodeGroup(box,group);
        word = encoded.word;
        groups[m] = encoded.heights;
        borderWidth = std::max(borderWidth,encoded.borderWidth);

        for (int c=0; c<4; c++)
        {
          const LeafPatch leaf = decodeLeaf(encoded.word,encoded.heights,c,box);
          if (leaf.empty) continue;
          stats.solidLeaves += leaf.solid;
          const double slope[2] = { 0.5*(leaf.z[1]+leaf.z[3]-leaf.z[0]-leaf.z[2])/leaf.box.extent[0],
                                    0.5*(leaf.z[2]+leaf.z[3]-leaf.z[0]-leaf.z[1])/leaf.box.extent[1] };
          if (leaf.solid) addBoxThickness(4*m+c,leaf.box,stats);
          else addThickness(leaf.box,slope,leaf.thickness,stats);
        }
      }

      void addBoxThickness(uint32_t cell, const NodeBox& box, BlockStatistics& stats) const
      {
        const double flat[2] = { 0,0 };
        if (!boxes[nodesOfLevels(cellLevels)+cell].empty()) addThickness(box,flat,box.extent[2],stats);
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

      /*! The inverse of the frame. That of a projective map is one too: 1/W, and p/W of the world
       *  point relative to the centre, are linear forms of the frame's position. Sampled at four
       *  points. */
      void invertFrame()
      {
        auto row = [&](int k, double d) { return Form{ { frame.columns[0][k], frame.columns[1][k], frame.columns[2][k] }, d }; };
        const FrameMap map = { row(0,0.5), row(1,0.5), row(2,0.5), row(3,1.0), frame.projective };
        double sample[4][4];
        for (int i=0; i<4; i++)
        {
          Double3 p = { 0,0,0 };
          unproject(map,i == 1,i == 2,i == 3,p);
          const double rcpW = frame.projective ? 1.0/map.W(p) : 1.0;
          sample[i][0] = p.x*rcpW; sample[i][1] = p.y*rcpW; sample[i][2] = p.z*rcpW; sample[i][3] = rcpW;
        }
        auto form = [&](int k) {
          return Form{ { sample[1][k]-sample[0][k], sample[2][k]-sample[0][k], sample[3][k]-sample[0][k] }, sample[0][k] };
        };
        for (int k=0; k<3; k++) inverse[k] = form(k);
        inverseW = form(3);
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
      uint32_t cellLevels;      //!< levels of cells, which are quads but for cLEAF of height 0
      bool allFinite = false;
      const float (*vertices)[3];
      Frame frame;
      Form inverseW = { { 0,0,0 }, 1 };
      Form inverse[3];
      uint32_t nodeLevels = 0;
      uint32_t* nodes = nullptr;
      uint64_t* groups = nullptr; //!< cLEAF's leaves
      double borderWidth = 0;     //!< cLEAF: the largest of all groups
      ExactBox* boxes;          //!< of all quadtree levels, level by level
      double (*local)[3];       //!< vertices in the frame
      double rounding[3];       //!< how far they may be from where a neighbouring face has them
      Double3* fitted;          //!< vertices, relative, while the frame is fitted
      float (*finite)[3];
    };
  }}
}
