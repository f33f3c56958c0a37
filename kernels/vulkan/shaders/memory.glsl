// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Reads a scene (scene_layout.h) by buffer addresses. */

#ifndef CBVH_MEMORY_GLSL
#define CBVH_MEMORY_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "../../cvert/portable/bytes.h"
#include "../scene_layout.h"

/* Four children, one per component. */
struct CbvhNode {
  vec4 lower[3], upper[3];
  uvec4 children;
};

/* A plane at time t is atZero + t*difference. */
struct CbvhMovingNode {
  CbvhNode atZero;
  vec4 lowerDifference[3], upperDifference[3];
  vec4 begin, end; // a child exists if begin <= t < end
};

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhSceneAt { SceneData scene; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhNodes { CbvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhMovingNodes { CbvhMovingNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer CbvhPairs { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhGeometries { GeometryData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhQuadwords { uvec4 at[]; };

/* See BlockData. */
struct CbvhPointer {
  uvec2 address;
  uint geomID;
};

CbvhPointer cbvhPointer(SceneData scene, uint index) {
  uvec4 block = CbvhQuadwords(scene.blocks).at[index];
  return CbvhPointer(block.xy, block.z);
}

uint cbvhWord(CbvhPointer block, uint i) { return wordAt(block.address, i); }
uvec4 cbvhQuadword(CbvhPointer block, uint i) { return CbvhQuadwords(block.address).at[i]; }
float cbvhFloat(CbvhPointer block, uint i) { return floatAt(block.address, i); }

#endif
