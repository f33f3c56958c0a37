// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A geometry that came from a file: it has blocks, and nothing that they were made from. It has a mask, filters and user data, is enabled or
 * not, and is attached and instanced as any other. What asks for a cage, or would change it, is refused. */

#include "../base/codec.h"
#include "../embree/scene.h"
#include "../../cvert/file/format.h"

namespace embree
{
  class LoadedGeometry : public CompressibleGeometry
  {
  public:
    static const char* const whyNot; //!< it cannot be edited

    LoadedGeometry (Device* device, const cvert::FileGeometry& record, const std::shared_ptr<const SurfaceBlocks>& blocks);

    void commit () override;
    void setMask (unsigned mask) override;
    void addElementsToCount (GeometryCounts& counts) const override { addToCount(counts); }

    void setNumPrimitives (unsigned) override { refuse(); }
    void setNumTimeSteps (unsigned numTimeSteps) override;
    void updateBuffer (RTCBufferType, unsigned) override { refuse(); }
    void setBuffer (RTCBufferType, unsigned, RTCFormat, const Ref<Buffer>&, size_t, size_t, unsigned) override { refuse(); }
    void* getBuffer (RTCBufferType, unsigned) override { refuse(); }
    void setVertexAttributeCount (unsigned) override { refuse(); }
    void setTopologyCount (unsigned) override { refuse(); }
    void setVertexAttributeTopology (unsigned, unsigned) override { refuse(); }
    void setTessellationRate (float) override { refuse(); }
    void setSubdivisionMode (unsigned, RTCSubdivisionMode) override { refuse(); }
    void setDisplacementFunction (RTCDisplacementFunctionN) override { refuse(); }
    void interpolate (const RTCInterpolateArguments*) override { refuse(); }
    void interpolateN (const RTCInterpolateNArguments*) override { refuse(); }
    unsigned getFirstHalfEdge (unsigned) override { refuse(); }
    unsigned getFace (unsigned) override { refuse(); }
    unsigned getNextHalfEdge (unsigned) override { refuse(); }
    unsigned getPreviousHalfEdge (unsigned) override { refuse(); }
    unsigned getOppositeHalfEdge (unsigned, unsigned) override { refuse(); }

  private:
    [[noreturn]] static void refuse ();

    const BBox1f ownTimes; //!< of the first step and of the last
  };

  /*! Throws for a geometry of a file. */
  inline void requireEditable (Geometry* geometry) {
    if (dynamic_cast<const LoadedGeometry*>(geometry))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,LoadedGeometry::whyNot);
  }
}
