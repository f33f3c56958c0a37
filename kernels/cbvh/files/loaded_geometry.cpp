// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "loaded_geometry.h"
#include "../base/kinds.h"
#include "../base/number_text.h"
#include "../blocks/surface_blocks.h"

namespace embree {
const char* const LoadedGeometry::noInputMessage =
    "the geometry was loaded from a file: it has compressed blocks, but no input (vertices, faces, rates, time steps) "
    "to read, interpolate or change, and its compression is fixed";

static Geometry::GType typeOf(const cvert::FileGeometry& record) {
  switch (record.source) {
  case cbvh::FILE_GRIDS: return Geometry::GTY_GRID_MESH;
  case cbvh::FILE_QUADS: return Geometry::GTY_QUAD_MESH;
  case cbvh::FILE_TRIANGLES: return Geometry::GTY_TRIANGLE_MESH;
  default: return Geometry::GTY_SUBDIV_MESH;
  }
}

LoadedGeometry::LoadedGeometry(Device* device, const cvert::FileGeometry& record,
                               const std::shared_ptr<const SurfaceBlocks>& blocks)
  : CompressibleGeometry(device, typeOf(record), record.numPrimitives, record.numTimeSteps),
    fileTimes(record.numTimeSteps > 1 ? BBox1f(record.begin, record.end) : BBox1f(0.0f, 1.0f)) {
  setCompressed(true);
  if (numTimeSteps > 1) time_range = fileTimes;
  compression.compression = cbvh::compressionOfLoaded(record.compression);
  surface.number = blocks->number;
  surface.blocks = blocks;
  surface.inputReleased = true;
  LoadedGeometry::commit();
}

void LoadedGeometry::rejectAccess() { throw_RTCError(RTC_ERROR_INVALID_OPERATION, noInputMessage); }

void LoadedGeometry::commit() {
  if (numTimeSteps > 1 && (time_range.lower != fileTimes.lower || time_range.upper != fileTimes.upper))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the time range of a geometry that was loaded from a file cannot be "
                                                "changed: expected " +
                                                    numberText(fileTimes.lower) + " to " + numberText(fileTimes.upper) +
                                                    ", the time range in the file");
  Geometry::commit();
  surface.commit(modCounter_);
}

void LoadedGeometry::setMask(unsigned mask) {
  this->mask = mask;
  surface.changeVisibility(1);
  Geometry::update();
}

void LoadedGeometry::setNumTimeSteps(unsigned numTimeSteps) {
  if (numTimeSteps != this->numTimeSteps) rejectAccess();
}
} // namespace embree
