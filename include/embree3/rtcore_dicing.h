// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Subdivision surfaces as fine as a picture of them needs: the rate of each edge by how large the camera sees what lies along it. */

#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

/* A camera, and how large quads may be in its picture. Fill with rtcInitDicingArguments first. */
struct RTCDicingArguments
{
  size_t structSize RTC_SIZE_OF(RTCDicingArguments); /* see rtcore_compression.h */

  /* World space. Of an orthographic camera only pixelSize and what lies in the picture matter. */
  float position[3];
  float direction[3];      /* into the middle of the picture, of any length */
  float up[3];             /* of the picture, of any length, not along direction */
  bool orthographic;
  float pixelSize;         /* width of a pixel at distance 1; of an orthographic camera anywhere. More than 0 */
  float width, height;     /* of the picture in pixels. 0: all that is around counts as in it, and direction and up do not matter */

  const float* transform;  /* geometry to world, 12 floats, column by column as RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR; NULL: world space */

  float quadSize;          /* length of quads' edges in pixels, about: 1. More than 0 */
  float outside;           /* so many times as large far outside of the picture, and behind the camera: 8. At least 1 */
  float maxRate;           /* quads along an edge, at most: 4096. 1 to 4096 */
  const float* maxRates;   /* of each edge, likewise, for example the texels along it; as many as indices. NULL: maxRate alone */
};

/* Sets a camera at the origin without a picture, pixelSize to 0, which has to be set, and all else to what stands above. */
RTC_FORCEINLINE void rtcInitDicingArguments(struct RTCDicingArguments* args)
{
  args->structSize = sizeof(*args);
  for (int i = 0; i < 3; i++)
    args->position[i] = args->direction[i] = args->up[i] = 0.0f;
  args->direction[2] = args->up[1] = 1.0f;
  args->orthographic = false;
  args->pixelSize = args->width = args->height = 0.0f;
  args->transform = NULL;
  args->quadSize = 1.0f;
  args->outside = 8.0f;
  args->maxRate = 4096.0f;
  args->maxRates = NULL;
}

/* Sets the level buffer of a subdivision geometry, RTC_BUFFER_TYPE_LEVEL, so that its quads are about as large in a picture as is asked for. Commit the
 * geometry afterwards. A buffer that was there is not written but replaced; rtcGetGeometryBufferData returns the new one, a float an index.
 *
 * Edges are measured where they lie: on the limit surface, moved by the geometry's displacement function, which is called for points of
 * all faces, some 1/16 as many as quads. Lengths count as if they were seen from the front, so that silhouettes,
 * shadows and reflections have quads as fine as what is seen. The rate of an edge is a power of two, that is the nearest to what was measured: quads are
 * between 0.7 and 1.4 times as long as asked for. Both faces at an edge get the same rate: the higher one of what they need.
 *
 * geometry: of type RTC_GEOMETRY_TYPE_SUBDIVISION, committed since its buffers were last changed. Of several time steps the one that needs most counts.
 * args: read during the call, not NULL.
 *
 * Vertices that are not finite count as if they were not there; holes need nothing.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, for a wrong structSize, and for numbers that are not finite or out of
 * the ranges above, with their names; RTC_ERROR_INVALID_OPERATION for other geometry and for a geometry that is not
 * committed. The geometry keeps its levels then. Thread safety: as rtcSetGeometryTessellationRate. Displacement
 * functions are called by several threads. */
RTC_API void rtcDiceGeometry(RTCGeometry geometry, const struct RTCDicingArguments* args);

RTC_NAMESPACE_END
