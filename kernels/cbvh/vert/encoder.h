// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of a block of cVERT, vert/format.h. It loses nothing: vertices come snapped to
 * their lattices (surface/lattice.h), and each is the same floats when it is decoded. */

#include "format.h"
#include "cell_encoder.h"
#include "../base/world.h"
#include <algorithm>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    struct VertStatistics
    {
      uint32_t invalidQuads = 0;  //!< with a vertex that is not finite
      uint32_t fieldBytes = 0;
      bool raw = false;
    };

    /*! where a block is in its patch, and what it has of that */
    struct VertPlacement
    {
      uint32_t region, patchQuads;     //!< vertRegion(), vertPatch()
      bool hasEdges = false;
      VertEdges edges = { 0,0 };      //!< if it has any

      VertPlacement (uint32_t region, uint32_t patchQuads) : region(region), patchQuads(patchQuads) {}
      VertPlacement (uint32_t region, uint32_t patchQuads, const VertEdges& edges) : region(region), patchQuads(patchQuads), hasEdges(true), edges(edges) {}

      uint32_t form () const { return uint32_t(hasEdges) << 29; }
    };

    class VertEncoder
    {
    public:
      static const uint32_t maxSide = (1u << maxVertHeight) + 1u;

      /*! room for any block */
      static const size_t maxBytes = vertHeaderBytes + vertEdgesBytes + sizeof(float)*(3*maxSide*maxSide + boxPlanes*maxVertGroups) + 64;

      float vertices[maxSide*maxSide][3]; //!< row by row, (quadsX+1) (quadsY+1) of them
      float lower[3], upper[3];           //!< of the finite ones, by encode

      /*! spacing: of the lattice that the vertices lie on. Returns the
       *  number of bytes written to block, a multiple of 4; 0 where no vertex is finite. */
      size_t encode (const VertPlacement& at, float spacing, uint8_t* block, VertStatistics& statistics)
      {
        quads[0] = vertQuadsX(at.region); quads[1] = vertQuadsY(at.region);
        width = quads[0]+1;
        layout = vertLayout(at.region,at.form());
        if (!bound(statistics)) return 0;
        memset(block,0,layout.cell);
        VertHeader& header = *(VertHeader*)block;
        header.region = at.region;
        header.patchQuads = at.patchQuads;
        if (at.hasEdges) memcpy(&header+1,&at.edges,sizeof(at.edges));
        const bool packed = allFinite && locate(spacing) && pack(header,block,statistics);
        if (!packed) packRaw(header,spacing,block);
        header.boxForm |= at.form();
        statistics.raw = !packed;
        while (size_t(end-block) % 4 != 0) *end++ = 0;
        return size_t(end-block);
      }

    private:
      const float* vertexAt (uint32_t x, uint32_t y) const { return vertices[y*width+x]; }

      bool bound (VertStatistics& statistics)
      {
        for (int k=0; k<3; k++) { lower[k] = INFINITY; upper[k] = -INFINITY; }
        allFinite = true;
        for (uint32_t i=0; i<width*(quads[1]+1); i++)
        {
          if (!isFinite(vertices[i])) { allFinite = false; continue; }
          for (int k=0; k<3; k++) { lower[k] = std::min(lower[k],vertices[i][k]); upper[k] = std::max(upper[k],vertices[i][k]); }
        }
        if (!allFinite)
          for (uint32_t y=0; y<quads[1]; y++)
            for (uint32_t x=0; x<quads[0]; x++)
              statistics.invalidQuads += !(isFinite(vertexAt(x,y)) && isFinite(vertexAt(x+1,y)) && isFinite(vertexAt(x,y+1)) && isFinite(vertexAt(x+1,y+1)));
        return lower[0] <= upper[0];
      }

      /*! coordinates on the lattice relative to the lower bounds; false where one is too large */
      bool locate (float spacing)
      {
        for (int k=0; k<3; k++)
          if (!((double(upper[k])-double(lower[k])) < double(maxExtent)*spacing)) return false;
        this->spacing = spacing;
        const double reciprocal = 1.0/spacing;
        for (uint32_t i=0; i<width*(quads[1]+1); i++)
          for (int k=0; k<3; k++)
          {
            const double q = (double(vertices[i][k])-double(lower[k]))*reciprocal;
            coordinates[k][i] = int(q);
            if (double(coordinates[k][i]) != q) return false; // not on this lattice
          }
        return true;
      }

      /*! the vertices of a cell; those behind the last are the last */
      void gather (uint32_t x0, uint32_t y0, uint32_t step)
      {
        for (int j=0; j<5; j++)
        {
          const uint32_t y = std::min(y0+step*j,quads[1]);
          for (int i=0; i<5; i++)
          {
            const uint32_t v = y*width + std::min(x0+step*i,quads[0]);
            for (int k=0; k<3; k++) cell.vertices[k][5*j+i] = coordinates[k][v];
          }
        }
      }

      bool pack (VertHeader& header, uint8_t* block, VertStatistics& statistics)
      {
        for (int k=0; k<3; k++) header.origin[k] = lower[k];
        gather(0,0,groupQuads);
        if (!cell.encode(quads,groupQuads)) return false;
        header.word = cell.word | exponentBits(spacing);
        end = cell.write(block+layout.cell);
        for (int c=0; c<4; c++)
          for (int k=0; k<3; k++)
            header.corners[cornerPair(c,k)] |= uint32_t(cell.vertices[k][(c & 1)*4 + (c >> 1)*20]) << (16*((3*c+k) & 1));

        int margins[2][3][maxVertGroups];
        const Shear shear = chooseShear();
        header.boxForm = shear.axis << 12 | (uint32_t(shear.slopes[0]) & 31u) << 14 | (uint32_t(shear.slopes[1]) & 31u) << 19;
        writeReach(header,shear);
        for (uint32_t g=0; g<layout.groups; g++)
        {
          const uint32_t gx = g % layout.groupsX, gy = g / layout.groupsX;
          gather(groupQuads*gx,groupQuads*gy,1);
          const uint32_t sides[2] = { quadsOfGroup(quads[0],gx), quadsOfGroup(quads[1],gy) };
          if (!cell.encode(sides,1)) return false;
          const uint16_t low = uint16_t(cell.word);
          memcpy(block+layout.words+2*g,&low,sizeof(low));
          block[layout.wordsHigh+g] = uint8_t(cell.word >> 16);
          end = cell.write(end);
          for (int k=0; k<3; k++)
          {
            int sheared[cellVertices]; // in 1/16
            for (int i=0; i<cellVertices; i++) sheared[i] = uint32_t(k) == shear.axis ? shear.of(cell.vertices[0][i],cell.vertices[1][i],cell.vertices[2][i]) : 16*cell.vertices[k][i];
            const int* v = sheared;
            int lo = v[0], hi = v[0];
            for (int i=1; i<cellVertices; i++) { lo = std::min(lo,v[i]); hi = std::max(hi,v[i]); }
            margins[0][k][g] = stepsUp(std::min(std::min(v[0],v[4]),std::min(v[20],v[24])) - lo,4);
            margins[1][k][g] = stepsUp(hi - std::max(std::max(v[0],v[4]),std::max(v[20],v[24])),4);
          }
        }
        for (int k=0; k<3; k++) writeMargins(header,block+layout.margins+k*layout.groups,k,margins[0][k],margins[1][k]);
        statistics.fieldBytes += uint32_t(end - (block+layout.cell));
        return true;
      }

      /*! the sheared coordinate of boxes */
      struct Shear
      {
        uint32_t axis = 0;
        int slopes[2] = { 0,0 };  //!< of the next axes, in 1/16

        /*! in 1/16 */
        int of (int x, int y, int z) const
        {
          const int c[3] = { x,y,z };
          return 16*c[axis] + slopes[0]*c[(axis+1)%3] + slopes[1]*c[(axis+2)%3];
        }
      };

      /*! along the mean normal of the quads, where groups are flatter then */
      Shear chooseShear () const
      {
        double n[3] = { 0,0,0 };
        for (uint32_t y=0; y<quads[1]; y++)
          for (uint32_t x=0; x<quads[0]; x++)
          {
            const uint32_t v = y*width+x;
            double a[3], b[3];
            for (int k=0; k<3; k++) {
              a[k] = double(coordinates[k][v+width+1]-coordinates[k][v]);
              b[k] = double(coordinates[k][v+width]-coordinates[k][v+1]);
            }
            for (int k=0; k<3; k++) n[k] += a[(k+1)%3]*b[(k+2)%3] - a[(k+2)%3]*b[(k+1)%3];
          }
        Shear straight, shear;
        const double x = std::fabs(n[0]), y = std::fabs(n[1]), z = std::fabs(n[2]);
        straight.axis = shear.axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
        if (!(std::fabs(n[shear.axis]) > 0)) return straight;
        for (uint32_t i=0; i<2; i++) {
          const double slope = std::floor(16*n[(shear.axis+1+i)%3]/n[shear.axis] + 0.5);
          shear.slopes[i] = int(std::min(std::max(slope,-15.0),15.0));
        }
        return thickness(shear) < thickness(straight) ? shear : straight;
      }

      /*! see reachStep: in the least power of two that does */
      void writeReach (VertHeader& header, const Shear& shear) const
      {
        int bounds[4] = { 0,0,0x7FFFFFFF,-0x7FFFFFFF }; // the last two in 1/16
        for (uint32_t v=0; v<width*(quads[1]+1); v++)
        {
          for (uint32_t i=0; i<2; i++) bounds[i] = std::max(bounds[i],coordinates[(shear.axis+1+i)%3][v]);
          const int h = shear.of(coordinates[0][v],coordinates[1][v],coordinates[2][v]);
          bounds[2] = std::min(bounds[2],h);
          bounds[3] = std::max(bounds[3],h);
        }
        bounds[2] = bounds[2] >> 4; // down
        bounds[3] = stepsUp(bounds[3],4);
        uint32_t shift = 0;
        while (stepsUp(bounds[0],shift) > 255 || stepsUp(bounds[1],shift) > 255 || (bounds[2] >> shift) < -128 || stepsUp(bounds[3],shift) > 127) shift++;
        header.boxForm |= shift << 25;
        header.reach = uint32_t(stepsUp(bounds[0],shift)) | uint32_t(stepsUp(bounds[1],shift)) << 8
                     | (uint32_t(bounds[2] >> shift) & 255u) << 16 | (uint32_t(stepsUp(bounds[3],shift)) & 255u) << 24;
      }

      static uint32_t exponentBits (float spacing)
      {
        uint32_t bits;
        memcpy(&bits,&spacing,sizeof(bits));
        return (bits >> 23) << 24;
      }

      /*! sum over groups of their heights, in 1/16 */
      double thickness (const Shear& shear) const
      {
        double sum = 0;
        for (uint32_t gy=0; gy<quads[1]; gy+=groupQuads)
          for (uint32_t gx=0; gx<quads[0]; gx+=groupQuads)
          {
            int lo = 0x7FFFFFFF, hi = -lo;
            for (uint32_t y=gy; y<=std::min(gy+groupQuads,quads[1]); y++)
              for (uint32_t x=gx; x<=std::min(gx+groupQuads,quads[0]); x++) {
                const uint32_t v = y*width+x;
                const int h = shear.of(coordinates[0][v],coordinates[1][v],coordinates[2][v]);
                lo = std::min(lo,h);
                hi = std::max(hi,h);
              }
            sum += double(hi-lo);
          }
        return sum;
      }

      /*! in steps of the least power of two that does */
      void writeMargins (VertHeader& header, uint8_t* out, int axis, const int* lowerMargins, const int* upperMargins) const
      {
        int largest = 0;
        for (uint32_t g=0; g<layout.groups; g++) largest = std::max(largest,std::max(lowerMargins[g],upperMargins[g]));
        uint32_t shift = 0;
        while (stepsUp(largest,shift) > int(maxMargin)) shift++;
        header.boxForm |= shift << (4*axis);
        for (uint32_t g=0; g<layout.groups; g++)
          out[g] = uint8_t(stepsUp(lowerMargins[g],shift) | stepsUp(upperMargins[g],shift) << 4);
      }

      static int stepsUp (int x, uint32_t shift) { return (x + (1 << shift) - 1) >> shift; }

      void packRaw (VertHeader& header, float spacing, uint8_t* block)
      {
        header.reach = 0;
        header.word = exponentBits(spacing);
        memset(header.corners,0,sizeof(header.corners));
        header.boxForm = 1u << 24;
        float (*out)[3] = (float(*)[3])(block+layout.vertices);
        for (uint32_t i=0; i<width*(quads[1]+1); i++)
          for (int k=0; k<3; k++)
            out[i][k] = isFinite(vertices[i]) ? vertices[i][k] : NAN; // a triangle with NaN is never hit, one with infinity might
        float* boxes = (float*)(block+layout.boxes);
        for (int k=0; k<3; k++)
        {
          header.origin[k] = lower[k];
          for (uint32_t g=0; g<layout.groups; g++) {
            float lo = INFINITY, hi = -INFINITY; // what a group without a finite vertex keeps
            extendByGroup(g,k,lo,hi);
            boxes[k*layout.groups+g] = lo;
            boxes[(3+k)*layout.groups+g] = hi;
          }
        }
        end = block + layout.rawBytes;
      }

      void extendByGroup (uint32_t g, int axis, float& lo, float& hi) const
      {
        const uint32_t x0 = groupQuads*(g % layout.groupsX), y0 = groupQuads*(g / layout.groupsX);
        for (uint32_t y=y0; y<=std::min(y0+groupQuads,quads[1]); y++)
          for (uint32_t x=x0; x<=std::min(x0+groupQuads,quads[0]); x++)
            if (isFinite(vertexAt(x,y))) { lo = std::min(lo,vertexAt(x,y)[axis]); hi = std::max(hi,vertexAt(x,y)[axis]); }
      }

      uint32_t quads[2], width;
      VertLayout layout;
      bool allFinite;
      float spacing;
      int coordinates[3][maxSide*maxSide];
      CellEncoder cell;
      uint8_t* end;
    };
  }}
}
