// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The bounds of a block of cVERT in a segment of its motion, straight from its steps. */

#include "boxes.h"
#include "../base/codec.h"
#include "../../cvert/format/motion.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      class SegmentReach
      {
        struct End
        {
          const float* origin;
          VertSpacing spacing;
          uint32_t step, reach;
        };
        End ends[2];
        uint32_t form;

      public:
        bool raw; //!< an end is: there are no bounds

        __forceinline SegmentReach (const VertHeader* block, uint32_t segment)
        {
          const VertStep* const end = stepOf(block,segment+1);
          if (likely(segment == 0)) {
            form = block->boxForm;
            set(ends[0],block->origin,spacingOf(block->word,block->corners),reachStep(form),block->reach);
          }
          else {
            const VertStep* const begin = stepOf(block,segment);
            form = begin->boxForm;
            set(ends[0],begin->origin,spacingOf(begin->word,begin->corners),beginReachStep(form),begin->reach);
          }
          set(ends[1],end->origin,spacingOf(end->word,end->corners),endReachStep(end->turned),end->endReach);
          raw = isRaw(form) || isRaw(end->boxForm);
        }

        /*! of a segment without a raw end, at both ends */
        __forceinline float extent () const
        {
          return max(extentOfReach(reachOf(ends[0])),extentOfReach(reachOf(ends[1])));
        }

        /*! at a fraction of the segment */
        __forceinline void set (float f, BlockBounds& out) const
        {
          setShear(form,true,out);
          const BlockReach begin = reachOf(ends[0]), end = reachOf(ends[1]);
          static_cast<BlockReach&>(out) = reachBetween(begin,end,f);
          const float e = 1.0f-f, extent = max(extentOfReach(begin),extentOfReach(end));
          float sheared = 0.0f;
          for (int k=0; k<3; k++) {
            out.origin[k] = e*ends[0].origin[k] + f*ends[1].origin[k];
            out.extent[k] = extent;
            out.slack[k] = motionSlack(ends[0].origin[k],ends[1].origin[k],extent);
            sheared += std::fabs(out.shear[k])*out.slack[k];
          }
          out.slack[out.axis] = sheared;
        }

      private:
        static __forceinline void set (End& end, const float* origin, const VertSpacing& spacing, uint32_t step, uint32_t reach)
        {
          end.origin = origin;
          end.spacing = spacing;
          end.step = step;
          end.reach = reach;
        }

        __forceinline BlockReach reachOf (const End& end) const { return reachOfBlock(form,end.reach,end.step,end.spacing); }
      };
    }
  }
}
