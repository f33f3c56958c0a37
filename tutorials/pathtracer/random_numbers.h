// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Random numbers that depend only on a pixel, a sample and a dimension, so that every device uses the same.
 *
 * Sines and cosines are polynomials, because a Vulkan device's may have an error of 2^-11. */

#ifndef PATH_RANDOM_NUMBERS_H
#define PATH_RANDOM_NUMBERS_H

#include "language.h"

PATH_BEGIN

/* Finalizer of MurmurHash3. */
PATH_FUNCTION uint32_t hashBits(uint32_t x) {
  x = (x ^ (x >> 16u)) * 0x85EBCA6Bu;
  x = (x ^ (x >> 13u)) * 0xC2B2AE35u;
  return x ^ (x >> 16u);
}

/* A multiple of 2^-24 in [0,1). `dimension` counts the numbers of a sample. */
PATH_FUNCTION float randomNumber(uint32_t pixel, uint32_t sampleIndex, uint32_t dimension) {
  uint32_t bits = hashBits(hashBits(hashBits(pixel + 1u) + sampleIndex) + dimension);
  return float(bits >> 8u) * 5.9604644775390625e-8f;
}

/* Maps the unit square to the upper unit hemisphere, cosine-distributed about z; preserves neighborhoods. Based on:
 * Shirley and Chiu, A Low Distortion Map Between Disk and Square, 1997. */
PATH_FUNCTION vec3 pointOfHemisphere(float u, float v) {
  float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
  bool isWide = abs(a) > abs(b);
  float radius = isWide ? a : b;
  float angle = radius == 0.0f ? 0.0f : 0.785398163f * (isWide ? b : a) / radius; // at most pi/4 from an axis
  float q = angle * angle;
  float sine = angle * (1.0f + q * (-1.0f / 6.0f + q * (1.0f / 120.0f - q * (1.0f / 5040.0f))));
  float cosine = 1.0f + q * (-0.5f + q * (1.0f / 24.0f + q * (-1.0f / 720.0f + q * (1.0f / 40320.0f))));
  float x = radius * (isWide ? cosine : sine), y = radius * (isWide ? sine : cosine);
  return vector(x, y, sqrt(max(0.0f, 1.0f - x * x - y * y)));
}

/* v must not be zero. */
PATH_FUNCTION vec3 unitVector(vec3 v) { return v * (1.0f / sqrt(dot(v, v))); }

/* Rotates p from a frame whose z axis is the unit vector n. Based on: Duff et al., Building an Orthonormal Basis,
 * Revisited, 2017. */
PATH_FUNCTION vec3 rotatedFromZ(vec3 p, vec3 n) {
  float s = n.z < 0.0f ? -1.0f : 1.0f;
  float a = -1.0f / (s + n.z), b = n.x * n.y * a;
  return p.x * vector(1.0f + s * n.x * n.x * a, s * b, -s * n.x) + p.y * vector(b, s + n.y * n.y * a, -n.y) + p.z * n;
}

PATH_END

#endif
