// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether bytes are a block of cVERT that readers may take: its sizes, its numbers of bits and its offsets fit together and into
 * the memory that there is. Fields may be anything: they are vertices somewhere. */

#include "format.h"
#include "../surface/lattice.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    /*! bytes that decoders may read behind a block */
    static constexpr size_t readBehindVert = 16;

    class VertValidation
    {
    public:
      /*! Null if a block begins at data, which is aligned, and takes at most that many bytes; else what is wrong. Reads no other bytes. */
      static const char* errorOf(const void* data, size_t bytes)
      {
        if (bytes < vertHeaderBytes) return "fewer bytes than a header has";
        const VertHeader& header = *(const VertHeader*)data;
        if (header.boxForm >> 31 || (hasEdges(header.boxForm) && hasNumbers(header.boxForm))) return "parts of a later format";
        for (float x : header.origin)
          if (!std::isfinite(x)) return "an origin that is not finite";
        const VertLayout layout = vertLayout(header.region,header.boxForm);
        if (bytes < layout.margins) return "fewer bytes than header and edges have";
        if (const char* error = hasNumbers(header.boxForm) ? errorOfNumbers(header) : errorOfPatch(header)) return error;
        if (isRaw(header.boxForm)) return bytes < layout.rawBytes ? "fewer bytes than its vertices and boxes have" : errorOfTable(header,layout.rawBytes,bytes);

        const int exponent = int(header.word >> 24) - 127;
        if (exponent < minLatticeExponent || exponent > maxLatticeExponent) return "a spacing out of range";
        if (!isForm(header.boxForm)) return "a sheared axis or a slope that is none";
        for (int c=0; c<4; c++)
          for (int k=0; k<3; k++)
            if (cornerCoordinate(header.corners[cornerPair(c,k)],c,k) >= maxExtent) return "a corner out of range";
        if (bytes < layout.cell) return "fewer bytes than header, margins and words have";
        if (!isForm(header.word)) return "a main axis or a slope of the first cell that is none";
        const uint8_t* block = (const uint8_t*)data;
        size_t end = layout.cell + cellBytes(header.word);
        for (uint32_t g=0; g<layout.groups; g++)
        {
          const uint32_t word = uint32_t(block[layout.words+2*g]) | uint32_t(block[layout.words+2*g+1]) << 8 | uint32_t(block[layout.wordsHigh+g]) << 16;
          if (!isForm(word)) return "a main axis or a slope of a group that is none";
          end += cellBytes(word);
        }
        return bytes < end ? "fewer bytes than its fields have" : errorOfTable(header,end,bytes);
      }

    private:
      /*! axis and slopes, of a cell's word and of boxes */
      static bool isForm(uint32_t word) { return cellMainAxis(word) < 3 && cellSlope(word,1) >= -maxSlope && cellSlope(word,2) >= -maxSlope; }

      static const char* errorOfNumbers(const VertHeader& header)
      {
        if (header.patchQuads >> 16 || patternOfNumbers(header.patchQuads) > numbersInTable) return "numbers of quads of a later format";
        for (bool isSecond : { false,true })
          if (turnOfTriangle(header.patchQuads,isSecond) > 2) return "a triangle that begins with no corner of its own";
        return nullptr;
      }

      /*! end: of what is before it */
      static const char* errorOfTable(const VertHeader& header, size_t end, size_t bytes)
      {
        if (!hasNumbers(header.boxForm) || patternOfNumbers(header.patchQuads) != numbersInTable) return nullptr;
        const VertNumbers numbers = numbersOf(&header);
        if (numbers.x < end) return "a table of numbers on other parts of the block";
        if (numbers.y > 32u) return "a table of numbers with more than 32 bits for each";
        return bytes < size_t(numbers.x) + bytesOfNumberTable(vertQuadsX(header.region)*vertQuadsY(header.region),numbers.y) ? "fewer bytes than its table of numbers has" : nullptr;
      }

      static const char* errorOfPatch(const VertHeader& header)
      {
        const uint32_t quads[2] = { patchQuadsX(header.patchQuads),patchQuadsY(header.patchQuads) };
        if (vertX(header.region) + vertQuadsX(header.region) > quads[0] || vertY(header.region) + vertQuadsY(header.region) > quads[1]) return "a place outside of its patch";
        if (!hasEdges(header.boxForm)) return nullptr;
        const VertEdges edges = edgesOf(&header);
        for (int s=0; s<4; s++)
          if (vertRate(edges,s) > quads[s & 1]) return "an edge of a higher rate than its patch has quads";
        return nullptr;
      }
    };
  }}
}
