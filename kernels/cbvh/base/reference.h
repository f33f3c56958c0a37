// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What a child of a flat node is: 3 bits that say what kind of thing, 29 that say which. */

#ifndef CBVH_REFERENCE_H
#define CBVH_REFERENCE_H

#include "../framed/block.h"

CBVH_BEGIN

CBVH_CONSTANT uint32_t referenceShift = 29u;
CBVH_CONSTANT uint32_t referenceMask = 0x1FFFFFFFu;

/*! 0: a node. 1 to 4: a block of a kind, kindGrid to kindVert. */
CBVH_CONSTANT uint32_t nodeReference = 0u;
CBVH_CONSTANT uint32_t firstBlockReference = 1u;
CBVH_CONSTANT uint32_t cellReference = 5u;     //!< 2 x 2 quads of a grid of GRID
CBVH_CONSTANT uint32_t triangleReference = 6u; //!< triangles that follow each other, see triangleRun
CBVH_CONSTANT uint32_t instanceReference = 7u;
CBVH_CONSTANT uint32_t numReferenceTypes = 8u;

/*! a child that is none */
CBVH_CONSTANT uint32_t emptyReference = 0xFFFFFFFFu;

CBVH_FUNCTION uint32_t makeReference (uint32_t type, uint32_t index) { return (type << referenceShift) | index; }
CBVH_FUNCTION uint32_t referenceType (uint32_t reference) { return reference >> referenceShift; }
CBVH_FUNCTION uint32_t referenceIndex (uint32_t reference) { return reference & referenceMask; }

/*! The index of a run of triangles: where it begins in the list of them, and how many they are, at
 *  most maxTriangleRun. */
CBVH_CONSTANT uint32_t maxTriangleRun = 4u;
CBVH_CONSTANT uint32_t triangleRunBits = 2u;
CBVH_FUNCTION uint32_t triangleRun (uint32_t first, uint32_t count) { return (first << triangleRunBits) | (count-1u); }
CBVH_FUNCTION uint32_t firstOfRun (uint32_t index) { return index >> triangleRunBits; }
CBVH_FUNCTION uint32_t countOfRun (uint32_t index) { return (index & (maxTriangleRun-1u)) + 1u; }

/* A grid of GRID, Embree's GridSOA, in words: vertices along u and along v, vertices in all, IDs, and how
 * many bytes behind the data's begin are four planes: x, y, z, and u and v in 16 bits each, of which 1 is
 * an eighth. */
CBVH_CONSTANT uint32_t gridWidthWord = 3u, gridHeightWord = 4u, gridPlaneWord = 5u, gridGeometryWord = 6u, gridPrimitiveWord = 7u;
CBVH_CONSTANT uint32_t gridOffsetWord = 9u, gridDataWord = 12u;

CBVH_END

#endif
