// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encoder of the numbers of a block's quads, cvert/format/quad_numbers.h: the first pattern that says all of them, else a table of as few bits
 * for each as their range takes. */

#include "../format/block.h"
#include <algorithm>
#include <vector>

namespace cvert { inline namespace CVERT_ISA
{
  /*! The numbers of the quads of a patch whose quads are primitives of their own, format/quad_numbers.h. */
  struct QuadNumbers
  {
    uint32_t form;                 //!< without a pattern
    unsigned width;                //!< in quads
    std::vector<uint32_t> numbers; //!< row by row
  };

  class NumbersEncoder
  {
  public:
    static const size_t maxBytes = 4*vertBlockQuads*vertBlockQuads + 8;

    uint32_t form;             //!< VertHeader::patchQuads
    VertNumbers pattern; //!< after the header

    /*! of width x height quads of a patch, from x0, y0 on */
    void set (const QuadNumbers& of, unsigned x0, unsigned y0, unsigned width, unsigned height)
    {
      this->width = width; this->height = height;
      lowest = ~0u;
      highest = 0;
      for (unsigned y=0; y<height; y++)
        for (unsigned x=0; x<width; x++) {
          const uint32_t n = of.numbers[size_t(y0+y)*of.width + x0+x];
          numbers[y*width+x] = n;
          lowest = std::min(lowest,n);
          highest = std::max(highest,n);
        }
      if (!setRows(of.form) && !setRecursive(of.form)) setTable(of.form);
    }

    /*! Completes a block that has `form` and `pattern`, and that many bytes; how many it has then. */
    size_t finish (VertHeader* header, size_t bytes) const
    {
      header->primID = first;
      if (patternOfNumbers(form) != numbersInTable) return bytes;
      const VertNumbers table = { uint32_t(bytes),pattern.y };
      memcpy(header+1,&table,sizeof(table));
      uint8_t* const out = (uint8_t*)header + bytes;
      const size_t size = (bytesOfNumberTable(width*height,table.y)+3) & ~size_t(3);
      memset(out,0,size+sizeof(uint64_t));
      for (unsigned i=0; i<width*height; i++)
      {
        const uint32_t bit = table.y*i;
        uint64_t bits;
        memcpy(&bits,out + bit/8,sizeof(bits));
        bits |= uint64_t(numbers[i]-first) << (bit % 8);
        memcpy(out + bit/8,&bits,sizeof(bits));
      }
      return bytes+size;
    }

  private:
    bool setRows (uint32_t of)
    {
      form = of | numbersInRows;
      first = numbers[0];
      pattern.x = width > 1 ? numbers[1]-first : 0;
      pattern.y = height > 1 ? numbers[width]-first : 0;
      return isRight();
    }

    bool setRecursive (uint32_t of)
    {
      const uint32_t step = isOfTriangles(of) ? 2 : 1;
      auto code = [&](unsigned i) { return (numbers[i]-lowest)/step; };
      if ((highest-lowest)/step > 255) return false;
      first = lowest;
      form = of | numbersRecursive | code(0) << 8;
      pattern.x = pattern.y = 0;
      for (unsigned i=0; i<maxVertHeight; i++) {
        if ((1u << i) < width) pattern.x |= (code(1u << i)^code(0)) << (8*i);
        if ((1u << i) < height) pattern.y |= (code((1u << i)*width)^code(0)) << (8*i);
      }
      return isRight();
    }

    void setTable (uint32_t of)
    {
      form = of | numbersInTable;
      first = lowest;
      pattern.x = 0; // known when the block is written
      pattern.y = 0;
      while (((uint64_t(highest-lowest)) >> pattern.y) != 0) pattern.y++;
    }

    bool isRight () const
    {
      for (unsigned y=0; y<height; y++)
        for (unsigned x=0; x<width; x++)
          if (first + patternNumber(form,pattern,x,y) != numbers[y*width+x]) return false;
      return true;
    }

    unsigned width, height; //!< in quads
    uint32_t numbers[vertBlockQuads*vertBlockQuads];
    uint32_t lowest, highest, first;
  };
}}
