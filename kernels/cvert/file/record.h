// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks the record of a geometry and its blocks. A writer checks the record before it writes, a reader before it
 * loads, so everything that can be saved can be loaded. */

#include "format.h"
#include "../decoder/validate.h"
#include "../decoder/validate_mesh.h"

namespace cvert
{
  /*! True if the coordinates are finite and lower is not above upper. */
  bool areBounds (const float lower[3], const float upper[3]);

  /*! Checks a record except for the positions of its tree and its blocks. */
  Reason validateRecord (const FileGeometry& record);

  /*! Checks a cVERT block of a geometry, which starts at data and has at most `bytes` bytes. Does not check its surface
   *  number. Whatever the fields of a valid block are, decoders read only the block and readBehindVert bytes after it,
   *  and report primitives that the geometry has. */
  Reason validateVertBlock (const FileGeometry& record, const void* data, size_t bytes);

  /*! The same for a mesh block. */
  Reason validateMeshBlock (const FileGeometry& record, const void* data, size_t bytes);
}
