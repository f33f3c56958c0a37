// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Reading a scene: everything is behind addresses, nothing is bound. */

#ifndef CBVH_MEMORY_GLSL
#define CBVH_MEMORY_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require

#include "../scene_layout.h"

struct CbvhNode
{
  vec4 lower[3], upper[3];
  uvec4 children;
};

/* planes at a time are at it times their differences from here */
struct CbvhMovingNode
{
  CbvhNode atZero;
  vec4 lowerDifference[3], upperDifference[3];
  vec4 begin, end;   // times between which a child is there, the last not included
};

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhSceneAt { SceneData scene; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhNodes { CbvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhMovingNodes { CbvhMovingNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer CbvhPairs { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhGeometries { GeometryData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CbvhWords { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhQuadwords { uvec4 at[]; };

/* A block, and the ID of its geometry in the scene that has it: the block itself has a number that is the same in all scenes. */
struct CbvhPointer { uvec2 address; uint geomID; };

CbvhPointer cbvhPointer (SceneData scene, uint index)
{
  uvec4 block = CbvhQuadwords(scene.blocks).at[index];
  return CbvhPointer(block.xy, block.z);
}

uint cbvhWord (CbvhPointer block, uint i) { return CbvhWords(block.address).at[i]; }
uvec4 cbvhQuadword (CbvhPointer block, uint i) { return CbvhQuadwords(block.address).at[i]; }
float cbvhFloat (CbvhPointer block, uint i) { return uintBitsToFloat(cbvhWord(block, i)); }

uint cbvhByte (CbvhPointer block, uint offset) { return (cbvhWord(block, offset >> 2) >> (8u*(offset & 3u))) & 255u; }

/* 32 bits from any bit on, of which at least one is used. */
uint cbvhBits (CbvhPointer block, uint bit)
{
  uint i = bit >> 5, shift = bit & 31u;
  uint low = cbvhWord(block, i) >> shift;
  return shift == 0u ? low : low | (cbvhWord(block, i + 1u) << (32u - shift));
}

#endif
