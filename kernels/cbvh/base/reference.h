// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* References to children of flat nodes (flat/flat_scene.h), for GPUs: 5 bits of type, 27 bits of index. Blocks have at
 * least 64 bytes, so indices support 8 GiB of blocks. Compiled as C++ and GLSL. */

#ifndef CBVH_REFERENCE_H
#define CBVH_REFERENCE_H

#include "kinds.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t referenceShift = 27u;
CVERT_CONSTANT uint32_t referenceMask = 0x7FFFFFFu;

CVERT_CONSTANT uint32_t nodeReference = 0u;       //!< 0, so that the reference is the index
CVERT_CONSTANT uint32_t gridLeafReference = 1u;   //!< 2 x 2 quads of a grid of GRID
CVERT_CONSTANT uint32_t instanceReference = 2u;
CVERT_CONSTANT uint32_t movingNodeReference = 3u; //!< node with moving children
CVERT_CONSTANT uint32_t triangleReference = 4u;   //!< 4 to 7: 1 to 4 triangles, starting at the index
CVERT_CONSTANT uint32_t firstBlockReference = 8u; //!< of kind 0; add the kind
CVERT_CONSTANT uint32_t movingBlockReference = firstBlockReference + maxKinds;
CVERT_CONSTANT uint32_t meshBlockReference = movingBlockReference + 1u;        //!< cVERT mesh block
CVERT_CONSTANT uint32_t numReferenceTypes = meshBlockReference + 1u;

/*! Unused child. */
CVERT_CONSTANT uint32_t emptyReference = 0xFFFFFFFFu;

CVERT_FUNCTION uint32_t makeReference (uint32_t type, uint32_t index) { return (type << referenceShift) | index; }
CVERT_FUNCTION uint32_t referenceType (uint32_t reference) { return reference >> referenceShift; }
CVERT_FUNCTION uint32_t referenceIndex (uint32_t reference) { return reference & referenceMask; }
CVERT_FUNCTION uint32_t blockReference (uint32_t kind) { return firstBlockReference + kind; }

/* A run is a leaf of consecutive triangles. Its type contains their count. */
CVERT_CONSTANT uint32_t maxTriangleRun = 4u;
CVERT_FUNCTION uint32_t runReference (uint32_t first, uint32_t count) {
  return makeReference(triangleReference + count-1u,first);
}
CVERT_FUNCTION bool isRunType (uint32_t type) { return (type & ~(maxTriangleRun-1u)) == triangleReference; }
CVERT_FUNCTION uint32_t countOfRun (uint32_t type) { return type - triangleReference + 1u; }

/* Word offsets in Embree's GridSOA: vertices along u and v, vertices in total, IDs, and the byte offset, from the start
 * of the data, of four planes: x, y, z, and (u,v) as 16-bit values in units of 1/8192. */
CVERT_CONSTANT uint32_t gridWidthWord = 3u, gridHeightWord = 4u, gridPlaneWord = 5u, gridGeometryWord = 6u,
  gridPrimitiveWord = 7u;
CVERT_CONSTANT uint32_t gridOffsetWord = 9u, gridDataWord = 12u;

CBVH_END

#ifndef VULKAN
static_assert(embree::cbvh::numReferenceTypes <= embree::cbvh::emptyReference >> embree::cbvh::referenceShift,
              "types of references");
#endif

#endif
