// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Bridges between Embree's objects and those of cbvh.h, which this library exports, too.
 *
 * The functions of cbvh.h read and write what rtcore.h has no functions for: triangles and clusters of compressed
 * geometry, files, and edge rates for a camera.
 *
 *   CbvhSurface surface = rtcNewSurfaceFromGeometry(geometry);
 *   cbvhFindTriangle(surface, ray.time, hit.primID, hit.u, hit.v, &hit.Ng_x, &triangle);
 *   cbvhReleaseSurface(surface);
 *
 *   CbvhContext context = rtcNewContextFromDevice(device);
 *   cbvhLoadSurface(context, "teapot.cbvh", &surface);
 *   RTCGeometry geometry = rtcNewGeometryFromSurface(device, surface);
 *
 * Functions of cbvh.h return the errors of these objects, and report them to the device, too: rtcGetDeviceError returns
 * the code, and the function that rtcSetDeviceErrorFunction sets receives the message. */

#include "cbvh.h"
#include "rtcore.h"

RTC_NAMESPACE_BEGIN

/* Creates a context that uses a device. Files and surfaces of the context belong to the device. The result is released
 * by cbvhReleaseContext.
 *
 * device: retained by the context.
 *
 * Returns the context, or NULL. All contexts of a device are equivalent.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. Thread safety: as rtcNewGeometry. */
RTC_API CbvhContext rtcNewContextFromDevice(RTCDevice device);

/* Creates a surface that refers to a geometry. The result is released by cbvhReleaseSurface.
 *
 * geometry: of a type that can be compressed, otherwise functions of the surface fail. Retained by the surface.
 *
 * Returns the surface, or NULL. It follows the geometry: after each commit of the geometry's scene, or of the geometry
 * itself with RTC_COMPRESSION_FLAG_RELEASE_INPUT, it has the new blocks. Functions that read triangles or save the
 * surface require such a commit, and return CBVH_ERROR_INVALID_OPERATION for geometry that is not compressed.
 * cbvhDiceSurface sets the edge rates of the geometry. All other functions that change a surface return
 * CBVH_ERROR_INVALID_OPERATION: the application changes and commits the geometry. Groups reject the surface.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. Thread safety: as rtcInterpolate, also for functions that read the
 * surface; for cbvhDiceSurface as rtcSetGeometryTessellationRate. */
RTC_API CbvhSurface rtcNewSurfaceFromGeometry(RTCGeometry geometry);

/* Returns the geometry of a surface: what its last commit stored, what was loaded from a file, or the geometry that it
 * refers to. The result is released by rtcReleaseGeometry. Several calls return the same geometry.
 *
 * device:  of the geometry.
 * surface: committed. Its context is one of rtcNewContextFromDevice for this device. The surface may be released before
 *          the geometry. After another commit of the surface, the geometry keeps what it has.
 *
 * Returns the geometry, or NULL. The geometry is committed. It can be attached to scenes, instanced, given a mask,
 * filters and user data, and traced like any other. It has no input: rtcInterpolate and functions that set buffers,
 * displacement, edge rates, time steps or compression fail with RTC_ERROR_INVALID_OPERATION.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and for a surface of another device or of libembree_cbvh.
 * RTC_ERROR_INVALID_OPERATION for a surface that is not committed. Thread safety: as rtcNewGeometry. */
RTC_API RTCGeometry rtcNewGeometryFromSurface(RTCDevice device, CbvhSurface surface);

/* Finds the closest point of the compressed geometries of a scene. Arguments and results are those of cbvhPointQuery;
 * geomID is that of the geometry in the scene.
 *
 * scene: committed.
 *
 * Returns true if a point was found and accepted.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and as cbvhPointQuery. RTC_ERROR_INVALID_OPERATION for a scene that is
 * not committed, and if a geometry near the point, even if outside of the radius, is not compressed as cTILE or cVERT,
 * or is in an instance: use rtcPointQuery for such scenes. Thread safety: as rtcPointQuery. */
RTC_API bool rtcFindClosestPoint(RTCScene scene, const struct CbvhPointQuery* query, struct CbvhClosestPoint* closest);

RTC_NAMESPACE_END
