// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A sun and a sky, and the color of surfaces. */

#ifndef PATH_LIGHTS_H
#define PATH_LIGHTS_H

#include "random_numbers.h"

PATH_BEGIN

PATH_FUNCTION vec3 albedo() { return vector(0.58f, 0.47f, 0.34f); }

/* Irradiance divided by pi. The sun is behind the viewer and is not visible in the sky. */
PATH_FUNCTION vec3 sunColor() { return vector(1.25f, 1.14f, 0.95f); }

/* Tangent of half the sun's angular diameter: four times the real one, for visible penumbras. */
PATH_CONSTANT float sunRadius = 0.0186f;

/* `sun` is the unit direction to the center; u and v are random. */
PATH_FUNCTION vec3 directionToSun(vec3 sun, float u, float v) {
  vec3 p = pointOfHemisphere(u, v);
  return unitVector(rotatedFromZ(vector(sunRadius * p.x, sunRadius * p.y, 1.0f), sun));
}

PATH_FUNCTION vec3 skyColor(vec3 direction, vec3 up) {
  float height = 0.5f + 0.5f * dot(direction, up);
  return (1.0f - height) * vector(0.42f, 0.41f, 0.41f) + height * vector(0.24f, 0.38f, 0.62f);
}

PATH_END

#endif
