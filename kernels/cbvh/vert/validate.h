// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether bytes are a block of cVERT that readers may take: its sizes, its numbers of bits and its offsets fit together and into
 * the memory that there is. Fields may be anything: they are vertices somewhere. */

#include "motion_format.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    /*! bytes that decoders may read behind a block */
    static constexpr size_t readBehindVert = 16;

    /*! True if a patch's corner, in halves, is that of a face with four corners, or of a sub-patch of another face, as
     *  Embree places them: from 1/2, two units from one to the next, up to 4 in a row. */
    inline bool isPatchCorner(uint32_t u, uint32_t v) { return (u == 0 && v == 0) || (u % 4 == 1 && v % 4 == 1 && u <= 13 && v <= 13); }

    class VertValidation
    {
    public:
      /*! Null if a block begins at data, which is aligned, and takes at most that many bytes; else what is wrong. Reads no other bytes. */
      static const char* errorOf(const void* data, size_t bytes)
      {
        if (bytes < vertHeaderBytes) return "fewer bytes than a header has";
        const VertHeader& header = *(const VertHeader*)data;
        if (versionOfCorners(header.corners[4],header.corners[5]) != vertFormatVersion) return "a version of the format that this library does not read";
        if (reservedOfCorners(header.corners[4],header.corners[5]) != 0) return "parts of a later format";
        if (hasEdges(header.boxForm) && hasNumbers(header.boxForm)) return "parts of a later format";
        for (float x : header.origin)
          if (!std::isfinite(x)) return "an origin that is not finite";
        const VertLayout layout = vertLayout(header.region,header.boxForm);
        if (bytes < layout.margins) return "fewer bytes than header, edges and motion have";
        if (const char* error = hasNumbers(header.boxForm) ? errorOfNumbers(header) : errorOfPatch(header)) return error;
        size_t end;
        if (const char* error = errorOfFirstStep(header,layout,bytes,end)) return error;
        if (isMoving(header.boxForm))
          if (const char* error = errorOfMotion(header,layout,bytes,end)) return error;
        return errorOfTable(header,end,bytes);
      }

    private:
      /*! axis and slopes, of a cell's word and of boxes */
      static bool isForm(uint32_t word) { return cellMainAxis(word) < 3 && cellSlope(word,1) >= -maxSlope && cellSlope(word,2) >= -maxSlope; }

      static const char* errorOfCells(uint32_t word, const uint32_t corners[6])
      {
        const VertSpacing spacing = vertSpacing(word,corners);
        for (float x : spacing.at)
          if (!(x >= std::numeric_limits<float>::min() && x < infinity)) return "a spacing out of range";
        return isForm(word) ? nullptr : "a main axis or a slope of the first cell that is none";
      }

      /*! end: of the step */
      static const char* errorOfFirstStep(const VertHeader& header, const VertLayout& layout, size_t bytes, size_t& end)
      {
        end = layout.rawBytes;
        if (isRaw(header.boxForm)) return bytes < end ? "fewer bytes than its vertices and boxes have" : nullptr;
        if (const char* error = errorOfCells(header.word,header.corners)) return error;
        if (!isForm(header.boxForm)) return "a sheared axis or a slope that is none";
        if (bytes < layout.cell) return "fewer bytes than header, margins and words have";
        const uint8_t* block = (const uint8_t*)&header;
        end = layout.cell + cellBytes(header.word);
        for (uint32_t g=0; g<layout.groups; g++)
        {
          const uint32_t word = uint32_t(block[layout.words+2*g]) | uint32_t(block[layout.words+2*g+1]) << 8 | uint32_t(block[layout.wordsHigh+g]) << 16;
          if (!isForm(word)) return "a main axis or a slope of a group that is none";
          end += cellBytes(word);
        }
        if (bytes < end) return "fewer bytes than its fields have";
        return hasRemainders(header.boxForm) ? errorOfRemainders(vertSpacing(header.word,header.corners),remaindersAt(block,layout.remainders),header.region,bytes,end) : nullptr;
      }

      /*! end: of fields, then of remainders */
      static const char* errorOfRemainders(const VertSpacing& spacing, uint32_t remainders, uint32_t region, size_t bytes, size_t& end)
      {
        if (remainders & 0x8000u) return "parts of a later format";
        for (int k=0; k<3; k++) {
          const uint32_t bits = remainderBits(remainders,k);
          if (bits == remaindersAreFloats) continue;
          if (bits > maxRemainderBits) return "a remainder of too many bits";
          if (!(remainderSpacing(spacing.at[k],bits) >= std::numeric_limits<float>::min())) return "remainders out of range";
        }
        if (remainderOffset(remainders) < end) return "remainders on other parts of the block";
        end = size_t(remainderOffset(remainders)) + bytesOfRemainders(remainders,region);
        return bytes < end ? "fewer bytes than its remainders have" : nullptr;
      }

      /*! end: of the first step, then of the last */
      static const char* errorOfMotion(const VertHeader& header, const VertLayout& layout, size_t bytes, size_t& end)
      {
        const VertMotion motion = motionOf(&header);
        if (!std::isfinite(motion.begin) || !(motion.begin < motion.end) || !std::isfinite(motion.end)) return "a time that ends before it begins";
        if (motion.numSteps < 2 || motion.numSteps > maxTimeSteps) return "a number of time steps that is none";
        if (motion.steps < end || motion.steps % 4 != 0) return "offsets of time steps on other parts of the block";
        end = size_t(motion.steps) + 4*(motion.numSteps-1);
        if (bytes < end) return "fewer bytes than offsets of time steps have";
        for (uint32_t s=1; s<motion.numSteps; s++)
        {
          const VertStep* const step = stepOf(&header,s);
          const size_t begin = size_t((const uint8_t*)step - (const uint8_t*)&header);
          if (begin < end || begin % 4 != 0) return "a time step on other parts of the block";
          if (bytes < begin + vertStepBytes) return "fewer bytes than a time step has";
          if (const char* error = errorOfStep(header,layout,*step,bytes-begin,end)) return error;
          end += begin;
        }
        return nullptr;
      }

      /*! end: its bytes */
      static const char* errorOfStep(const VertHeader& header, const VertLayout& layout, const VertStep& step, size_t bytes, size_t& end)
      {
        for (float x : step.origin)
          if (!std::isfinite(x)) return "an origin that is not finite";
        const VertStepLayout at = vertStepLayout(header.region,step.boxForm);
        end = at.rawBytes;
        if (isRaw(step.boxForm)) return bytes < end ? "fewer bytes than a step's vertices have" : nullptr;
        if (const char* error = errorOfCells(step.word,step.corners)) return error;
        if (versionOfCorners(step.corners[4],step.corners[5]) != 0 || reservedOfCorners(step.corners[4],step.corners[5]) != 0) return "parts of a later format";
        if (!isForm(step.boxForm)) return "a sheared axis or a slope that is none";
        if (isRaw(header.boxForm) && ((step.turned & 65535u) || isFirstCellTurned(step.boxForm))) return "a cell that is turned from a step that has none";
        if (((step.turned >> 16) & 7u) == 7u) return "a matrix's scale that is none";
        if (bytes < at.cell) return "fewer bytes than a step's margins and words have";
        end = at.cell + cellBytes(step.word);
        for (uint32_t g=0; g<layout.groups; g++) {
          const uint32_t word = wordOfGroup(&step,at,g);
          if (!isForm(word)) return "a main axis or a slope of a group that is none";
          end += cellBytes(word);
        }
        if (bytes < end) return "fewer bytes than a step's fields have";
        return hasRemainders(step.boxForm) ? errorOfRemainders(vertSpacing(step.word,step.corners),remaindersAt(&step,at.remainders),header.region,bytes,end) : nullptr;
      }

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
        if (!isPatchCorner(vertCornerU(edges),vertCornerV(edges))) return "a patch whose corner is outside of its face";
        for (int s=0; s<4; s++)
          if (vertRate(edges,s) > quads[s & 1]) return "an edge of a higher rate than its patch has quads";
        return nullptr;
      }
    };
  }}
}
