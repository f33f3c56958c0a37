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

    void setNumPrimitives (unsigned) override { rejectChange(); }
    void setNumTimeSteps (unsigned numTimeSteps) override;
    void updateBuffer (RTCBufferType, unsigned) override { rejectChange(); }
    void setBuffer (RTCBufferType, unsigned, RTCFormat, const Ref<Buffer>&, size_t, size_t, unsigned) override {
      rejectChange();
    }
    void* getBuffer (RTCBufferType, unsigned) override { rejectChange(); }
    void setVertexAttributeCount (unsigned) override { rejectChange(); }
    void setTopologyCount (unsigned) override { rejectChange(); }
    void setVertexAttributeTopology (unsigned, unsigned) override { rejectChange(); }
    void setTessellationRate (float) override { rejectChange(); }
    void setSubdivisionMode (unsigned, RTCSubdivisionMode) override { rejectChange(); }
    void setDisplacementFunction (RTCDisplacementFunctionN) override { rejectChange(); }
    void interpolate (const RTCInterpolateArguments*) override { rejectChange(); }
    void interpolateN (const RTCInterpolateNArguments*) override { rejectChange(); }
    unsigned getFirstHalfEdge (unsigned) override { rejectChange(); }
    unsigned getFace (unsigned) override { rejectChange(); }
    unsigned getNextHalfEdge (unsigned) override { rejectChange(); }
    unsigned getPreviousHalfEdge (unsigned) override { rejectChange(); }
    unsigned getOppositeHalfEdge (unsigned, unsigned) override { rejectChange(); }

  private:
    [[noreturn]] static void rejectChange ();

    const BBox1f ownTimes; //!< times of the first and last step
  };

  inline void requireEditable (Geometry* geometry) {
    if (dynamic_cast<const LoadedGeometry*>(geometry))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,LoadedGeometry::rejectionReason);
  }
}
