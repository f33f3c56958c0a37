// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of the boxes of a block of cVERT, vert/format.h: margins of groups, in a shear that makes groups flat. Boxes of a segment
 * of a block that moves hold at both of its ends. */

#include "block_vertices.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class BoxEncoder
    {
    public:
      /*! of a block, or of a block at both ends of a segment */
      void begin (const BlockVertices& first, const BlockVertices* second = nullptr)
      {
        ends[0] = &first; ends[1] = second ? second : &first;
        numEnds = second ? 2 : 1;
        groupsX = groupsOf(first.quads[0]); groups = groupsX*groupsOf(first.quads[1]);
        shear = chooseShear();
        for (uint32_t e=0; e<numEnds; e++)
          if (!shear.isStraight()) setHeights(e,shear);
        memset(margins,0,sizeof(margins));
      }

      /*! Group g at an end. vertices: its cell's coordinates, by axis */
      void addGroup (uint32_t end, uint32_t g, const int (*vertices)[paddedVertices])
      {
        for (uint32_t k=0; k<3; k++)
        {
          const bool isSheared = k == shear.axis && !shear.isStraight();
          int sheared[paddedVertices]; // in 1/16
          if (isSheared) ends[end]->gather(heights[end],groupQuads*(g % groupsX),groupQuads*(g / groupsX),1,sheared);
          const int* v = isSheared ? sheared : vertices[k];
          const Span span = spanOf(v,paddedVertices);
          const int lower = std::min(std::min(v[0],v[4]),std::min(v[20],v[24])) - span.lower;
          const int upper = span.upper - std::max(std::max(v[0],v[4]),std::max(v[20],v[24]));
          margins[0][k][g] = std::max(margins[0][k][g],isSheared ? stepsUp(lower,4) : lower);
          margins[1][k][g] = std::max(margins[1][k][g],isSheared ? stepsUp(upper,4) : upper);
        }
      }

      /*! all groups of both ends */
      void addGroups ()
      {
        int vertices[3][paddedVertices];
        for (uint32_t e=0; e<numEnds; e++)
          for (uint32_t g=0; g<groups; g++) {
            for (int k=0; k<3; k++) ends[e]->gather(ends[e]->coordinates[k],groupQuads*(g % groupsX),groupQuads*(g / groupsX),1,vertices[k]);
            addGroup(e,g,vertices);
          }
      }

      /*! bits 0 to 23 of boxForm; out: margins of groups */
      uint32_t write (uint8_t* out) const
      {
        uint32_t boxForm = shear.axis << 12 | (uint32_t(shear.slopes[0]) & 31u) << 14 | (uint32_t(shear.slopes[1]) & 31u) << 19;
        for (int k=0; k<3; k++) boxForm |= writeMargins(out+k*groups,margins[0][k],margins[1][k]) << (4*k);
        return boxForm;
      }

      /*! The bounds of the block at an end: see reachStep; in steps of the least power of two that does, whose exponent is shift. */
      uint32_t reach (uint32_t end, uint32_t& shift) const
      {
        const BlockVertices& of = *ends[end];
        int bounds[4];
        for (uint32_t i=0; i<2; i++) bounds[i] = spanOf(of.coordinates[(shear.axis+1+i)%3],of.numVertices()).upper;
        const Span h = spanOf(shear.isStraight() ? of.coordinates[shear.axis] : heights[end],of.numVertices());
        const int scale = shear.isStraight() ? 16 : 1;
        bounds[2] = (scale*h.lower) >> 4; // down
        bounds[3] = stepsUp(scale*h.upper,4);
        shift = 0;
        while (stepsUp(bounds[0],shift) > 255 || stepsUp(bounds[1],shift) > 255 || (bounds[2] >> shift) < -128 || stepsUp(bounds[3],shift) > 127) shift++;
        return uint32_t(stepsUp(bounds[0],shift)) | uint32_t(stepsUp(bounds[1],shift)) << 8
             | (uint32_t(bounds[2] >> shift) & 255u) << 16 | (uint32_t(stepsUp(bounds[3],shift)) & 255u) << 24;
      }

    private:
      /*! the sheared coordinate of boxes */
      struct Shear
      {
        uint32_t axis = 0;
        int slopes[2] = { 0,0 };  //!< of the next axes, in 1/16

        bool isStraight () const { return slopes[0] == 0 && slopes[1] == 0; }
      };

      void setHeights (uint32_t end, const Shear& shear)
      {
        const BlockVertices& of = *ends[end];
        const int* along = of.coordinates[shear.axis];
        const int* a = of.coordinates[(shear.axis+1)%3];
        const int* b = of.coordinates[(shear.axis+2)%3];
        for (uint32_t i=0; i<of.numVertices(); i+=4)
          ((Int4::load(along+i) << 4) + Int4(shear.slopes[0])*Int4::load(a+i) + Int4(shear.slopes[1])*Int4::load(b+i)).store(heights[end]+i);
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

      /*! Along the mean normal of the quads, where groups are flatter then. */
      Shear chooseShear ()
      {
        int64_t n[3] = { 0,0,0 };
        for (uint32_t e=0; e<numEnds; e++) addNormals(*ends[e],n);
        Shear straight, shear;
        const int64_t x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
        straight.axis = shear.axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
        if (n[shear.axis] == 0) return straight;
        for (uint32_t i=0; i<2; i++) {
          const double slope = std::floor(16*double(n[(shear.axis+1+i)%3])/double(n[shear.axis]) + 0.5);
          shear.slopes[i] = int(std::min(std::max(slope,-15.0),15.0));
        }
        if (shear.isStraight()) return straight;
        int64_t sheared = 0, upright = 0;
        for (uint32_t e=0; e<numEnds; e++) {
          setHeights(e,shear);
          sheared += thickness(*ends[e],heights[e]);
          upright += thickness(*ends[e],ends[e]->coordinates[straight.axis]);
        }
        return sheared < 16*upright ? shear : straight;
      }

      /*! twice the areas of the quads along the axes: what the border encloses */
      static void addNormals (const BlockVertices& of, int64_t n[3])
      {
        const uint32_t width = of.width;
        auto add = [&](uint32_t from, uint32_t to) {
          const int* const (&c)[3] = { of.coordinates[0],of.coordinates[1],of.coordinates[2] };
          for (int k=0; k<3; k++) n[k] += int64_t(c[(k+1)%3][from])*c[(k+2)%3][to] - int64_t(c[(k+2)%3][from])*c[(k+1)%3][to];
        };
        const uint32_t last = of.quads[1]*width;
        for (uint32_t x=0; x<of.quads[0]; x++) { add(x,x+1); add(last+x+1,last+x); }
        for (uint32_t y=0; y<of.quads[1]; y++) { add(y*width+of.quads[0],(y+1)*width+of.quads[0]); add((y+1)*width,y*width); }
      }

      /*! sum over groups of their spans */
      int64_t thickness (const BlockVertices& of, const int* values) const
      {
        int64_t sum = 0;
        for (uint32_t gy=0; gy<groups/groupsX; gy++)
          for (uint32_t gx=0; gx<groupsX; gx++)
          {
            int group[paddedVertices];
            of.gather(values,groupQuads*gx,groupQuads*gy,1,group);
            const Span span = spanOf(group,paddedVertices);
            sum += span.upper-span.lower;
          }
        return sum;
      }

      /*! in steps of the least power of two that does, which is returned as its exponent */
      uint32_t writeMargins (uint8_t* out, const int* lowerMargins, const int* upperMargins) const
      {
        int largest = 0;
        for (uint32_t g=0; g<groups; g++) largest = std::max(largest,std::max(lowerMargins[g],upperMargins[g]));
        uint32_t shift = 0;
        while (stepsUp(largest,shift) > int(maxMargin)) shift++;
        for (uint32_t g=0; g<groups; g++)
          out[g] = uint8_t(stepsUp(lowerMargins[g],shift) | stepsUp(upperMargins[g],shift) << 4);
        return shift;
      }

      static int stepsUp (int x, uint32_t shift) { return (x + (1 << shift) - 1) >> shift; }

      const BlockVertices* ends[2];
      uint32_t numEnds, groupsX, groups;
      Shear shear;
      int margins[2][3][maxVertGroups];
      int heights[2][BlockVertices::maxVertices]; //!< sheared coordinates, in 1/16, if the shear is not straight
    };
  }}
}
