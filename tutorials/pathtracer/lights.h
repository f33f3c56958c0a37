// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What a scene is lit by, a sun and a sky, and the colour of its surfaces. */

#ifndef PATH_LIGHTS_H
#define PATH_LIGHTS_H

#include "random_numbers.h"

PATH_BEGIN

PATH_FUNCTION vec3 albedo () { return vector(0.58f,0.47f,0.34f); }

/* What a white surface that faces the sun reflects of it: its irradiance over pi. The sun is behind whoever looks,
 * and is no part of what is seen of the sky. */
PATH_FUNCTION vec3 sunColor () { return vector(1.25f,1.14f,0.95f); }

/* Tangent of half the angle at which the sun is seen: four times the real one's, for shadows that show it. */
PATH_CONSTANT float sunRadius = 0.0186f;

/* Towards a point of the sun. sun: its middle, of length 1. u, v: random numbers. */
PATH_FUNCTION vec3 directionToSun (vec3 sun, float u, float v)
{
  vec3 p = pointOfHemisphere(u,v);
  return unitVector(turned(vector(sunRadius*p.x,sunRadius*p.y,1.0f),sun));
}

/* Bluer the higher. */
PATH_FUNCTION vec3 skyColor (vec3 direction, vec3 up)
{
  float height = 0.5f + 0.5f*dot(direction,up);
  return (1.0f - height)*vector(0.42f,0.41f,0.41f) + height*vector(0.24f,0.38f,0.62f);
}

PATH_END

#endif
