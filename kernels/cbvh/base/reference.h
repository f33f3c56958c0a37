// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* References to the children of flat nodes (backend/flat_scene.h), for GPUs. The upper 5 bits are the type of the
 * child. The lower 27 bits are its index in an array that depends on the type. Indices suffice for at least 8 GiB of
 * blocks: they count blocks, and a block has at least 64 bytes. Compiled as C++ and GLSL. */

#ifndef CBVH_BASE_REFERENCE_H
#define CBVH_BASE_REFERENCE_H

#include "kinds.h"

CBVH_BEGIN

CVERT_CONSTANT uint32_t referenceTypeShift = 27u;
CVERT_CONSTANT uint32_t maxReferenceIndex = 0x7FFFFFFu;

/* Types of children. The type of nodes is 0, so that a reference to a node equals the node's index. */
CVERT_CONSTANT uint32_t nodeReferenceType = 0u;
CVERT_CONSTANT uint32_t gridLeafReferenceType = 1u; //!< up to 2 x 2 quads of a grid of GRID
CVERT_CONSTANT uint32_t instanceReferenceType = 2u;
CVERT_CONSTANT uint32_t movingNodeReferenceType = 3u; //!< node with moving children
CVERT_CONSTANT uint32_t firstRunReferenceType = 4u;   //!< 4 to 7: runs of 1 to 4 triangles, see makeRunReference
CVERT_CONSTANT uint32_t firstBlockReferenceType = 8u; //!< 8 to 25: static blocks, by kind, see blockReferenceType
CVERT_CONSTANT uint32_t movingBlockReferenceType = firstBlockReferenceType + maxKinds; //!< moving cVERT block
CVERT_CONSTANT uint32_t meshBlockReferenceType = movingBlockReferenceType + 1u;        //!< static cVERT mesh block
CVERT_CONSTANT uint32_t numReferenceTypes = meshBlockReferenceType + 1u;

/*! Reference of an unused child. Its type differs from all types above. */
CVERT_CONSTANT uint32_t emptyReference = 0xFFFFFFFFu;

CVERT_FUNCTION uint32_t makeReference(uint32_t type, uint32_t index) { return (type << referenceTypeShift) | index; }
CVERT_FUNCTION uint32_t referenceType(uint32_t reference) { return reference >> referenceTypeShift; }
CVERT_FUNCTION uint32_t referenceIndex(uint32_t reference) { return reference & maxReferenceIndex; }

/*! Type of a reference to a static block. kind: see kinds.h. */
CVERT_FUNCTION uint32_t blockReferenceType(uint32_t kind) { return firstBlockReferenceType + kind; }

/* A run is a leaf of 1 to maxRunLength triangles with consecutive indices. The type of a reference to it contains the
 * number of triangles; the index of the reference is the index of the first triangle. */
CVERT_CONSTANT uint32_t maxRunLength = 4u;
CVERT_FUNCTION uint32_t makeRunReference(uint32_t first, uint32_t count) {
  return makeReference(firstRunReferenceType + count - 1u, first);
}
CVERT_FUNCTION bool isRunType(uint32_t type) { return (type & ~(maxRunLength - 1u)) == firstRunReferenceType; }
CVERT_FUNCTION uint32_t runLength(uint32_t type) { return type - firstRunReferenceType + 1u; }

/* Offsets in Embree's GridSOA, in words of 32 bits. The vertices are four planes: x, y, z, and u and v as 16-bit values
 * in units of 1/8192. */
CVERT_CONSTANT uint32_t gridWidthWord = 3u;       //!< vertices along u
CVERT_CONSTANT uint32_t gridHeightWord = 4u;      //!< vertices along v
CVERT_CONSTANT uint32_t gridPlaneStrideWord = 5u; //!< words per plane: the number of vertices
CVERT_CONSTANT uint32_t gridGeomIDWord = 6u;
CVERT_CONSTANT uint32_t gridPrimIDWord = 7u;
CVERT_CONSTANT uint32_t gridOffsetWord = 9u; //!< byte offset of the planes from the data
CVERT_CONSTANT uint32_t gridDataWord = 12u;  //!< start of the data

CBVH_END

#ifndef VULKAN
static_assert(embree::cbvh::numReferenceTypes <= embree::cbvh::emptyReference >> embree::cbvh::referenceTypeShift,
              "emptyReference must not have the type of a child");
#endif

#endif
