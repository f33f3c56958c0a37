// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What a child of a flat node is: 5 bits for the type, and 27 that count the things of the type. Blocks,
 * which take 64 bytes at least, are counted and not placed, so that 27 bits are enough for 8 GiB of them and more. */

#ifndef CBVH_REFERENCE_H
#define CBVH_REFERENCE_H

#include "kinds.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t referenceShift = 27u;
CVERT_CONSTANT uint32_t referenceMask = 0x7FFFFFFu;

CVERT_CONSTANT uint32_t nodeReference = 0u;       //!< so that the reference is the index
CVERT_CONSTANT uint32_t cellReference = 1u;       //!< 2 x 2 quads of a grid of GRID
CVERT_CONSTANT uint32_t instanceReference = 2u;
CVERT_CONSTANT uint32_t movingNodeReference = 3u; //!< a node whose children move
CVERT_CONSTANT uint32_t triangleReference = 4u;   //!< 4 to 7: 1 to 4 triangles that follow each other, from the index on
CVERT_CONSTANT uint32_t firstBlockReference = 8u; //!< and the number of the kind
CVERT_CONSTANT uint32_t movingBlockReference = firstBlockReference + maxKinds; //!< of cVERT
CVERT_CONSTANT uint32_t meshBlockReference = movingBlockReference + 1u;        //!< of cVERT
CVERT_CONSTANT uint32_t numReferenceTypes = meshBlockReference + 1u;

/*! a child that is none; its type is no other's */
CVERT_CONSTANT uint32_t emptyReference = 0xFFFFFFFFu;

CVERT_FUNCTION uint32_t makeReference (uint32_t type, uint32_t index) { return (type << referenceShift) | index; }
CVERT_FUNCTION uint32_t referenceType (uint32_t reference) { return reference >> referenceShift; }
CVERT_FUNCTION uint32_t referenceIndex (uint32_t reference) { return reference & referenceMask; }
CVERT_FUNCTION uint32_t blockReference (uint32_t kind) { return firstBlockReference + kind; }

/*! of a run of 1 to maxTriangleRun triangles */
CVERT_CONSTANT uint32_t maxTriangleRun = 4u;
CVERT_FUNCTION uint32_t runReference (uint32_t first, uint32_t count) { return makeReference(triangleReference + count-1u,first); }
CVERT_FUNCTION bool isRunType (uint32_t type) { return (type & ~(maxTriangleRun-1u)) == triangleReference; }
CVERT_FUNCTION uint32_t countOfRun (uint32_t type) { return type - triangleReference + 1u; }

/* A grid of GRID, Embree's GridSOA, in words: vertices along u and along v, vertices in all, IDs, and how
 * many bytes behind the data's begin are four planes: x, y, z, and u and v in 16 bits each, of which 1 is
 * an eighth. */
CVERT_CONSTANT uint32_t gridWidthWord = 3u, gridHeightWord = 4u, gridPlaneWord = 5u, gridGeometryWord = 6u, gridPrimitiveWord = 7u;
CVERT_CONSTANT uint32_t gridOffsetWord = 9u, gridDataWord = 12u;

CBVH_END

#ifndef VULKAN
static_assert(embree::cbvh::numReferenceTypes <= embree::cbvh::emptyReference >> embree::cbvh::referenceShift, "types of references");
#endif

#endif
