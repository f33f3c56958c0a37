// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A geometry loaded from a file: it has blocks, but no input. Its mask, filters, user data and enabled state can be
 * set. Functions that read or change its input fail. */

#include "../base/codec.h"
#include "../embree/scene.h"
#include "../../cvert/file/format.h"

namespace embree
{
  class LoadedGeometry : public CompressibleGeometry
  {
  public:
    static const char* const rejectionReason; //!< message of these errors

    LoadedGeometry (Device* device, const cvert::FileGeometry& record,
                    const std::shared_ptr<const SurfaceBlocks>& blocks);

    void commit () override;
    void setMask (unsigned mask) override;
    void addElementsToCount (GeometryCounts& counts) const override { addToCount(counts); }

    void setNumPrimitives (unsigned) override { refuse(); }
    void setNumTimeSteps (unsigned numTimeSteps) override;
    void updateBuffer (RTCBufferType, unsigned) override { refuse(); }
    void setBuffer (RTCBufferType, unsigned, RTCFormat, const Ref<Buffer>&, size_t, size_t, unsigned) override {
      refuse();
    }
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

    const BBox1f ownTimes; //!< times of the first and last step
  };

  inline void requireEditable (Geometry* geometry) {
    if (dynamic_cast<const LoadedGeometry*>(geometry))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,LoadedGeometry::rejectionReason);
  }
}
