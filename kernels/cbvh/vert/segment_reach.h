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
          auto of = [&](const End& end) { return vertExtent(form,end.reach,end.step,end.spacing); };
          return max(of(ends[0]),of(ends[1]));
        }

        /*! at a fraction of the segment */
        __forceinline void set (float f, BlockBounds& out) const
        {
          const float e = 1.0f-f;
          setShear(form,true,out);
          float size = 0.0f;
          for (int k=0; k<3; k++) {
            out.origin[k] = e*ends[0].origin[k] + f*ends[1].origin[k];
            out.extent[k] = extent();
            /* as MotionDecoder::widenSheared */
            const float ofAxis = (max(std::fabs(ends[0].origin[k]),std::fabs(ends[1].origin[k])) + 2.0f*out.extent[k])*(1.0f/(1 << 20));
            out.slack[k] = ofAxis;
            size += std::fabs(out.shear[k])*ofAxis;
          }
          out.slack[out.axis] = size;
          for (int i=0; i<2; i++) {
            const int k = axisAfter(out.axis,1+i);
            out.upper[i] = e*at(0,i,k) + f*at(1,i,k);
            out.sheared[i] = e*at(0,2+i,out.axis) + f*at(1,2+i,out.axis);
          }
        }

      private:
        static __forceinline void set (End& end, const float* origin, const VertSpacing& spacing, uint32_t step, uint32_t reach)
        {
          end.origin = origin;
          end.spacing = spacing;
          end.step = step;
          end.reach = reach;
        }

        __forceinline float at (int end, int i, int axis) const { return float(cvert::reachOf(ends[end].reach,i))*float(ends[end].step)*ends[end].spacing.at[axis]; }
      };
    }
  }
}
