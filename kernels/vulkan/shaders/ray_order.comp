// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Sorts ray indices by origin and direction, so that neighboring threads visit the same blocks: a stable radix sort
 * with digits of 4 bits.
 *
 *   STAGE 0: writes pairs (key, index of a ray)
 *   STAGE 1: counts the digits in each tile, the pairs of a workgroup
 *   STAGE 2: replaces the counts by their prefix sums, in one workgroup
 *   STAGE 3: moves the pairs to their places
 *
 * Stages 1 to 3 are repeated for each digit, from the lowest on. host/ray_order.cpp records the stages.
 */

#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require

#include "../ray_order.h"
#include "../scene_layout.h"

layout(local_size_x = 256) in; // orderThreads

layout(push_constant, scalar) uniform Arguments {
  uvec2 rays;     // used by STAGE 0 only
  uvec2 from, to; // addresses of Pairs
  uvec2 counts;   // address of an array of words, [digit][tile]
  uvec2 scene;
  uint count, rayWords, shift; // count: rays; STAGE 2: tiles
}
arguments;

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Pairs { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Floats { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer SceneAt { SceneData scene; };

/* --- keys ------------------------------------------------------------------------------ */

/* Moves bit i to bit 3i, for the lower 10 bits. */
uint spreadThree(uint x) {
  x = (x | (x << 16)) & 0x030000FFu;
  x = (x | (x << 8)) & 0x0300F00Fu;
  x = (x | (x << 4)) & 0x030C30C3u;
  return (x | (x << 2)) & 0x09249249u;
}

/* Key of 30 bits, from the highest on: 6 bits of each coordinate of the origin in Morton order, 3 bits for the octant
 * of the direction, and 3 more bits of each coordinate. lower, upper: bounds of the scene. */
uint keyOfRay(vec3 origin, vec3 direction, vec3 lower, vec3 upper) {
  uvec3 cell = uvec3(clamp((origin - lower) / max(upper - lower, vec3(1e-30)), 0.0, 1.0) * 511.0);
  uint place = spreadThree(cell.x) | (spreadThree(cell.y) << 1) | (spreadThree(cell.z) << 2);
  uint octant = (direction.x < 0.0 ? 1u : 0u) | (direction.y < 0.0 ? 2u : 0u) | (direction.z < 0.0 ? 4u : 0u);
  return ((place >> 9) << 12) | (octant << 9) | (place & 511u);
}

void makeKeys() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= arguments.count) return;
  Floats ray = Floats(arguments.rays);
  uint first = i * arguments.rayWords;
  SceneData scene = SceneAt(arguments.scene).scene;
  vec3 origin = vec3(ray.at[first], ray.at[first + 1u], ray.at[first + 2u]),
       direction = vec3(ray.at[first + 4u], ray.at[first + 5u], ray.at[first + 6u]);
  vec3 lower = vec3(scene.lower[0], scene.lower[1], scene.lower[2]),
       upper = vec3(scene.upper[0], scene.upper[1], scene.upper[2]);
  Pairs(arguments.to).at[i] = uvec2(keyOfRay(origin, direction, lower, upper), i);
}

/* --- digits ---------------------------------------------------------------------------- */

/* [digit][thread]: counts, then exclusive prefix sums over the threads */
shared uint sums[orderRadix * orderThreads];

uint digitOf(uint key) { return (key >> arguments.shift) & (orderRadix - 1u); }

void countTile() {
  uint thread = gl_LocalInvocationID.x, first = gl_WorkGroupID.x * orderTileSize + thread * orderKeysPerThread;
  for (uint digit = 0u; digit < orderRadix; digit++) sums[digit * orderThreads + thread] = 0u;
  for (uint k = 0u; k < orderKeysPerThread; k++)
    if (first + k < arguments.count) sums[digitOf(Pairs(arguments.from).at[first + k].x) * orderThreads + thread]++;
  barrier();
}

/* Replaces the counts in `sums` by prefix sums. In the first orderRadix threads, returns the tile's count of digit
 * gl_LocalInvocationID.x. */
uint sumThreads() {
  uint thread = gl_LocalInvocationID.x, sum = 0u;
  if (thread < orderRadix)
    for (uint k = 0u; k < orderThreads; k++) {
      uint n = sums[thread * orderThreads + k];
      sums[thread * orderThreads + k] = sum;
      sum += n;
    }
  barrier();
  return sum;
}

void countDigits() {
  countTile();
  uint all = sumThreads();
  if (gl_LocalInvocationID.x < orderRadix)
    Words(arguments.counts).at[gl_LocalInvocationID.x * gl_NumWorkGroups.x + gl_WorkGroupID.x] = all;
}

/* Sum of each thread's range of counts. */
shared uint partial[orderThreads];
void sumDigits() {
  uint n = orderRadix * arguments.count, each = (n + orderThreads - 1u) / orderThreads;
  uint thread = gl_LocalInvocationID.x, begin = min(thread * each, n), end = min(begin + each, n), sum = 0u;
  for (uint i = begin; i < end; i++) sum += Words(arguments.counts).at[i];
  partial[thread] = sum;
  barrier();
  uint before = 0u;
  for (uint k = 0u; k < thread; k++) before += partial[k];
  for (uint i = begin; i < end; i++) {
    uint own = Words(arguments.counts).at[i];
    Words(arguments.counts).at[i] = before;
    before += own;
  }
}

void scatter() {
  countTile();
  sumThreads();
  uint thread = gl_LocalInvocationID.x, first = gl_WorkGroupID.x * orderTileSize + thread * orderKeysPerThread;
  for (uint k = 0u; k < orderKeysPerThread; k++)
    if (first + k < arguments.count) {
      uvec2 pair = Pairs(arguments.from).at[first + k];
      uint digit = digitOf(pair.x);
      uint place = Words(arguments.counts).at[digit * gl_NumWorkGroups.x + gl_WorkGroupID.x] +
                   sums[digit * orderThreads + thread]++;
      Pairs(arguments.to).at[place] = pair;
    }
}

void main() {
#if STAGE == 0
  makeKeys();
#elif STAGE == 1
  countDigits();
#elif STAGE == 2
  sumDigits();
#else
  scatter();
#endif
}
