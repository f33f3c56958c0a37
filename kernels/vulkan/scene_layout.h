// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Layout of a scene in device memory, shared by C++ and GLSL: host/scene.cpp writes it, shaders read it. SceneData
 * refers to everything else. Compressed blocks are the same bytes as on the CPU. */

#ifndef CBVH_VULKAN_SCENE_LAYOUT_H
#define CBVH_VULKAN_SCENE_LAYOUT_H

#include "../cbvh/base/reference.h"

#ifdef VULKAN
#define CBVH_ADDRESS uvec2
#else
#define CBVH_ADDRESS uint64_t
#endif

CBVH_BEGIN

/*! Bytes of a node: per child a lower and an upper plane per axis, and a reference. */
CVERT_CONSTANT uint32_t nodeBytes = 112u;

/*! Bytes of a moving node, which also has the planes' motion and each child's time interval. */
CVERT_CONSTANT uint32_t movingNodeBytes = 240u;

/*! A scene. Addresses are device addresses of arrays. References are defined in base/reference.h. */
struct SceneData {
  CBVH_ADDRESS nodes;
  CBVH_ADDRESS movingNodes;
  CBVH_ADDRESS blocks;      //!< address of BlockData
  CBVH_ADDRESS leaves;      //!< in full precision, pairs of words: index in `blocks` and first vertex (up to
                            //!< 2 x 2 quads of GRID), or geomID and primID (a triangle)
  CBVH_ADDRESS geometries;  //!< address of GeometryData
  uint32_t root;            //!< reference to the root of the tree
  float lower[3], upper[3]; //!< bounds of the scene
  uint32_t padding[3];
  /* Only for scenes that are traced by ray queries. */
  CBVH_ADDRESS topLevel; //!< acceleration structure
  CBVH_ADDRESS placed;   //!< PlacedBoxes, indexed by an instance's custom index in topLevel
};

/*! A leaf for ray queries: a box of a bottom-level acceleration structure, indexed by its primitive index. */
struct LeafBox {
  float lower[3], upper[3];
  uint32_t reference; //!< reference to the leaf, in the whole scene's arrays
  uint32_t padding;
};
CVERT_CONSTANT uint32_t leafBoxBytes = 32u;

/*! Boxes of an instance in the top-level acceleration structure. */
struct PlacedBoxes {
  CBVH_ADDRESS boxes;     //!< address of LeafBox
  uint32_t instID;        //!< Embree's instance; all bits set for the scene itself
  uint32_t firstGeometry; //!< see GeometryData
};
CVERT_CONSTANT uint32_t placedBoxesBytes = 16u;

/*! A compressed block, or a grid of GRID. */
struct BlockData {
  CBVH_ADDRESS address; //!< aligned to blockAlignment
  uint32_t geomID;      //!< in the geometry's scene
  uint32_t padding;
};

/*! A triangle mesh or an instance. For other geometries only `mask` and `isRobust` are set. */
struct GeometryData {
  CBVH_ADDRESS vertices, indices;
  uint32_t vertexStride, indexStride; //!< in words
  uint32_t mask;
  uint32_t isRobust;      //!< test triangles as in Embree's robust scenes
  float worldToLocal[12]; //!< 3x4, column by column; undefined if moving
  uint32_t root;          //!< root of the instanced scene
  uint32_t firstGeometry; //!< index in `geometries` of the instanced scene's geometry 0
  /* Motion of an instance, linear between the steps. */
  uint32_t numSteps; //!< 1 if static
  float begin, end;  //!< times of the first and last step
  uint32_t padding;
  CBVH_ADDRESS transforms; //!< local to world, 3x4 matrices of 12 floats per step
};
CVERT_CONSTANT uint32_t geometryBytes = 112u;

CBVH_END

#ifndef VULKAN
static_assert(sizeof(embree::cbvh::SceneData) == 96, "layout of a scene");
static_assert(sizeof(embree::cbvh::LeafBox) == embree::cbvh::leafBoxBytes, "layout of a leaf's box");
static_assert(sizeof(embree::cbvh::PlacedBoxes) == embree::cbvh::placedBoxesBytes, "layout of placed boxes");
static_assert(sizeof(embree::cbvh::BlockData) == 16, "layout of a block's data");
static_assert(sizeof(embree::cbvh::GeometryData) == embree::cbvh::geometryBytes, "layout of a geometry");
#endif

#endif
