// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks a geometry's record and blocks. Writers and readers use the same checks, so that saved files can be loaded. */

#include "format.h"
#include "../decoder/validate.h"
#include "../decoder/validate_mesh.h"

namespace cvert {
/*! True if the box is finite and not empty. */
bool areBounds(const float lower[3], const float upper[3]);

/*! Checks a record, except for the positions of tree and blocks and for checksums. */
Reason validateRecord(const FileGeometry& record);

/*! Checks a cVERT block of at most `bytes` bytes (validateVert), its time steps, and that its primitives exist. Does
 *  not check its surface number. */
Reason validateVertBlock(const FileGeometry& record, const void* data, size_t bytes);

/*! The same for a mesh block, static or moving. */
Reason validateMeshBlock(const FileGeometry& record, const void* data, size_t bytes);

/*! The same for a block of any type. framed: called for blocks with frames as framed(record,data,bytes). */
template<typename ValidateFramed>
Reason validateBlock(BlockType type, const FileGeometry& record, const void* data, size_t bytes,
                     const ValidateFramed& framed) {
  switch (type) {
  case FRAMED_BLOCK: return framed(record, data, bytes);
  case VERT_BLOCK: return validateVertBlock(record, data, bytes);
  case MESH_BLOCK: return validateMeshBlock(record, data, bytes);
  case TILE_BLOCK: break; // not in files
  }
  return Reason::damaged("its type % is unknown", type);
}

/*! True if a geometry's tree may refer to blocks of the type. moves: whether the geometry moves. */
inline bool isKnownBlock(BlockType type, bool moves) {
  switch (type) {
  case FRAMED_BLOCK: return !moves;
  case VERT_BLOCK:
  case MESH_BLOCK: return true;
  case TILE_BLOCK: return false;
  }
  return false;
}

/*! Lowest FileHeader::vertVersion of a file with such a child. */
inline uint32_t leastVertVersion(FileChild child) {
  switch (child) {
  case FILE_MESH: return meshFormatVersion;
  case FILE_MOVING_MESH: return movingMeshFormatVersion;
  case FILE_NONE:
  case FILE_NODE:
  case FILE_FRAMED:
  case FILE_VERT:
  case FILE_MOVING_VERT:
  case FILE_CHILD_MASK: return vertFormatVersion;
  }
  return vertFormatVersion;
}
} // namespace cvert
