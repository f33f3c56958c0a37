// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tessellation of subdivision surfaces by their size in a picture: the rate of each edge depends on how large the
 * camera sees the surface along it. */

#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

/* A camera, and the size of quads in its picture. Call rtcInitDicingArguments first. */
struct RTCDicingArguments {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCDicingArguments); /* see rtcore_compression.h */

  /* The camera, in world space. For an orthographic camera, only pixelSize and the region of the picture matter. */
  float position[3] RTC_ZERO;
  float direction[3] RTC_DEFAULT({0, 0, 1}); /* towards the center of the picture, of any length */
  float up[3] RTC_DEFAULT({0, 1, 0});        /* up direction of the picture, of any length, not parallel to direction */
  bool orthographic RTC_ZERO;
  float pixelSize RTC_ZERO;              /* width of a pixel at distance 1; for an orthographic camera at any
                                          * distance. Positive */
  float width RTC_ZERO, height RTC_ZERO; /* of the picture in pixels. 0: everything counts as inside of the picture,
                                          * and direction and up are ignored */

  const float* transform RTC_ZERO; /* from the geometry's space to world space: 12 floats in the layout
                                    * RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR. NULL: the identity */

  float quadSize RTC_DEFAULT(1.0f);      /* target length of the edges of quads in pixels. Default 1, positive */
  float outsideFactor RTC_DEFAULT(8.0f); /* factor of quadSize far outside of the picture and behind the camera.
                                          * Default 8, at least 1 */
  float maxRate RTC_DEFAULT(4096.0f);    /* largest number of quads along an edge. Default 4096, 1 to 4096 */
  const float* maxRates RTC_ZERO;        /* further bound for each edge, for example the number of texels along it:
                                          * one entry per index, at least 1. An edge of two faces gets the higher of
                                          * their rates. NULL: only maxRate holds */
};

/* Sets the camera to the origin without a picture, pixelSize to 0, which is invalid, and all other members to their
 * defaults.
 *
 * args: written, not NULL. */
RTC_FORCEINLINE void rtcInitDicingArguments(struct RTCDicingArguments* args) {
  args->structSize = sizeof(*args);
  for (int i = 0; i < 3; i++) args->position[i] = args->direction[i] = args->up[i] = 0.0f;
  args->direction[2] = args->up[1] = 1.0f;
  args->orthographic = false;
  args->pixelSize = args->width = args->height = 0.0f;
  args->transform = NULL;
  args->quadSize = 1.0f;
  args->outsideFactor = 8.0f;
  args->maxRate = 4096.0f;
  args->maxRates = NULL;
}

/* Sets the level buffer (RTC_BUFFER_TYPE_LEVEL) of a subdivision geometry so that its quads have about the requested
 * size in the picture. Commit the geometry afterwards. The function replaces an existing level buffer and does not
 * write to the old one. rtcGetGeometryBufferData returns the new buffer, with one float per index.
 *
 * The function measures edges on the displaced limit surface. For this it calls the displacement function of the
 * geometry for points of all faces, about 1/16 as many points as there will be quads. It measures lengths as if the
 * camera looked at them from the front: silhouettes, shadows and reflections get quads as fine as those of visible
 * surfaces. The rate of an edge is the power of two that is nearest to the measured rate, so quads are between 0.7 and
 * 1.4 times as long as requested. Both faces at an edge get the higher of their two rates.
 *
 * geometry: of type RTC_GEOMETRY_TYPE_SUBDIVISION, committed since the last change of its buffers. If it has several
 *           time steps, the step that requires the highest rates counts.
 * args:     read during the call, not NULL.
 *
 * Ignores vertices that are not finite, and holes.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, for a wrong structSize, for members that are not finite or outside of
 * the ranges above, and for faces with an index past the vertices; the message names the member or the face.
 * RTC_ERROR_INVALID_OPERATION for geometry of another type, for a geometry that is not committed, for a geometry that
 * released its input or was loaded from a file, and if a time step has fewer vertices than the first one. After an
 * error the geometry keeps its levels. Thread safety: as rtcSetGeometryTessellationRate. Several threads call the
 * displacement function. */
RTC_API void rtcDiceGeometry(RTCGeometry geometry, const struct RTCDicingArguments* args);

RTC_NAMESPACE_END
