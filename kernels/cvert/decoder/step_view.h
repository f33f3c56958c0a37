// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A time step of a block: the block itself at its first step, VertStep at later ones. Both store the same parts in different places; a view
 * hides the difference. */

#include "../format/motion.h"

namespace cvert { inline namespace CVERT_ISA
{
  struct StepView
  {
    const uint8_t* data;      //!< start of the block or of the step
    const VertStep* later;    //!< null at the first step
    const float* origin;
    const uint32_t* corners;
    uint32_t form;            //!< boxForm
    uint32_t word;            //!< of the first cell
    uint32_t remainders, margins, words, wordsHigh, cell, vertices; //!< offsets from data, as in VertLayout

    /*! layout: of the block; step: less than its number of steps, 0 if it does not move */
    CVERT_INLINE StepView (const VertHeader* block, const VertLayout& layout, uint32_t step)
    {
      if (step == 0) {
        later = nullptr;
        data = (const uint8_t*)block;
        origin = block->origin; corners = block->corners; form = block->boxForm; word = block->word;
        set(layout);
        highMask = ~0u;
      }
      else {
        later = stepOf(block,step);
        data = (const uint8_t*)later;
        origin = later->origin; corners = later->corners; form = later->boxForm; word = later->word;
        set(vertStepLayout(block->region,form));
        highMask = hasUpperBits(form) ? ~0u : 0u;
        if (!hasUpperBits(form)) wordsHigh = words; // wordOf reads there and drops it
      }
    }

    bool isRaw () const { return cvert::isRaw(form); }
    bool hasHigh () const { return highMask != 0u; }

    /*! Returns the word of a group; g = -1 is the first cell. */
    CVERT_INLINE uint32_t wordOf (int g) const
    {
      if (g < 0) return word;
      uint16_t low;
      std::memcpy(&low,data+words+2*g,sizeof(low));
      return uint32_t(low) | (uint32_t(data[wordsHigh+uint32_t(g)]) << 16 & highMask);
    }

    /*! True if the residuals of a cell are predicted from the first step. */
    bool isTurned (int g) const { return later && (g < 0 ? isFirstCellTurned(form) : cvert::isTurned(later->turned,uint32_t(g))); }

    /*! Offset of the fields of a group. */
    CVERT_INLINE uint32_t fieldsOf (int g) const
    {
      uint32_t at = cell;
      for (int before=-1; before<g; before++) at += cellBytes(wordOf(before));
      return at;
    }

  private:
    template<typename Layout>
    CVERT_INLINE void set (const Layout& layout)
    {
      remainders = layout.remainders; margins = layout.margins; words = layout.words; wordsHigh = layout.wordsHigh;
      cell = layout.cell; vertices = layout.vertices;
    }

    uint32_t highMask;
  };
}}
