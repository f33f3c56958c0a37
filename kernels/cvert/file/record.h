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
} // namespace cvert
