// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks the face and (u,v) of rtcInterpolate and rtcInterpolateN for subdivision surfaces, because Embree does not.
 * Other arguments, such as bufferSlot, must be valid. */

#include "../embree/isolated_tasks.h"
#include "../embree/scene.h"

namespace embree {
/*! Marks the faces that Embree cannot evaluate, in each topology: with fewer than 3 vertices, or a neighborhood that
 *  exceeds its fixed-size arrays. The commit calls it after Embree has computed the half-edges. */
void markUnsupportedFaces(SubdivMesh* mesh);

/*! Throw rtcore_error if the face does not exist, has no edges or is marked, if (u,v) is in none of the sub-patches
 *  of a face without four corners, or if the topology was not committed. Thread-safe, unless another thread changes
 *  the geometry. */
void requireSupported(const SubdivMesh* mesh, const RTCInterpolateArguments* args);
void requireSupported(const SubdivMesh* mesh, const RTCInterpolateNArguments* args);
} // namespace embree
