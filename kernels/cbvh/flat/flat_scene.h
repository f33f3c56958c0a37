// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A committed scene as plain data: nodes in an array, blocks by their address, geometries. It is
 * what a traversal outside of this library needs to know of a scene (kernels/vulkan), so that
 * nobody else reads Embree's own structures. No Embree type is in it, and nothing is copied but
 * the top-level tree: blocks, vertices and indices stay where they are, and live as long as the
 * scene is neither committed again nor released. */

#include "../../../include/embree3/rtcore.h"
#include "../base/reference.h"
#include <cstddef>
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! of the structures below: a library of another number does not fit */
    static const uint32_t flatSceneVersion = 6;

    /*! Four children, bounds by axis. Those that are none have the reference emptyReference and bounds
     *  that nothing meets: all are infinite. */
    struct FlatNode
    {
      float lower[3][4], upper[3][4];
      uint32_t children[4];           //!< references, reference.h: to nodes, blocks and cells by index
    };

    /*! Four children that move. A plane at a time is that at 0 plus the time times its difference; it is conservative in float, fused or
     *  not. A child is there at times from begin on, before end. */
    struct FlatMovingNode
    {
      FlatNode atZero;
      float lowerDifference[3][4], upperDifference[3][4];
      float begin[4], end[4];
    };

    /*! a block, or a grid of GRID */
    struct FlatBlock
    {
      const void* data;  //!< aligned to 16 bytes
      uint32_t bytes;
      uint32_t type;     //!< reference.h: blockReference of the kind, movingBlockReference, meshBlockReference, or cellReference for a grid
      uint32_t geomID;   //!< in this scene; in the block is the number of its surface, which is the same in all
    };

    /*! 2 x 2 quads of a grid */
    struct FlatCell
    {
      uint32_t block;    //!< index of the grid in blocks
      uint32_t vertex;   //!< first vertex
    };

    enum FlatGeometryType { FLAT_NONE, FLAT_SURFACE, FLAT_TRIANGLES, FLAT_INSTANCE, FLAT_OTHER };

    struct FlatGeometry
    {
      FlatGeometryType type;     //!< FLAT_NONE: no geometry has this ID, or it is disabled
      const char* typeName;
      uint32_t mask;
      uint32_t timeSteps;
      bool isTraced;             //!< FlatScene has it: it stands still, is compressed, or is an instance that moves linearly
      bool hasFilter;
      uint64_t build;            //!< of a compressed surface: scenes that have the same number have the same blocks. 0 of others
      /* of triangles */
      const char* vertices;      //!< three floats each
      const char* indices;       //!< three 32-bit integers each
      size_t vertexStride, numVertices, indexStride, numTriangles;
      /* of an instance */
      float worldToLocal[12];    //!< column by column: x, y, z, translation; of one that moves not anything
      const float* localToWorld; //!< the same the other way round, of each time step, linear between them
      float begin, end;          //!< times of the first step and of the last, between which one that moves is there
      RTCScene instanced;
      float lower[3], upper[3];  //!< of the instanced scene at all times, in its own space
    };

    struct FlatTree
    {
      uint32_t root;             //!< reference, or emptyReference
      uint32_t depth;            //!< nodes on the longest way from the root to a leaf
      float lower[3], upper[3];  //!< at all times
    };

    struct FlatScene
    {
      uint32_t version;          //!< flatSceneVersion
      bool isRobust;             //!< RTC_SCENE_FLAG_ROBUST
      FlatTree still, moving;    //!< over the surfaces that do not move, and over those that do

      FlatNode* nodes;
      FlatMovingNode* movingNodes;
      FlatBlock* blocks;
      FlatCell* cells;
      FlatGeometry* geometries;  //!< by geomID
      size_t numNodes, numMovingNodes, numBlocks, numCells, numGeometries;
    };
  }
}

#if defined(__cplusplus)
extern "C" {
#endif

/* Describes a committed scene. NULL, with the error set at the scene's device, if it is not
 * committed, or if it has more than references can count. version: flatSceneVersion. Not for
 * applications: rtcore_vulkan.h is. */
RTC_API const struct embree::cbvh::FlatScene* rtcFlattenScene (RTCScene scene, unsigned int version);

/* Sets the error of a device, or of the calling thread where it is NULL, and calls the device's error function. */
RTC_API void rtcRaiseDeviceError (RTCDevice device, enum RTCError code, const char* message);

/* Takes NULL, too. */
RTC_API void rtcReleaseFlatScene (const struct embree::cbvh::FlatScene* flat);

#if defined(__cplusplus)
}
#endif
