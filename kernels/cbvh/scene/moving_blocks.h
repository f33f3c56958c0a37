// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a scene that move, with their boxes at each time step, for the tree above them. Boxes are found again from the blocks: a
 * geometry may be traced by a scene that it was not built for. */

#include "../vert/motion_decoder.h"
#include "motion_tree.h"
#include "surface_blocks.h"
#include <memory>

namespace embree
{
  namespace isa
  {
    class MovingBlocks
    {
    public:
      explicit MovingBlocks (Device* device) : blocks(device,0), boxes(device,0) {}

      void add (const SurfaceBlocks& surface)
      {
        const size_t begin = blocks.size();
        blocks.resize(begin + surface.moving.size());
        for (size_t i=0; i<surface.moving.size(); i++)
        {
          MotionTree::Block& block = blocks[begin+i];
          block.leaf = BVH4::NodeRef(surface.moving[i]);
          const cbvh::VertMotion motion = cbvh::motionOf(headerOf(block.leaf));
          block.range = BBox1f(motion.begin,motion.end);
          block.segments = motion.numSteps-1;
          numBoxes += motion.numSteps;
        }
      }

      /*! calls progress() now and then, which may cancel */
      template<typename Progress>
      void findBoxes (const Progress& progress)
      {
        boxes.resize(numBoxes);
        size_t n = 0;
        for (MotionTree::Block& block : blocks) { block.boxes = boxes.data()+n; n += block.segments+1; }
        forRanges(blocks.size(),size_t(64),[&](const range<size_t>& r) {
            std::unique_ptr<Decoded> decoded(new Decoded);
            for (size_t i=r.begin(); i!=r.end(); i++)
              decoded->bound(headerOf(blocks[i].leaf),blocks[i].segments,boxes.data() + (blocks[i].boxes-boxes.data()));
            progress();
          });
      }

      size_t size () const { return blocks.size(); }
      const mvector<MotionTree::Block>& all () const { return blocks; }

    private:
      static const cbvh::VertHeader* headerOf (BVH4::NodeRef leaf)
      {
        size_t type;
        return (const cbvh::VertHeader*)leaf.leaf(type);
      }

      /*! a block's vertices, two steps at a time */
      class alignas(64) Decoded
      {
        ALIGNED_CLASS_(64);

      public:
        /*! boxes: of each step; empty of one without a finite vertex */
        void bound (const cbvh::VertHeader* block, unsigned segments, BBox3fa* boxes)
        {
          for (unsigned s=0; s<=segments; s+=2)
          {
            const unsigned segment = min(s,segments-1);
            cbvh::MotionDecoder decoder(block);
            shared.key = { block,segment,0 };
            decoder.decode(segment,shared);
            Bounds bounds[2];
            for (uint32_t rest=shared.lanes; rest; rest&=rest-1) {
              decoder.vertices(shared,uint32_t(bsf(rest)),group);
              for (unsigned e=0; e<2; e++) bounds[e].extend(group.ends[e]);
            }
            for (unsigned e=0; e<2; e++) boxes[segment+e] = decoder.isRaw(segment+e) ? boundRaw(block,segment+e) : bounds[e].box();
          }
        }

      private:
        struct Bounds
        {
          vfloat4 lower[3] = { pos_inf,pos_inf,pos_inf }, upper[3] = { neg_inf,neg_inf,neg_inf };

          void extend (const cbvh::CellVertices& v)
          {
            for (int k=0; k<3; k++)
            {
              const vfloat4 last(v.at[k][cbvh::cellVertices-1]);
              lower[k] = min(lower[k],last);
              upper[k] = max(upper[k],last);
              for (int l=0; l<cbvh::cellVertices-1; l+=4) {
                const vfloat4 x = vfloat4::load(v.at[k]+l);
                lower[k] = min(lower[k],x);
                upper[k] = max(upper[k],x);
              }
            }
          }

          BBox3fa box () const
          {
            return BBox3fa(Vec3fa(reduce_min(lower[0]),reduce_min(lower[1]),reduce_min(lower[2])),Vec3fa(reduce_max(upper[0]),reduce_max(upper[1]),reduce_max(upper[2])));
          }
        };

        static BBox3fa boundRaw (const cbvh::VertHeader* block, unsigned step)
        {
          float bounds[2][3];
          if (!cbvh::ScalarVertBlock(block,step).bounds(bounds[0],bounds[1])) return empty;
          return BBox3fa(Vec3fa(bounds[0][0],bounds[0][1],bounds[0][2]),Vec3fa(bounds[1][0],bounds[1][1],bounds[1][2]));
        }

        cbvh::SegmentBoxes shared;
        cbvh::SegmentVertices group;
      };

      mvector<MotionTree::Block> blocks;
      mvector<BBox3fa> boxes;
      size_t numBoxes = 0;
    };
  }
}
