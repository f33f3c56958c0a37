// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a cVERT block, the same floats as in traversal. */

#include "../base/codec.h"
#include "../../cvert/decoder/decoded_block.h"
#include "stored_triangles.h"
#include <cmath>

namespace embree
{
  namespace cbvh
  {
    class VerticesAtTime
    {
    public:
      float vertices[DecodedBlock::maxSide*DecodedBlock::maxSide][3];
      const uint32_t width;

      VerticesAtTime (const VertHeader* block, const TraversalTime& at) : width(vertQuadsX(block->region)+1)
      {
        const size_t bytes = sizeof(vertices[0])*width*(vertQuadsY(block->region)+1);
        if (!isMoving(block->boxForm)) {
          memcpy(vertices,DecodedBlock(block).vertices,bytes);
          return;
        }
        const TimeInMotion in = timeInMotion(motionOf(block),at.time);
        const DecodedBlock before(block,in.segment);
        const DecodedBlock after(block,in.segment+1);
        for (size_t i=0; i<bytes/sizeof(float); i++)
          (&vertices[0][0])[i] = between((&before.vertices[0][0])[i],(&after.vertices[0][0])[i],in.fraction,at.isFused);
      }

      const float* vertex (uint32_t x, uint32_t y) const { return vertices[y*width+x]; }

      /*! True if a block exists at a time. Always true if it does not move. */
      static bool isPresent (const VertHeader* block, const TraversalTime& at) {
        return !isMoving(block->boxForm) || cbvh::isPresent(motionOf(block),at.time);
      }

    private:
      /*! Interpolates as vert/moving_block.h does for vectors. */
      static float between (float a, float b, float f, bool isFused)
      {
        const float last = f*b;
        return isFused ? std::fma(1.0f-f,a,last) : (1.0f-f)*a + last;
      }
    };
  }
}
