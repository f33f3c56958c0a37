// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts geometries to what cvert::FileWriter writes, for operations/files.h. The inverse of loaded_surface.h. */

#include "../base/codec_names.h"
#include "../../cvert/file/writer.h"

namespace embree {
class CompressibleGeometry;
struct SurfaceBlocks;

namespace cbvh {
/*! Prepares a geometry for cvert::FileWriter. The blocks must outlive the result. Throws
 *  RTC_ERROR_INVALID_OPERATION if a part of the geometry is not compressed, a block of a file is damaged, or bounds
 *  are not finite. */
FileSurface toFileSurface(const CompressibleGeometry* geometry, const SurfaceBlocks& blocks);
} // namespace cbvh
} // namespace embree
