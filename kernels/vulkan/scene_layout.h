// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A scene in the memory of a Vulkan device, as C++ writes and GLSL reads it. Everything is found
 * from the address of a SceneData. Blocks lie in memory byte for byte as kernels/cbvh builds them. */

#ifndef CBVH_SCENE_LAYOUT_H
#define CBVH_SCENE_LAYOUT_H

#include "../cbvh/base/reference.h"

#ifdef VULKAN
#define CBVH_ADDRESS uvec2
#else
#define CBVH_ADDRESS uint64_t
#endif

CBVH_BEGIN

/*! bytes of a node: four lower and four upper planes an axis, four references */
CVERT_CONSTANT uint32_t nodeBytes = 112u;

/*! of one whose children move: besides the differences of planes over time, and when children are there */
CVERT_CONSTANT uint32_t movingNodeBytes = 240u;

struct SceneData
{
  CBVH_ADDRESS nodes;
  CBVH_ADDRESS movingNodes;
  CBVH_ADDRESS blocks;       //!< BlockData
  CBVH_ADDRESS cells;        //!< two words each: of GRID the index of a grid in blocks and a vertex, of triangles geomID and primID
  CBVH_ADDRESS geometries;   //!< GeometryData
  uint32_t root;             //!< reference
  float lower[3], upper[3];  //!< bounds of all that is traced
  uint32_t padding[3];
  /* of a scene for ray queries */
  CBVH_ADDRESS topLevel;     //!< the driver's structure
  CBVH_ADDRESS placed;       //!< PlacedBoxes, by the custom index of the structure's instances
};

/*! A leaf of the tree as a ray query finds it, by the number of its box. */
struct LeafBox
{
  float lower[3], upper[3];
  uint32_t reference;        //!< reference.h; of the scene, not of a part
  uint32_t padding;
};
CVERT_CONSTANT uint32_t leafBoxBytes = 32u;

/*! Boxes in one place of the driver's top level. */
struct PlacedBoxes
{
  CBVH_ADDRESS boxes;        //!< LeafBox
  uint32_t instID;           //!< the instance that places them, or all bits: then they are the scene's own
  uint32_t firstGeometry;    //!< as GeometryData has it
};
CVERT_CONSTANT uint32_t placedBoxesBytes = 16u;

/*! of a block, or of a grid of GRID */
struct BlockData
{
  CBVH_ADDRESS address;      //!< aligned to blockAlignment
  uint32_t geomID;           //!< in the scene that has it
  uint32_t padding;
};

/*! of a triangle mesh or an instance; of subdivision surfaces only the mask */
struct GeometryData
{
  CBVH_ADDRESS vertices, indices;
  uint32_t vertexStride, indexStride;  //!< words
  uint32_t mask;
  uint32_t isRobust;         //!< the test of triangles is Embree's robust one
  /* of an instance */
  float worldToLocal[12];    //!< column by column
  uint32_t root;             //!< of the instanced scene
  uint32_t firstGeometry;    //!< the instanced scene's geometry 0
  /* of one that moves: at its time steps, linear between them */
  uint32_t numSteps;         //!< 1 of one that does not
  float begin, end;          //!< times of the first step and of the last
  uint32_t padding;
  CBVH_ADDRESS transforms;   //!< 12 floats each, as worldToLocal, but to the world
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
