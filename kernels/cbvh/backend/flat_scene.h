// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A committed scene as plain data without Embree's internal types, for back ends (kernels/vulkan). Nodes are copied.
 * Blocks, vertices and indices are not: they are valid until the scene is committed again or released, blocks of mesh
 * tiles until the flat scene is released. Vertices and indices become invalid earlier if the application sets or frees
 * their buffers. */

#include "../../../include/embree3/rtcore.h"
#include "../base/reference.h"
#include <cstddef>
#include <cstdint>

namespace embree::cbvh {
/*! Increment it when a struct below changes: libembree3 and libembree3_vulkan must have the same version. */
static const uint32_t flatSceneVersion = 9;

/*! Unused children are emptyReference, with all bounds +infinity. */
struct FlatNode {
  float lower[3][4], upper[3][4];
  uint32_t children[4]; //!< references (base/reference.h) to nodes, blocks or leaves of grids
};

/*! A plane at ray time t is atZero + t * difference: conservative in float, fused or not. A child exists if
 *  begin <= t < end, which holds for all times unless the node splits time. */
struct FlatMovingNode {
  FlatNode atZero;
  float lowerDifference[3][4], upperDifference[3][4];
  float begin[4], end[4];
};

/*! A compressed block, a tile, or a grid of GRID. */
struct FlatBlock {
  const void* data;   //!< aligned to 16 bytes
  const void* source; //!< identifies the block in its surface: data, or the tile that it was made from
  uint32_t bytes;
  /*! Type of references to the block (base/reference.h); gridLeafReferenceType for a grid. */
  uint32_t type;
  uint32_t geomID; //!< in this scene; blocks store the surface number
};

/*! Leaf of a grid of GRID: up to 2 x 2 quads. */
struct FlatGridLeaf {
  uint32_t block;  //!< index of the grid in blocks
  uint32_t vertex; //!< vertex of the grid at the corner with the lowest u and v
};

enum FlatGeometryType { FLAT_NONE, FLAT_SURFACE, FLAT_TRIANGLES, FLAT_INSTANCE, FLAT_OTHER };

struct FlatGeometry {
  FlatGeometryType type; //!< FLAT_NONE: unused or disabled ID; the other members are 0
  const char* typeName;  //!< follows "is" in messages, for example "a triangle mesh"
  uint32_t mask;
  uint32_t numTimeSteps;
  bool isMotionSupported; //!< static, compressed, or an instance without quaternions
  bool hasFilter;
  uint64_t buildID; //!< SurfaceBlocks::buildID, which identifies blocks that scenes share, or 0
  /* for FLAT_TRIANGLES: buffers of the geometry at the first time step; strides in bytes */
  const char* vertices; //!< three floats each
  const char* indices;  //!< three 32-bit integers each
  size_t vertexStride, numVertices, indexStride, numTriangles;
  /* for FLAT_INSTANCE */
  float worldToLocal[12];    //!< columns x, y, z, translation; undefined for moving instances
  const float* localToWorld; //!< one such transform per time step, linear between steps
  float begin, end;          //!< times of the first and last step; a moving instance exists only between them
  RTCScene instanced;        //!< not retained; NULL if the instance has no scene
  float lower[3], upper[3];  //!< of the instanced scene at all times, in its own space
};

struct FlatTree {
  uint32_t root;            //!< reference, or emptyReference for an empty tree
  uint32_t depth;           //!< nodes on the longest path to a leaf
  float lower[3], upper[3]; //!< bounds at all times
};

struct FlatScene {
  uint32_t version;
  bool isRobust;     //!< the scene has RTC_SCENE_FLAG_ROBUST
  bool hasOwnBlocks; //!< blocks that were made from tiles
  FlatTree staticTree, movingTree;

  FlatNode* nodes;
  FlatMovingNode* movingNodes;
  FlatBlock* blocks;
  FlatGridLeaf* gridLeaves;
  FlatGeometry* geometries; //!< by geomID
  size_t numNodes, numMovingNodes, numBlocks, numGridLeaves, numGeometries;
};
} // namespace embree::cbvh

extern "C" {

/* Flattens a committed scene. The caller must release the result with rtcReleaseFlatScene. If isMotionSupported is
 * false for an enabled geometry, the trees are empty, and the caller should report that geometry. version:
 * flatSceneVersion of the caller.
 *
 * Returns NULL and reports an error if the scene is NULL or not committed, if the version differs, if the scene has a
 * damaged block of a file or a moving mesh block, or if it has more nodes, blocks or leaves than references support. */
RTC_API const struct embree::cbvh::FlatScene* rtcFlattenScene(RTCScene scene, unsigned int version);

/* Sets the error of a device, or of the calling thread if device is NULL, and calls the device's error function. */
RTC_API void rtcRaiseDeviceError(RTCDevice device, enum RTCError code, const char* message);

/* flat: may be NULL */
RTC_API void rtcReleaseFlatScene(const struct embree::cbvh::FlatScene* flat);
}
