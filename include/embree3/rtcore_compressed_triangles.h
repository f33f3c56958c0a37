// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to the triangles of compressed geometry. Renderers use it to offset rays from the triangle that a ray hit;
 * bakers, exporters and other renderers use it to read whole surfaces. Only cVERT and cGRID store triangles. */

#include "rtcore.h"

RTC_NAMESPACE_BEGIN

/* A stored triangle. The struct never grows. */
struct RTCCompressedTriangle {
  float vertices[3][3]; /* x, y, z in the geometry's space */
  float u[3], v[3];     /* parameters of the vertices on the primitive; u and v of hits are interpolated from them */
};

/* Finds the triangle of a hit.
 *
 * geometry: stored as cVERT or cGRID. It was committed with its scene, or with RTC_COMPRESSION_FLAG_RELEASE_INPUT by
 *           its own commit.
 * time:     of the ray. Ignored for geometry that does not move.
 * primID, u, v: of the hit.
 * Ng:       of the hit, 3 floats, in the geometry's space. It selects between triangles if (u,v) lies on their common
 *           edge. NULL selects any.
 * triangle: written if a triangle is found, not NULL. Quad (x,y) of a subdivision surface or grid has the triangles
 *           (x,y), (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). Triangles of meshes have the vertex order of the
 *           primitive: a quad has the triangles v0, v1, v3 and v2, v3, v1.
 *
 * Returns true if (u,v) is on a triangle of the primitive. Returns false for an unknown primID, where triangles
 * were left out, and outside of the time range of the geometry. The first call after a commit builds an index with 16
 * bytes per block; for quad and triangle meshes it has 4 more bytes per primitive.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. RTC_ERROR_INVALID_OPERATION if the geometry is not compressed, if any
 * part of it is stored as cLEAF or cVOXEL, which have no triangles, or is left to GRID, and if the file that it was
 * loaded from has a damaged block. Thread safety: as rtcInterpolate. */
RTC_API bool rtcFindCompressedTriangle(RTCGeometry geometry, float time, unsigned int primID, float u, float v,
                                       const float* Ng, struct RTCCompressedTriangle* triangle);

/* A part of a surface: a grid of up to 16 x 16 quads, with cGRID up to 256 x 256. Quad (x,y) has the triangles (x,y),
 * (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). Vertices that neighboring parts share are equal floats; with cGRID
 * only inside of a face.
 *
 * An irregular quad or triangle of a mesh is a part of its own: a grid of 2 x 2 vertices, in which the second triangle,
 * or the first one, may be missing. A missing triangle has two equal vertices.
 *
 * Later versions may append members. */
struct RTCCompressedPart {
  unsigned int primID;            /* primitive of all quads, if primitivesPerQuad is 0 */
  unsigned int width, height;     /* in vertices */
  const float* vertices;          /* x, y, z of width*height vertices, row by row. Triangles with a NaN are left out */
  const float* parameters;        /* u, v of each vertex; NULL if primitivesPerQuad is not 0 */
  const unsigned int* primIDs;    /* row by row, primitivesPerQuad entries per quad; NULL if that is 0 */
  unsigned int primitivesPerQuad; /* 0: subdivision surfaces and grids. 1: quad meshes. 2: triangle meshes: the primID
                                   * of the quad's first triangle, then that of its second triangle, or the first one
                                   * again if there is no second triangle */
};

/* Called with a part, which is valid until the function returns. Returning false ends the enumeration. */
typedef bool (*RTCCompressedPartFunction)(void* userPtr, const struct RTCCompressedPart* part);

/* Calls a function for all parts of a surface at a time, on the calling thread, in unspecified order. Each part is
 * decoded when it is passed: the function needs no memory for the whole surface.
 *
 * geometry: as for rtcFindCompressedTriangle.
 * time:     of rays. Ignored for geometry that does not move. Outside of the time range there are no parts.
 * function: not NULL.
 * userPtr:  passed to the function.
 *
 * Errors: as for rtcFindCompressedTriangle. Thread safety: as rtcInterpolate. */
RTC_API void rtcForEachCompressedPart(RTCGeometry geometry, float time, RTCCompressedPartFunction function,
                                      void* userPtr);

RTC_NAMESPACE_END
