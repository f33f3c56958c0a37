// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Validates blocks with frames (paper/block.h). */

#include "../paper/block.h"
#include "../base/codec_names.h"
#include "../../cvert/file/format.h"
#include "../../cvert/decoder/validate.h"
#include "../../cvert/portable/reason.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Returns the first error in a frame. */
inline Reason validateFrame(const BlockHeader& header) {
  bool isConstant = true; // W may still depend on the point
  for (int i = 0; i < 3; i++) {
    if (!std::isfinite(header.center[i])) return Reason::damaged("the center of its frame is not finite");
    for (int k = 0; k < 4; k++) {
      if (!std::isfinite(header.columns[i][k])) return Reason::damaged("a column of its frame is not finite");
      isConstant &= k == 3 || header.columns[i][k] == 0.0f;
    }
  }
  return isConstant ? Reason::damaged("X, Y and Z of its frame do not depend on the point") : Reason();
}

/*! Returns the first error in a block of at most `bytes` bytes. Decoders read no memory outside of a valid
 *  block. */
inline Reason validateFramedBlock(const void* data, size_t bytes) {
  if (bytes < blockHeaderBytes) return Reason::damaged("it has % bytes: its header needs %", bytes, blockHeaderBytes);
  const BlockHeader& header = *(const BlockHeader*)data;
  const uint32_t kind = kindOf(header.info), height = heightOf(header.info);
  if (kind >= numKindFormats || !((framedKinds >> kind) & 1)) return Reason::damaged("its kind % is unknown", kind);
  if (height > maxFramedLevel)
    return Reason::damaged("its height % is out of range: expected 0 to %", height, maxFramedLevel);
  if (const Reason reason = validateFrame(header)) return reason;
  const uint32_t u = cornerUOf(header.tiling), v = cornerVOf(header.tiling);
  if (!isPatchCorner(u, v))
    return Reason::damaged("its patch starts at (%/2,%/2): expected (0,0), or each 1/2, 5/2, 9/2 or 13/2", u, v);
  if (blockXOf(header.info) > lastXOf(header.tiling) || blockYOf(header.info) > lastYOf(header.tiling))
    return Reason::damaged("it lies outside of its patch");
  const size_t needed = blockLayout(kind, height).bytes;
  return bytes < needed ? Reason::damaged("it has % bytes: its nodes and leaves need %", bytes, needed) : Reason();
}

/*! Also checks that the block's primitive exists. record: of the block's geometry. */
inline Reason validateFramedInFile(const FileGeometry& record, const void* data, size_t bytes) {
  if (const Reason reason = validateFramedBlock(data, bytes)) return reason;
  const uint32_t primID = ((const BlockHeader*)data)->primID;
  return primID < record.numPrimitives
             ? Reason()
             : Reason::damaged("primitive % is out of range: the geometry has %", primID, record.numPrimitives);
}
}} // namespace embree::cbvh::CBVH_ISA
