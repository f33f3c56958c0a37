// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of a block of cVERT, vert/format.h. It loses nothing: vertices come snapped to
 * their lattices (surface/lattice.h), and each is the same floats when it is decoded. */

#include "format.h"
#include "cell_encoder.h"
#include "../base/vertices4.h"
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
      bool hasEdges = false, hasNumbers = false;
      VertEdges edges = { 0,0 };      //!< if it has any
      VertNumbers numbers = { 0,0 };

      VertPlacement (uint32_t region, uint32_t patchQuads) : region(region), patchQuads(patchQuads) {}
      VertPlacement (uint32_t region, uint32_t patchQuads, const VertEdges& edges) : region(region), patchQuads(patchQuads), hasEdges(true), edges(edges) {}

      /*! of quads of their own: form of their numbers in place of the patch's size */
      VertPlacement (uint32_t region, uint32_t form, const VertNumbers& numbers) : region(region), patchQuads(form), hasNumbers(true), numbers(numbers) {}

      uint32_t form () const { return uint32_t(hasEdges) << 29 | uint32_t(hasNumbers) << 30; }
    };

    class VertEncoder
    {
    public:
      static const uint32_t maxSide = (1u << maxVertHeight) + 1u;

      /*! room for any block */
      static const size_t maxBytes = vertHeaderBytes + vertEdgesBytes + sizeof(float)*(3*maxSide*maxSide + boxPlanes*maxVertGroups) + 64;

      static const uint32_t maxVertices = maxSide*maxSide + 3; //!< with whole vectors of four
      float vertices[maxVertices][3]; //!< row by row, (quadsX+1) (quadsY+1) of them
      float lower[3], upper[3];       //!< of the finite ones, by encode

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
        if (at.hasNumbers) memcpy(&header+1,&at.numbers,sizeof(at.numbers));
        const bool packed = allFinite && locate(spacing) && pack(header,block,statistics);
        if (!packed) packRaw(header,spacing,block);
        header.boxForm |= at.form();
        statistics.raw = !packed;
        while (size_t(end-block) % 4 != 0) *end++ = 0;
        return size_t(end-block);
      }

    private:
      uint32_t numVertices () const { return width*(quads[1]+1); }
      const float* vertexAt (uint32_t x, uint32_t y) const { return vertices[y*width+x]; }

      bool bound (VertStatistics& statistics)
      {
        allFinite = boundVertices(vertices,numVertices(),lower,upper);
        if (allFinite) return true;
        for (int k=0; k<3; k++) { lower[k] = INFINITY; upper[k] = -INFINITY; }
        for (uint32_t i=0; i<numVertices(); i++)
        {
          if (!isFinite(vertices[i])) continue;
          for (int k=0; k<3; k++) { lower[k] = std::min(lower[k],vertices[i][k]); upper[k] = std::max(upper[k],vertices[i][k]); }
        }
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
        const Float4 unit = spacing, reciprocal = 1.0f/spacing; // a power of two
        uint32_t off = 0; // this lattice
        auto locate = [&](Float4 x) {
          const Int4 c = truncated(x*reciprocal);
          off |= ~lanesEqual(toFloat(c)*unit,x);
          return c;
        };
        const Int4 first[3] = { locate(lower[0]),locate(lower[1]),locate(lower[2]) };
        for (uint32_t i=numVertices(); i % 4 != 0; i++) memcpy(vertices[i],vertices[0],sizeof(vertices[0]));
        for (uint32_t i=0; i<numVertices(); i+=4)
        {
          const Vertices4 p(vertices+i);
          (locate(p.x)-first[0]).store(coordinates[0]+i);
          (locate(p.y)-first[1]).store(coordinates[1]+i);
          (locate(p.z)-first[2]).store(coordinates[2]+i);
        }
        return (off & 15) == 0;
      }

      /*! of the vertices of a cell; those behind the last are the last */
      void gather (const int* values, uint32_t x0, uint32_t y0, uint32_t step, int out[paddedVertices]) const
      {
        for (uint32_t j=0; j<5; j++)
        {
          const int* row = values + std::min(y0+step*j,quads[1])*width;
          if (step == 1 && x0+4 <= quads[0]) { memcpy(out+5*j,row+x0,5*sizeof(*row)); continue; }
          for (uint32_t i=0; i<5; i++) out[5*j+i] = row[std::min(x0+step*i,quads[0])];
        }
        for (int v=cellVertices; v<paddedVertices; v++) out[v] = out[cellVertices-1];
      }

      void gatherCell (uint32_t x0, uint32_t y0, uint32_t step) {
        for (int k=0; k<3; k++) gather(coordinates[k],x0,y0,step,cell.vertices[k]);
      }

      bool pack (VertHeader& header, uint8_t* block, VertStatistics& statistics)
      {
        for (int k=0; k<3; k++) header.origin[k] = lower[k];
        gatherCell(0,0,groupQuads);
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
          gatherCell(groupQuads*gx,groupQuads*gy,1);
          const uint32_t sides[2] = { quadsOfGroup(quads[0],gx), quadsOfGroup(quads[1],gy) };
          if (!cell.encode(sides,1)) return false;
          const uint16_t low = uint16_t(cell.word);
          memcpy(block+layout.words+2*g,&low,sizeof(low));
          block[layout.wordsHigh+g] = uint8_t(cell.word >> 16);
          end = cell.write(end);
          for (uint32_t k=0; k<3; k++)
          {
            const bool isSheared = k == shear.axis && !shear.isStraight();
            int sheared[paddedVertices]; // in 1/16
            if (isSheared) gather(heights,groupQuads*gx,groupQuads*gy,1,sheared);
            const int* v = isSheared ? sheared : cell.vertices[k];
            const Span span = spanOf(v,paddedVertices);
            const int lower = std::min(std::min(v[0],v[4]),std::min(v[20],v[24])) - span.lower;
            const int upper = span.upper - std::max(std::max(v[0],v[4]),std::max(v[20],v[24]));
            margins[0][k][g] = isSheared ? stepsUp(lower,4) : lower;
            margins[1][k][g] = isSheared ? stepsUp(upper,4) : upper;
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

        bool isStraight () const { return slopes[0] == 0 && slopes[1] == 0; }
      };

      void setHeights (const Shear& shear)
      {
        const int* along = coordinates[shear.axis];
        const int* a = coordinates[(shear.axis+1)%3];
        const int* b = coordinates[(shear.axis+2)%3];
        for (uint32_t i=0; i<numVertices(); i+=4)
          ((Int4::load(along+i) << 4) + Int4(shear.slopes[0])*Int4::load(a+i) + Int4(shear.slopes[1])*Int4::load(b+i)).store(heights+i);
      }

      struct Span { int lower, upper; };

      /*! of whole vectors */
      static Span spanOf (const int* values, uint32_t count)
      {
        Int4 lower = Int4::load(values), upper = lower;
        for (uint32_t i=4; i<count; i+=4) {
          const Int4 x = Int4::load(values+i);
          lower = min(lower,x);
          upper = max(upper,x);
        }
        return { least(lower),greatest(upper) };
      }

      /*! Along the mean normal of the quads, where groups are flatter then; heights are along what is not straight. */
      Shear chooseShear ()
      {
        int64_t n[3];
        sumNormals(n);
        Shear straight, shear;
        const int64_t x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
        straight.axis = shear.axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
        if (n[shear.axis] == 0) return straight;
        for (uint32_t i=0; i<2; i++) {
          const double slope = std::floor(16*double(n[(shear.axis+1+i)%3])/double(n[shear.axis]) + 0.5);
          shear.slopes[i] = int(std::min(std::max(slope,-15.0),15.0));
        }
        if (shear.isStraight()) return straight;
        setHeights(shear);
        return thickness(heights) < 16*thickness(coordinates[straight.axis]) ? shear : straight;
      }

      /*! twice the areas of the quads along the axes: what the border encloses */
      void sumNormals (int64_t n[3]) const
      {
        n[0] = n[1] = n[2] = 0;
        auto add = [&](uint32_t from, uint32_t to) {
          const int* const (&c)[3] = { coordinates[0],coordinates[1],coordinates[2] };
          for (int k=0; k<3; k++) n[k] += int64_t(c[(k+1)%3][from])*c[(k+2)%3][to] - int64_t(c[(k+2)%3][from])*c[(k+1)%3][to];
        };
        const uint32_t last = quads[1]*width;
        for (uint32_t x=0; x<quads[0]; x++) { add(x,x+1); add(last+x+1,last+x); }
        for (uint32_t y=0; y<quads[1]; y++) { add(y*width+quads[0],(y+1)*width+quads[0]); add((y+1)*width,y*width); }
      }

      /*! sum over groups of their spans */
      int64_t thickness (const int* values) const
      {
        int64_t sum = 0;
        for (uint32_t gy=0; gy<layout.groupsY; gy++)
          for (uint32_t gx=0; gx<layout.groupsX; gx++)
          {
            int group[paddedVertices];
            gather(values,groupQuads*gx,groupQuads*gy,1,group);
            const Span span = spanOf(group,paddedVertices);
            sum += span.upper-span.lower;
          }
        return sum;
      }

      /*! see reachStep: in the least power of two that does */
      void writeReach (VertHeader& header, const Shear& shear) const
      {
        int bounds[4];
        for (uint32_t i=0; i<2; i++) bounds[i] = spanOf(coordinates[(shear.axis+1+i)%3],numVertices()).upper;
        const Span h = spanOf(shear.isStraight() ? coordinates[shear.axis] : heights,numVertices());
        const int scale = shear.isStraight() ? 16 : 1;
        bounds[2] = (scale*h.lower) >> 4; // down
        bounds[3] = stepsUp(scale*h.upper,4);
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
        for (uint32_t i=0; i<numVertices(); i++)
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
      int coordinates[3][maxVertices]; //!< behind the last, to whole vectors, those of the first
      int heights[maxVertices];        //!< sheared coordinates, in 1/16, if the shear is not straight
      CellEncoder cell;
      uint8_t* end;
    };
  }}
}
