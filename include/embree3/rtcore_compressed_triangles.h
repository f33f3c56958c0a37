// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed surfaces out again: the triangles that rays hit, for renderers that offset rays from what they really hit, and for
 * bakes, exports and other renderers. Of geometry that is stored as cVERT or cGRID, whose triangles are what is stored. */

#include "rtcore.h"

RTC_NAMESPACE_BEGIN

/* A triangle as it is stored. The struct never grows. */
struct RTCCompressedTriangle
{
  float vertices[3][3]; /* x, y, z in the geometry's space */
  float u[3], v[3];     /* parameters of the vertices on the primitive: those of hits are interpolated between them */
};

/* Looks up the triangle that a hit is on.
 *
 * geometry: stored as cVERT or cGRID, in a scene that was committed, or by its own commit (RTC_COMPRESSION_FLAG_RELEASE_INPUT).
 * primID, u, v, Ng: of the hit. Ng is 3 floats and chooses between triangles on whose common edge (u,v) lies; NULL takes any of them.
 * triangle: written if there is one; not NULL. Its vertices are in the order of the patch: quad (x,y) has the triangles
 *           (x,y), (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). Of quad meshes and triangle meshes they are in the order of the
 *           primitive: v0, v1, v3 or v2, v3, v1 of a quad.
 *
 * Returns whether (u,v) is on a triangle of the primitive: false for an unknown primID, and where triangles were left out. The first
 * call after a commit makes an index of the geometry's blocks, of 16 bytes each, and
 * of quad meshes and triangle meshes of 4 bytes for each primitive.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL; RTC_ERROR_INVALID_OPERATION for a geometry that was not compressed, or is stored as
 * anything else, if in part: cLEAF and cVOXEL have no triangles. Thread safety: as rtcInterpolate. */
RTC_API bool rtcGetCompressedTriangle(RTCGeometry geometry, unsigned int primID, float u, float v, const float* Ng, struct RTCCompressedTriangle* triangle);

/* The same of geometry with motion blur, at a time, which rays have; without AtTime it is that of the geometry's first time step. Returns
 * false outside of the geometry's time range. Of geometry that does not move the time does not matter. Vertices are the same floats that rays
 * meet at that time. */
RTC_API bool rtcGetCompressedTriangleAtTime(RTCGeometry geometry, float time, unsigned int primID, float u, float v, const float* Ng, struct RTCCompressedTriangle* triangle);

/* Up to 16 x 16 quads, of cGRID up to 256 x 256. Neighbouring parts have the vertices that they share as the same floats; of
 * cGRID those of one face have. Later versions may append members. */
struct RTCCompressedPart
{
  unsigned int primID;        /* that all quads are of, where primitivesPerQuad is 0 */
  unsigned int width, height; /* in vertices */
  const float* vertices;      /* x, y, z of width*height of them, row by row. Triangles with one that is not a number are left out */
  const float* parameters;    /* u, v of each; NULL where primitivesPerQuad is not 0 */
  const unsigned int* primIDs; /* row by row, primitivesPerQuad of each quad */
  unsigned int primitivesPerQuad; /* 0 of cages and grids, 1 of quad meshes, 2 of triangle meshes: that of the quad's first triangle, as above,
                                   * and that of its second, or the first again where there is no second one */
};

/* Is handed a part; valid until it returns. False ends the calls. */
typedef bool (*RTCCompressedPartFunction)(void* userPtr, const struct RTCCompressedPart* part);

/* Hands out all of a surface as it is stored, part by part, by the calling thread, in an order that is not specified.
 *
 * geometry: as above.
 * function: not NULL.
 *
 * Errors: as above. Thread safety: as rtcInterpolate. */
RTC_API void rtcForEachCompressedPart(RTCGeometry geometry, RTCCompressedPartFunction function, void* userPtr);

/* The same at a time, as above: no part outside of the geometry's time range. */
RTC_API void rtcForEachCompressedPartAtTime(RTCGeometry geometry, float time, RTCCompressedPartFunction function, void* userPtr);

RTC_NAMESPACE_END
