// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A path starts at the eye and continues from each hit in a random direction, distributed as diffuse reflection. The
 * sun is too small to be found like this, so each hit also traces a shadow ray to a random point of it. */

#ifndef PATH_H
#define PATH_H

#include "lights.h"

PATH_BEGIN

struct PathView {
  vec3 eye;
  vec3 corner;      // from the eye to the picture's upper left corner, in a plane at distance 1
  vec3 right, down; // between pixels
  vec3 up;          // unit length
  vec3 sun;         // unit direction to the center
  uint32_t width, height;
  uint32_t bounces;               // hits of a path after the first
  float shutterBegin, shutterEnd; // in [0,1]
};

/* The shader's arguments. Addresses are two words there. */
struct PathArguments {
#ifdef VULKAN
  uvec2 scene, sums;
#else
  uint64_t scene, sums;
#endif
  PathView view;
  uint32_t sampleIndex;
  uint32_t firstRow;
};

#ifndef VULKAN
/* Devices have at least 128 bytes of push constants. The shader's struct ends with the last member; this one is
 * padded to a multiple of 8. */
static_assert(offsetof(PathArguments, firstRow) == 112 && sizeof(PathArguments) == 120, "layout of push constants");
#endif

struct ClosestHit {
  bool exists;
  float t;
  vec3 Ng;
};

/* Implemented per device. `direction` has unit length; `time` is in [0,1]. */
ClosestHit closestHit(TracedScene scene, vec3 origin, float tnear, vec3 direction, float time);
bool isOccluded(TracedScene scene, vec3 origin, float tnear, vec3 direction, float time);

/* tnear of rays that leave a hit: above its rounding error, as in Embree's path tracer. */
PATH_FUNCTION float tnearAfterHit(vec3 p, float t) {
  return 32.0f * 1.1920929e-7f * max(max(abs(p.x), abs(p.y)), max(abs(p.z), t));
}

/* Scales a vector so that its largest component is about 1. Vulkan divides accurately only by 2^-126 to 2^126. */
PATH_FUNCTION vec3 scaledToOne(vec3 v) {
  float largest = max(max(abs(v.x), abs(v.y)), abs(v.z)), factor = largest > 1.0f ? 0.25f : 4.0f;
  return (v * factor) * (1.0f / (largest * factor));
}

/* The unit normal on the ray's side; the reversed ray if there is no normal. The length of Ng is twice the area of a
 * triangle: its square overflows for models of 2e11 units and underflows below 4e-8. */
PATH_FUNCTION vec3 facingNormal(vec3 Ng, vec3 direction) {
  float square = dot(Ng, Ng);
  if (!(square >= 1e-31f && square <= 3.4e38f)) {
    Ng = scaledToOne(Ng);
    square = dot(Ng, Ng);
  }
  if (!(square > 0.0f && square <= 3.4e38f)) return vector(0.0f, 0.0f, 0.0f) - direction;
  return Ng * ((dot(Ng, direction) > 0.0f ? -1.0f : 1.0f) / sqrt(square));
}

/* Separate from the dimensions that lightOfPath counts. */
PATH_FUNCTION float timeOfPath(PathView view, uint32_t pixel, uint32_t sampleIndex) {
  return view.shutterBegin + (view.shutterEnd - view.shutterBegin) * randomNumber(pixel, sampleIndex, 0xFFFFFFFFu);
}

PATH_FUNCTION vec3 lightOfPath(TracedScene scene, PathView view, uint32_t x, uint32_t y, uint32_t sampleIndex) {
  uint32_t pixel = y * view.width + x, dimension = 0u;
  float pixelX = float(x) + randomNumber(pixel, sampleIndex, dimension++);
  float pixelY = float(y) + randomNumber(pixel, sampleIndex, dimension++);
  float time = timeOfPath(view, pixel, sampleIndex);
  vec3 origin = view.eye;
  vec3 direction = unitVector(view.corner + pixelX * view.right + pixelY * view.down);
  float tnear = 0.0f;
  vec3 light = vector(0.0f, 0.0f, 0.0f), weight = vector(1.0f, 1.0f, 1.0f);
  for (uint32_t hits = 0u;; hits++) {
    ClosestHit hit = closestHit(scene, origin, tnear, direction, time);
    if (!hit.exists) return light + weight * skyColor(direction, view.up);
    if (hits > view.bounces) return light;
    vec3 n = facingNormal(hit.Ng, direction);
    origin = origin + hit.t * direction;
    tnear = tnearAfterHit(origin, hit.t);
    weight = weight * albedo();

    float u = randomNumber(pixel, sampleIndex, dimension++), v = randomNumber(pixel, sampleIndex, dimension++);
    vec3 toSun = directionToSun(view.sun, u, v);
    float cosine = dot(n, toSun);
    if (cosine > 0.0f && !isOccluded(scene, origin, tnear, toSun, time)) light = light + cosine * (weight * sunColor());

    u = randomNumber(pixel, sampleIndex, dimension++);
    v = randomNumber(pixel, sampleIndex, dimension++);
    direction = rotatedFromZ(pointOfHemisphere(u, v), n);
  }
}

PATH_END

#endif
