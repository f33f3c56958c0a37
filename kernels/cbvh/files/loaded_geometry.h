// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A geometry loaded from a file has blocks, but no input. Its mask, filters, user data and enabled state can be set.
 * Functions that read or change input throw RTC_ERROR_INVALID_OPERATION. So does commit() if the time range of moving
 * blocks was changed. */

#include "../base/codec_names.h"
#include "../embree/scene.h"
#include "../../cvert/file/format.h"

namespace embree {
class LoadedGeometry : public CompressibleGeometry {
public:
  static const char* const noInputMessage; //!< message of the functions that fail

  /*! record: entry of the file's directory. blocks: result of loadSurface(). The constructor commits
   *  the geometry. */
  LoadedGeometry(Device* device, const cvert::FileGeometry& record, const std::shared_ptr<const SurfaceBlocks>& blocks);

  void commit() override;
  void setMask(unsigned mask) override;
  void addElementsToCount(GeometryCounts& counts) const override { addToCount(counts); }

  void setNumPrimitives(unsigned) override { rejectAccess(); }
  void setNumTimeSteps(unsigned numTimeSteps) override;
  void updateBuffer(RTCBufferType, unsigned) override { rejectAccess(); }
  void setBuffer(RTCBufferType, unsigned, RTCFormat, const Ref<Buffer>&, size_t, size_t, unsigned) override {
    rejectAccess();
  }
  void* getBuffer(RTCBufferType, unsigned) override { rejectAccess(); }
  void setVertexAttributeCount(unsigned) override { rejectAccess(); }
  void setTopologyCount(unsigned) override { rejectAccess(); }
  void setVertexAttributeTopology(unsigned, unsigned) override { rejectAccess(); }
  void setTessellationRate(float) override { rejectAccess(); }
  void setSubdivisionMode(unsigned, RTCSubdivisionMode) override { rejectAccess(); }
  void setDisplacementFunction(RTCDisplacementFunctionN) override { rejectAccess(); }
  void interpolate(const RTCInterpolateArguments*) override { rejectAccess(); }
  void interpolateN(const RTCInterpolateNArguments*) override { rejectAccess(); }
  unsigned getFirstHalfEdge(unsigned) override { rejectAccess(); }
  unsigned getFace(unsigned) override { rejectAccess(); }
  unsigned getNextHalfEdge(unsigned) override { rejectAccess(); }
  unsigned getPreviousHalfEdge(unsigned) override { rejectAccess(); }
  unsigned getOppositeHalfEdge(unsigned, unsigned) override { rejectAccess(); }

private:
  [[noreturn]] static void rejectAccess();

  const BBox1f fileTimes; //!< times of the first and last step, which moving blocks store; 0 to 1 for static blocks
};

/*! Throws RTC_ERROR_INVALID_OPERATION if a geometry was loaded from a file. */
inline void requireEditable(Geometry* geometry) {
  if (dynamic_cast<const LoadedGeometry*>(geometry))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, LoadedGeometry::noInputMessage);
}
} // namespace embree
