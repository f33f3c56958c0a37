// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometry.
 *
 * The library compresses four types of geometry when their scene is committed (with
 * RTC_COMPRESSION_FLAG_RELEASE_INPUT: when they are committed), and traces rays directly in the compressed form:
 *
 * - Subdivision surfaces (RTC_GEOMETRY_TYPE_SUBDIVISION) are tessellated, displaced and compressed. Their vertices are
 *   not kept.
 * - Grids (RTC_GEOMETRY_TYPE_GRID) keep their triangles and their u and v.
 * - Quad meshes and triangle meshes (RTC_GEOMETRY_TYPE_QUAD, RTC_GEOMETRY_TYPE_TRIANGLE) keep their triangles, primIDs,
 *   u and v. The library finds the parts of a mesh in which quads form grids, whatever order they are in. It stores
 *   the remaining triangles in mesh blocks. A mesh with several time steps is stored either completely in grids or
 *   completely in mesh blocks.
 *
 * Grids, meshes and moving geometry are always stored exactly: as cTILE if that is selected, otherwise as cVERT; grids
 * of more than three time steps always as cVERT. Grids that compression would not make smaller are left to Embree's own
 * kernels, and so are meshes with RTC_BUILD_QUALITY_REFIT, and with fewer than 256 primitives unless
 * RTC_COMPRESSION_FLAG_SMALL_MESHES is set. The representation of a geometry is the first of these that is set:
 *
 * 1. the arguments of rtcSetGeometryCompression,
 * 2. the device string, for example "subdiv_accel=cbvh.leaf,cbvh_frame_level=2",
 * 3. the environment variable EMBREE_CBVH, for example "leaf,frame_level=2". "1" selects cTILE. "1,triangles=0" leaves
 *    triangle meshes to Embree; quads=0 and grids=0 do the same for quad meshes and grids.
 * 4. Embree's default, which does not compress.
 *
 * "cbvh_memory=512M" in the device string, or "memory=512M" in EMBREE_CBVH, limits what all compressed geometry of the
 * device takes after a commit. Each commit of a scene then chooses for its surfaces in cTILE between cTILE and cVERT,
 * which have the same hits: tiles where they fit, first for surfaces that many rays reach. If cVERT exceeds the limit,
 * the commit fails with RTC_ERROR_OUT_OF_MEMORY, and the message names the least possible limit.
 *
 * Compression leaves out quads with a vertex that is not finite, and grids that refer to vertices outside of the vertex
 * buffer. All other geometry is committed. The commit reports RTC_ERROR_INVALID_ARGUMENT on the committing thread for
 * such grids, and if a vertex that a displacement function returns is not finite. It reports once for each geometry
 * that changed since the last commit, and the message names the geometry and its first such face or grid. Vertices of
 * grids, meshes and cages that are not finite are no error, as in Embree: programs mark missing samples with them.
 * RTCCompressionStatistics counts their quads and names the first one. For cages, the commit also prints a line on
 * stderr with the first control vertex.
 * cVOXEL stores patches with left-out quads as cLEAF.
 *
 * Faces that Embree's subdivision does not support are left out without an error, and the commit prints a line on
 * stderr. See RTCCompressionStatistics::numUnsupportedFaces.
 *
 * Surfaces in cVERT and cTILE, and in cLEAF with fallbackFaces, are watertight: one of the faces that share an edge or
 * a corner owns it, and all of them use the vertices that the owner evaluates. Grids of one geometry are watertight
 * where they share border vertices, by index or by equal floats.
 *
 * Structs that may grow in later versions begin with structSize, which the application sets to the sizeof of the
 * struct. In C++ default member initializers set structSize and all other members. In C write, for example, `struct
 * RTCCompressionStatistics statistics = {.structSize = sizeof(statistics)};`. RTCCompressionArguments has members for
 * which zero is not the default: in C call rtcInitCompressionArguments, which sets all members. Versions only append
 * members:
 *
 * - When the library reads a struct, members that the application's version lacks count as zero. The library accepts a
 *   larger struct than its own if all additional bytes are zero.
 * - When the library writes a struct, it writes the members that both versions have, and zeros all other bytes of the
 *   application's struct except structSize.
 * - A structSize that is below the size in the first version, above 4096, or not a multiple of sizeof(size_t) is an
 *   error: RTC_ERROR_INVALID_ARGUMENT.
 *
 * As in Embree, rtcGetDeviceError returns the error code of a function that fails, and the function that
 * rtcSetDeviceErrorFunction sets receives the message. If the object of a function is NULL, rtcGetDeviceError(NULL)
 * returns the code. All functions can also report RTC_ERROR_OUT_OF_MEMORY and RTC_ERROR_UNKNOWN.
 *
 * Thread safety: any thread may call any function, but while a function changes, fills or releases an object, no other
 * thread may use the same object. A function that the application passes may run on several threads at the same time,
 * unless its comment says otherwise. Like the functions that Embree calls, it must not throw exceptions.
 *
 * The manual page of a function names the version since which the function is available.
 *
 * rtcore_surface.h gives access to triangles, clusters and files of compressed geometry, and to edge rates for a
 * camera.
 *
 * Based on: Lier, Martinek, Stamminger, Selgrad, "A High-Resolution Compression Scheme for Ray Tracing Subdivision
 * Surfaces with Displacement", 2018. */

#include "rtcore.h"
#include "rtcore_compression_version.h"

/* Default values of members in C++. C has none. */
#if defined(__cplusplus)
#define RTC_COMPRESSION_SIZE_OF(type) = sizeof(type)
#define RTC_DEFAULT(...) = __VA_ARGS__
#define RTC_ZERO \
  {}
#else
#define RTC_COMPRESSION_SIZE_OF(type)
#define RTC_DEFAULT(...)
#define RTC_ZERO
#endif

RTC_NAMESPACE_BEGIN

/* Properties of the library that rtcGetDeviceCompressionProperty returns. */
enum RTCCompressionProperty {
  RTC_COMPRESSION_PROPERTY_VERSION = 0, // RTC_COMPRESSION_VERSION of the library: 10203 is 1.2.3
  RTC_COMPRESSION_PROPERTY_VERSION_MAJOR = 1,
  RTC_COMPRESSION_PROPERTY_VERSION_MINOR = 2,
  RTC_COMPRESSION_PROPERTY_VERSION_PATCH = 3
};

/* Returns a property of the library that created a device. Stock Embree lacks this function: a program that runs with
 * either library looks it up with dlsym.
 *
 * device: not NULL.
 * prop:   the property.
 *
 * Returns the value, or 0 with RTC_ERROR_INVALID_ARGUMENT for NULL or an unknown property. Thread safety: as
 * rtcGetDeviceProperty. */
RTC_API ssize_t rtcGetDeviceCompressionProperty(RTCDevice device, enum RTCCompressionProperty prop);

/* Representation of a geometry. */
enum RTCCompression {
  RTC_COMPRESSION_INHERIT = 0, // the setting of the device string or of the environment
  RTC_COMPRESSION_NONE = 1,    // GRID:   Embree's full-precision vertex grids
  RTC_COMPRESSION_CGRID = 2,   // cGRID:  compressed nodes, full-precision vertices
  RTC_COMPRESSION_CVOXEL = 3,  // cVOXEL: compressed nodes; the boxes of leaves are the surface
  RTC_COMPRESSION_CLEAF = 4,   // cLEAF:  compressed nodes; leaves store 9 heights of 7 bits for 2 x 2 quads
  RTC_COMPRESSION_CVERT = 5,   // cVERT:  the triangles of GRID, with vertices rounded to a lattice in world space
  RTC_COMPRESSION_CTILE = 6,   // cTILE:  the vertices of cVERT, in about twice the bytes, traced faster
};

/* Frame level that the library chooses, see RTCCompressionArguments::frameLevel. */
#define RTC_COMPRESSION_FRAME_LEVEL_AUTO (-1)

/* Frame level of the device string or of the environment. */
#define RTC_COMPRESSION_FRAME_LEVEL_INHERIT (-2)

/* Flags of RTCCompressionArguments. */
enum RTCCompressionFlags {
  RTC_COMPRESSION_FLAG_NONE = 0,

  /* rtcCommitGeometry compresses the geometry and releases its input. Afterwards the geometry reads only buffers of
   * vertex attributes; the application may free all other buffers that it shared. Scenes use the blocks as they are.
   *
   * After the release, rtcInterpolate of RTC_BUFFER_TYPE_VERTEX reports RTC_ERROR_INVALID_OPERATION. So does
   * rtcCommitGeometry if anything but the mask, the filters or the enabled state changed, unless the application has
   * set the input again: vertices, and the faces with their indices, the grids, or the indices of a mesh.
   *
   * Has no effect on geometry that is not compressed. */
  RTC_COMPRESSION_FLAG_RELEASE_INPUT = 1 << 0,

  /* Compresses also meshes with fewer than 256 primitives, which are otherwise left to Embree. */
  RTC_COMPRESSION_FLAG_SMALL_MESHES = 1 << 1
};

/* Settings of one geometry. Call rtcInitCompressionArguments first. */
struct RTCCompressionArguments {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCCompressionArguments);

  enum RTCCompression compression RTC_DEFAULT(RTC_COMPRESSION_INHERIT);

  /* Number of times that a face is halved along both parameters before frames are assigned. At frame level n, a face
   * tessellated at level L (2^L x 2^L quads) gets 4^n blocks of 2^(L-n) x 2^(L-n) quads, each with its own frame. If
   * the edges have different rates, the highest one determines the size, and blocks may be smaller. 0 to 8, clamped
   * to L.
   *
   * AUTO selects the coarsest frames that keep maxError; without maxError, blocks of 16 x 16 quads, which minimize
   * the product of memory and time. INHERIT selects the setting of the device, which is AUTO by default. cVERT has no
   * frames and ignores this. */
  int frameLevel RTC_DEFAULT(RTC_COMPRESSION_FRAME_LEVEL_INHERIT);

  /* Error bound in world units. Negative inherits the setting of the device.
   *
   * cVERT: largest spacing of the lattice to which vertices are rounded. Spacings are powers of 2. A vertex moves by
   * at most half a spacing on each axis, which is 0.866 spacings in space. It does not move on an axis on which floats
   * are coarser than the lattice. A vertex that lies on an edge of a coarser grid moves with that edge instead, but by
   * at most maxError. 0 is lossless: the library stores the exact vertices of grids and meshes, and of subdivision
   * surfaces those that Embree evaluates. By default the spacing is at most 1/36 of the median edge of the quads of a
   * face, 1/512 of the median edge of a grid, and 1/2048 for quad and triangle meshes.
   *
   * cVOXEL, cLEAF: upper bound of the thickness of leaves. If frameLevel is AUTO, faces are split into finer frames
   * until their leaves keep the bound or a block has one quad. 0 is no bound. cGRID ignores this. */
  float maxError RTC_DEFAULT(-1.0f);

  /* cVERT: the same bound in pixels of a camera; 0 is no bound. The spacing of a face is at most
   * maxPixelError*pixelSize*d, where d is the distance from the camera to the bounds of the face's vertices, enlarged
   * by a quarter. If maxError is set too, the smaller bound holds; otherwise this one replaces the default. */
  float maxPixelError RTC_ZERO;
  float cameraPosition[3] RTC_ZERO; /* in the space of the vertices; must be finite if maxPixelError is not 0 */
  float pixelSize RTC_ZERO;         /* width of a pixel at distance 1; must be positive if maxPixelError is not 0 */

  /* cLEAF: 1 stores faces that leaves cannot represent (curved open borders and creases, walls, folds) as cVERT. 0
   * stores all faces as cLEAF. Negative inherits the setting of the device, which is 1 by default. */
  int fallbackFaces RTC_DEFAULT(-1);

  unsigned int flags RTC_ZERO; /* bits of RTCCompressionFlags */

  /* Progress function for rtcCommitGeometry with RTC_COMPRESSION_FLAG_RELEASE_INPUT, or NULL. It is called on any
   * thread, and by several threads at the same time, with the completed fraction, 0 to 1. If it returns false, the
   * commit is canceled: rtcCommitGeometry reports RTC_ERROR_CANCELLED, and the geometry keeps its input. */
  RTCProgressMonitorFunction progress RTC_ZERO;
  void* progressUserPtr RTC_ZERO; /* passed to the progress function. Must be valid until the commit */
};

/* Sets all arguments to inherit the settings of the device. args: written, not NULL. */
RTC_FORCEINLINE void rtcInitCompressionArguments(struct RTCCompressionArguments* args) {
  args->structSize = sizeof(*args);
  args->compression = RTC_COMPRESSION_INHERIT;
  args->frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT;
  args->maxError = -1.0f;
  args->maxPixelError = 0.0f;
  args->cameraPosition[0] = args->cameraPosition[1] = args->cameraPosition[2] = 0.0f;
  args->pixelSize = 0.0f;
  args->fallbackFaces = -1;
  args->flags = RTC_COMPRESSION_FLAG_NONE;
  args->progress = NULL;
  args->progressUserPtr = NULL;
}

/* Sets the representation of a geometry. It takes effect with the next commit of the geometry and the scene, which does
 * all the work.
 *
 * The geometry owns its blocks. All scenes that it is attached to share them. A commit builds them again if the surface
 * changed, but not for changes of the mask, the filters and the enabled state. Geometry with motion blur is stored as
 * cTILE if that is selected, otherwise as cVERT. If fallbackFaces is 0 and cLEAF, cVOXEL or cGRID is selected, moving
 * cages are left to Embree.
 *
 * geometry: of type RTC_GEOMETRY_TYPE_SUBDIVISION, RTC_GEOMETRY_TYPE_GRID, RTC_GEOMETRY_TYPE_QUAD or
 *           RTC_GEOMETRY_TYPE_TRIANGLE.
 * args:     read during the call, not NULL.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, a wrong structSize, an unknown compression, a frame level outside of
 * -2 to 8, a maxError that is not finite, a maxPixelError that is negative or not finite, an invalid camera, a
 * fallbackFaces above 1, unknown flags, or a compression that the library was built without.
 * RTC_ERROR_INVALID_OPERATION for a geometry of another type, and for a geometry that was loaded from a file. After an
 * error the geometry keeps its settings. Thread safety: as rtcSetGeometryTessellationRate. */
RTC_API void rtcSetGeometryCompression(RTCGeometry geometry, const struct RTCCompressionArguments* args);

/* Compression statistics of a committed scene. Sizes are in bytes. */
struct RTCCompressionStatistics {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCCompressionStatistics);
  size_t topLevelBytes RTC_ZERO;     // full-precision BVH over blocks and grids
  size_t headerBytes RTC_ZERO;       // headers of all blocks: frame, IDs, parametrization
  size_t nodeBytes RTC_ZERO;         // compressed inner nodes
  size_t leafBytes RTC_ZERO;         // leaves: heights (cLEAF), vertices (others), none (cVOXEL)
  size_t uncompressedBytes RTC_ZERO; // Embree's grids of quads that are not compressed, see
                                     // numUncompressedQuads
  size_t numBlocks RTC_ZERO;
  size_t numQuads RTC_ZERO;                 // quads in blocks
  size_t numUncompressedQuads RTC_ZERO;     // quads in the same BVH that Embree's GRID traces instead
  size_t numInvalidQuads RTC_ZERO;          // quads left out because a vertex is not finite, or an index of a mesh is
                                            // past the vertices
  size_t numAffineBlocks RTC_ZERO;          // blocks that have an affine frame because a projective frame was not
                                            // possible
  size_t numSolidLeaves RTC_ZERO;           // cLEAF leaves that heights cannot bound: rays hit their box
  float maxLeafThickness RTC_ZERO;          // world units: largest distance between the two bounds of a leaf, over its
                                            // quad
  size_t numRawBlocks RTC_ZERO;             // cVERT: blocks that store floats, because these need no more bytes or a
                                            // vertex is not finite
  float maxVertexSpacing RTC_ZERO;          // cVERT, world units: largest spacing of a lattice
  float maxVertexDeviation RTC_ZERO;        // cVERT, world units: largest distance of a stored vertex from the vertex
                                            // that its face evaluated, or on shared borders the face that owns it.
                                            // cLEAF: on borders only
  float maxBorderMismatch RTC_ZERO;         // cVERT, cLEAF, world units: largest distance between the vertices that
                                            // two faces evaluate at the same place; the stored surface has no such gap
  size_t numFallbackQuads RTC_ZERO;         // cLEAF: quads of faces stored as cVERT, see
                                            // RTCCompressionArguments::fallbackFaces
  size_t numFlippedQuads RTC_ZERO;          // quads whose stored normal differs from their vertices' normal by more
                                            // than 90 degrees
  size_t numMeshQuads RTC_ZERO;             // quads of quad meshes in blocks, plus pairs of triangles of triangle
                                            // meshes
  size_t numIrregularQuads RTC_ZERO;        // those of numMeshQuads that are in no grid of at least 4 x 4 quads
  size_t numMovingQuads RTC_ZERO;           // quads with several time steps
  size_t motionBytes RTC_ZERO;              // the part of leafBytes for all time steps but the first
  size_t numUnsupportedFaces RTC_ZERO;      // faces left out because Embree's subdivision does not support them: they,
                                            // or faces at their vertices, have 1, 2 or more than 16 corners, or one of
                                            // their vertices has more than 1024 faces, or 1023 at a border, or fewer
                                            // if these have more than 4 corners
  size_t inputBytes RTC_ZERO;               // buffers of compressed geometries that Embree allocated and that were not
                                            // released, and Embree's copies of their topology
  size_t cacheBytesPerThread RTC_ZERO;      // largest size of the caches in which each tracing thread keeps decoded
                                            // blocks; threads allocate a cache when they first need it, and share it
                                            // among all scenes
  unsigned int firstInvalidGeomID RTC_ZERO; // if numInvalidQuads is not 0: the first geometry with such quads that
                                            // was not loaded from a file, or RTC_INVALID_GEOMETRY_ID
  unsigned int firstInvalidPrimID RTC_ZERO; // its first face, grid, quad or triangle with such quads, or
                                            // RTC_INVALID_GEOMETRY_ID
};

/* Returns the statistics of the last commit of a scene, which the commit computed. All members are zero if the scene
 * has no compressed geometry.
 *
 * scene:      committed. Geometry of instanced scenes is not included.
 * statistics: written during the call, not NULL; structSize is read.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a wrong structSize. RTC_ERROR_INVALID_OPERATION if the scene or
 * one of its geometries was modified since the last commit. Thread safety: as rtcGetSceneBounds. */
RTC_API void rtcGetSceneCompressionStatistics(RTCScene scene, struct RTCCompressionStatistics* statistics);

RTC_NAMESPACE_END
