// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Noise that is the same on every machine, without tables.
 *
 * Based on: Worley, "A Cellular Texture Basis Function", 1996; Perlin, "An Image Synthesizer", 1985 (gradient
 * noise). */

#include "basics/vec.h"

#include <algorithm>
#include <cstdint>

namespace programs {

inline uint32_t hashCell(int x, int y, int z, uint32_t seed) {
  uint32_t h = uint32_t(x) * 0x8da6b343u ^ uint32_t(y) * 0xd8163841u ^ uint32_t(z) * 0xcb1ab31fu ^ seed * 0x9e3779b9u;
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  h ^= h >> 16;
  return h;
}

inline float smoothstep(float a, float b, float x) {
  const float t = std::min(std::max((x - a) / (b - a), 0.0f), 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/* std::floor is a function call without SSE4.1. */
inline int floorToInt(float x) {
  const int i = int(x);
  return i - (float(i) > x);
}

/* About -1 to 1, with one feature per unit. */
inline float gradientNoise(Vec3f p, uint32_t seed) {
  const int ix = floorToInt(p.x), iy = floorToInt(p.y), iz = floorToInt(p.z);
  const float fx = float(ix), fy = float(iy), fz = float(iz);
  const Vec3f f{p.x - fx, p.y - fy, p.z - fz};
  auto fade = [](float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); };
  const float wx = fade(f.x), wy = fade(f.y), wz = fade(f.z);
  float corner[8];
  for (int i = 0; i < 8; i++) {
    const int dx = i & 1, dy = (i >> 1) & 1, dz = i >> 2;
    const uint32_t h = hashCell(ix + dx, iy + dy, iz + dz, seed);
    const Vec3f g{float(h & 1023) - 511.5f, float((h >> 10) & 1023) - 511.5f, float((h >> 20) & 1023) - 511.5f};
    corner[i] = dot(g, {f.x - float(dx), f.y - float(dy), f.z - float(dz)}) * (1.0f / 512.0f);
  }
  auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  return mix(mix(mix(corner[0], corner[1], wx), mix(corner[2], corner[3], wx), wy),
             mix(mix(corner[4], corner[5], wx), mix(corner[6], corner[7], wx), wy), wz);
}

/* Distances to the nearest two scattered points, one point per unit cell, and the hash of the nearest point's cell. */
struct CellNoise {
  float nearest, second;
  uint32_t id;
};

inline CellNoise cellNoise(Vec3f p, uint32_t seed) {
  const int ix = floorToInt(p.x), iy = floorToInt(p.y), iz = floorToInt(p.z);
  const float fx = float(ix), fy = float(iy), fz = float(iz);
  /* Lower bounds of squared distances along one axis to the points in cells -1, 0 and 1. */
  constexpr float margin = 0.1f; // between points and the walls of their cell, to make cells more equal
  auto axisDistances = [](float f, float out[3]) {
    const float below = f + margin, above = 1.0f + margin - f;
    const float inside = std::max(0.0f, std::max(margin - f, f - 1.0f + margin));
    out[0] = below * below;
    out[1] = inside * inside;
    out[2] = above * above;
  };
  float mx[3], my[3], mz[3];
  axisDistances(p.x - fx, mx);
  axisDistances(p.y - fy, my);
  axisDistances(p.z - fz, mz);

  float first = 9.0f, second = 9.0f;
  uint32_t id = 0;
  constexpr int order[3] = {0, -1, 1}; // the middle first, to skip most other cells
  for (int dz : order)
    for (int dy : order) {
      if (mz[dz + 1] + my[dy + 1] >= second) continue;
      for (int dx : order) {
        if (mz[dz + 1] + my[dy + 1] + mx[dx + 1] >= second) continue;
        const uint32_t h = hashCell(ix + dx, iy + dy, iz + dz, seed);
        constexpr float scale = (1.0f - 2.0f * margin) / 1024.0f;
        const Vec3f q{fx + float(dx) + margin + float(h & 1023) * scale,
                      fy + float(dy) + margin + float((h >> 10) & 1023) * scale,
                      fz + float(dz) + margin + float((h >> 20) & 1023) * scale};
        const float d = dot(q - p, q - p);
        if (d < first) {
          second = first;
          first = d;
          id = h;
        } else if (d < second) second = d;
      }
    }
  return {std::sqrt(first), std::sqrt(second), id};
}

} // namespace programs
