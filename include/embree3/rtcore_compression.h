// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed surfaces.
 *
 * Subdivision geometry (RTC_GEOMETRY_TYPE_SUBDIVISION) with displacement is
 * tessellated, compressed and dropped when its scene is committed, and traced
 * straight from the compressed form. So is what the application has diced, as cVERT, whatever kind
 * is asked for, with the same triangles and parameters as Embree's, of vertices that lie on a lattice:
 * grids (RTC_GEOMETRY_TYPE_GRID), and meshes of quads (RTC_GEOMETRY_TYPE_QUAD) and of triangles (RTC_GEOMETRY_TYPE_TRIANGLE),
 * in which grids are found. Quads and triangles that lie in no grid are stored in mesh blocks, if the mesh
 * does not move. Geometry of these types that would gain nothing is left to Embree's own kernels. Which representation a geometry gets is
 * decided by, in this order: rtcSetGeometryCompression, the device string
 * ("subdiv_accel=cbvh.leaf,cbvh_frame_level=2"), the environment variable
 * EMBREE_CBVH ("leaf,frame_level=2"; "1" takes the best, which is cVERT; "1,triangles=0" leaves
 * triangles to Embree, and so do "quads=0" and "grids=0"), Embree's
 * own default (vertex grids).
 *
 * Quads with a vertex that is not finite are left out of a compressed geometry, and so are grids with vertices outside of their
 * buffer. The commit succeeds with all others. It reports RTC_ERROR_INVALID_ARGUMENT to the thread that commits where a
 * displacement function returned such a vertex, and for such grids, once for each geometry that changed since the last commit; the
 * message names the geometry and the first face or grid. What the buffers hold that is not finite is no error, as in Embree.
 * cVOXEL cannot leave a quad out: it stores patches with holes as cLEAF.
 *
 * cVERT, and cLEAF unless exactFaces is 0, close surfaces also where faces of one geometry evaluate
 * the vertices that they share apart: all take those of the face that owns the edge or corner. Grids of
 * one geometry are closed where they have the same vertices on their borders, by index or as the same floats.
 *
 * Structs that may grow in later versions begin with structSize, which the application sets to the sizeof of the
 * struct as it was compiled. In C++ a default member initializer does so. In C the application writes {.structSize =
 * sizeof(args)}, or calls the rtcInit function of the struct. Versions only append members:
 *
 * - Of a struct that the library reads, members that the application's version lacks count as zero. A struct that is
 *   larger than the library's own is accepted if all bytes after the members that the library knows are zero.
 * - Of a struct that the library writes, it writes the members that both versions have, and sets the remaining
 *   bytes of the application's struct to zero. structSize keeps its value.
 * - A structSize that is below the size in the first version, above 1024, or not a multiple of sizeof(size_t) is an
 *   error: RTC_ERROR_INVALID_ARGUMENT.
 *
 * Structs without structSize that an application passes, such as RTCCompressedTriangle, never grow. Structs that the
 * library passes to callbacks, such as RTCCompressedPart and RTCCompressedCluster, may grow at their end: do not
 * store arrays of them.
 *
 * Based on: Lier, Martinek, Stamminger, Selgrad, "A High-Resolution Compression
 * Scheme for Ray Tracing Subdivision Surfaces with Displacement", 2018. */

#include "rtcore.h"
#include "rtcore_compression_version.h"

/* Default value of structSize in C++. C has none. */
#if defined(__cplusplus)
#  define RTC_SIZE_OF(type) = sizeof(type)
#else
#  define RTC_SIZE_OF(type)
#endif

RTC_NAMESPACE_BEGIN

/* What rtcGetDeviceCompressionProperty returns. */
enum RTCCompressionProperty
{
  RTC_COMPRESSION_PROPERTY_VERSION       = 0, // as RTC_COMPRESSION_VERSION: 10203 is 1.2.3
  RTC_COMPRESSION_PROPERTY_VERSION_MAJOR = 1,
  RTC_COMPRESSION_PROPERTY_VERSION_MINOR = 2,
  RTC_COMPRESSION_PROPERTY_VERSION_PATCH = 3
};

/* Returns what the library that made a device is. Embree itself lacks the function: a program that
 * runs on either asks dlsym for its address.
 *
 * device: not NULL.
 * prop:   what is asked for.
 *
 * Returns the value, and 0 with RTC_ERROR_INVALID_ARGUMENT for NULL or an unknown property. Thread
 * safety: as rtcGetDeviceProperty. */
RTC_API ssize_t rtcGetDeviceCompressionProperty(RTCDevice device, enum RTCCompressionProperty prop);

/* Representation of a geometry. */
enum RTCCompression
{
  RTC_COMPRESSION_INHERIT = 0, // what the device string or the environment say
  RTC_COMPRESSION_NONE    = 1, // GRID:   Embree's full-precision vertex grids
  RTC_COMPRESSION_GRID    = 2, // cGRID:  compressed nodes, full-precision vertices
  RTC_COMPRESSION_VOXEL   = 3, // cVOXEL: compressed nodes, the leaf box is the surface
  RTC_COMPRESSION_LEAF    = 4, // cLEAF:  compressed nodes, 9 x 7-bit heights for 2 x 2 quads
  RTC_COMPRESSION_VERT    = 5, // cVERT:  GRID's own triangles over vertices on a lattice in the world
};

/* Frame level that picks itself, see RTCCompressionArguments::frameLevel. */
#define RTC_COMPRESSION_FRAME_LEVEL_AUTO (-1)

/* Frame level that is left to the device string or the environment. */
#define RTC_COMPRESSION_FRAME_LEVEL_INHERIT (-2)

/* Flags of RTCCompressionArguments. */
enum RTCCompressionFlags
{
  RTC_COMPRESSION_FLAG_NONE          = 0,

  /* The geometry is compressed by rtcCommitGeometry, and lets its input go: from then on it reads none of its buffers but those of
   * vertex attributes, and the application may free what it shared. Scenes trace it, and their commits take what is there.
   * rtcInterpolate of RTC_BUFFER_TYPE_VERTEX is an error then, and so is a commit after any change but of its mask, its filters and
   * whether it is enabled, unless its vertices and its faces with their indices, its grids, or its indices, were set again.
   * Without effect on geometry that is not compressed. */
  RTC_COMPRESSION_FLAG_RELEASE_INPUT = 1 << 0
};

/* Settings of one geometry. Fill with rtcInitCompressionArguments first. */
struct RTCCompressionArguments
{
  size_t structSize RTC_SIZE_OF(RTCCompressionArguments);

  enum RTCCompression compression;

  /* Number of uniform subdivisions of a face before local frames start: a face tessellated
   * at level L (2^L x 2^L quads) gets 4^n blocks of 2^(L-n) x 2^(L-n) quads, each in a frame
   * of its own; with other edge rates, blocks of that size for the highest, or smaller. 0 to 8;
   * clamped to L. AUTO takes the coarsest frames that meet maxError, or, without maxError,
   * blocks of 16 x 16 quads, which cost least in bytes times time. INHERIT takes the device's
   * setting, which is AUTO where nobody gives one. Without meaning for VERT, which has no frames. */
  int frameLevel;

  /* In world units, negative to inherit the device's setting.
   *
   * RTC_COMPRESSION_VERT: the largest spacing of the lattice to which vertices are moved. Spacings are powers of 2. A vertex moves by at most half
   * a spacing on each axis, 0.866 in space; on an axis where floats are coarser than the lattice it does not move. 0 is lossless: vertices of
   * grids, quads and triangles are stored to the bit, those of cages as Embree evaluates them. The default is 1/36 of the median edge of a
   * cage's quads, face by face, or less; 1/512 for a grid; 1/2048 for quads and triangles.
   *
   * RTC_COMPRESSION_VOXEL and LEAF: upper bound of a leaf's thickness. Honoured when frameLevel is
   * AUTO: a face is split into finer frames until its leaves meet the bound or a block has one quad
   * left. 0 is no bound. Without meaning for RTC_COMPRESSION_GRID. */
  float maxError;

  /* RTC_COMPRESSION_VERT: the same bound in pixels of a camera, 0 for none: a face at distance d, from
   * the camera to the bounds of its vertices, grown by a quarter, has a spacing of at most
   * maxPixelError*pixelSize*d. The lesser of this and maxError holds. */
  float maxPixelError;
  float cameraPosition[3];  /* world, finite where maxPixelError is not 0 */
  float pixelSize;          /* width of a pixel at distance 1, more than 0 where maxPixelError is not 0 */

  /* RTC_COMPRESSION_LEAF: 1 stores faces that a leaf's form cannot hold (open borders and creases that
   * curve, walls, folds) as RTC_COMPRESSION_VERT does, 0 stores all faces as cLEAF; negative inherits
   * the device's setting, which is 1 where nobody gives one. */
  int exactFaces;

  unsigned int flags; /* of RTCCompressionFlags */

  /* With RTC_COMPRESSION_FLAG_RELEASE_INPUT, called by rtcCommitGeometry with how much is done, from 0 to 1, by any thread; false
   * cancels: rtcCommitGeometry reports RTC_ERROR_CANCELLED, and the geometry keeps its input. May be NULL. */
  RTCProgressMonitorFunction progress;
  void* progressUserPtr;
};

/* Sets every argument to inherit the setting of the device. */
RTC_FORCEINLINE void rtcInitCompressionArguments(struct RTCCompressionArguments* args)
{
  args->structSize = sizeof(*args);
  args->compression = RTC_COMPRESSION_INHERIT;
  args->frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT;
  args->maxError = -1.0f;
  args->maxPixelError = 0.0f;
  args->cameraPosition[0] = args->cameraPosition[1] = args->cameraPosition[2] = 0.0f;
  args->pixelSize = 0.0f;
  args->exactFaces = -1;
  args->flags = RTC_COMPRESSION_FLAG_NONE;
  args->progress = NULL;
  args->progressUserPtr = NULL;
}

/* Chooses the representation of a geometry. Takes effect when the
 * scene is committed the next time; the geometry has to be committed before.
 * Blocks belong to the geometry: all scenes that it is attached to share them, and they are built
 * again when it was committed after a change of its surface. After changes of its mask, its filters
 * and whether it is enabled they are not. Geometry with motion blur is stored as VERT whatever kind is chosen; of a kind that is not VERT with exactFaces 0 it is Embree's.
 *
 * geometry: of type RTC_GEOMETRY_TYPE_SUBDIVISION, RTC_GEOMETRY_TYPE_GRID, RTC_GEOMETRY_TYPE_QUAD or
 *           RTC_GEOMETRY_TYPE_TRIANGLE.
 * args:     read during the call, not NULL.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, a wrong structSize, an unknown compression, a frame
 * level outside -2..8, a maxError that is not finite, a maxPixelError that is negative or not
 * finite, a camera without which it means nothing, an exactFaces above 1, or unknown flags;
 * RTC_ERROR_INVALID_OPERATION for a geometry of another type. The geometry keeps
 * its setting then. Thread safety: as rtcSetGeometryTessellationRate. */
RTC_API void rtcSetGeometryCompression(RTCGeometry geometry, const struct RTCCompressionArguments* args);

/* What a committed scene, or a geometry of a file, holds in compressed form. Sizes in bytes. */
struct RTCCompressionStatistics
{
  size_t structSize RTC_SIZE_OF(RTCCompressionStatistics);
  size_t topLevelBytes;         // full-precision BVH over blocks and grids
  size_t frameBytes;            // headers of all blocks: frame, IDs, parametrisation
  size_t nodeBytes;             // compressed inner nodes
  size_t leafBytes;             // leaves: heights (cLEAF), vertices (cGRID), none (cVOXEL)
  size_t gridBytes;             // grids of what is not compressed, see numGridQuads
  size_t numBlocks;
  size_t numQuads;              // quads in blocks
  size_t numGridQuads;          // quads in the same BVH that are traced by GRID instead
  size_t numInvalidQuads;       // quads left out because a vertex is not finite
  size_t numAffineBlocks;       // blocks whose projective frame fell back to an affine one
  size_t numSolidLeaves;        // cLEAF leaves that heights cannot bound: their box is the surface
  float  maxLeafThickness;      // world units: largest distance between the two bounds of a leaf, over its quad
  size_t numRawBlocks;          // cVERT: blocks that hold floats, for a vertex that is not finite or outliers
  float  maxVertexSpacing;      // cVERT, world units: largest spacing of a lattice
  float  maxVertexDeviation;    // cVERT, world units: largest distance of a vertex from the one that its face evaluated,
                                // or, on the border of faces, the face that owns it; of cLEAF those on borders
  float  maxBorderGap;          // cVERT, cLEAF, world units: largest distance between what two faces evaluate for a vertex
                                // that they share; it is closed
  size_t numExactQuads;         // cLEAF: quads of faces that are stored as cVERT, see RTCCompressionArguments::exactFaces
  size_t numFlippedQuads;       // quads whose normal, as it is traced, is turned by more than 90 degrees from that of
                                // their vertices
  size_t numMeshQuads;          // quads of quad meshes, and pairs of triangles, in blocks (two triangles of mesh
                                // blocks count as a pair); of them
  size_t numLooseQuads;         // those in none of the meshes' grids of 4 x 4 quads and more
  size_t numMovingQuads;        // quads with several time steps
  size_t motionBytes;           // of leafBytes: all their time steps but the first
  size_t numUnsupportedFaces;   // faces of cages left out because Embree's subdivision does not support them: more than
                                // 16 corners, more than 64 faces at a vertex, or such a face at one of their vertices
  size_t inputBytes;            // buffers of the compressed geometries that Embree allocated and that were not released,
                                // and its own copies of their topology
};

/* Reports what the last commit of a scene compressed. All zero when the scene
 * has no compressed geometry.
 *
 * scene: committed. Geometry inside instanced scenes belongs to those scenes.
 * stats: written during the call, not NULL; structSize is read.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a wrong structSize, RTC_ERROR_INVALID_OPERATION when
 * the scene or one of its geometries was modified since its last commit. Thread safety: as rtcGetSceneBounds. */
RTC_API void rtcGetSceneCompressionStatistics(RTCScene scene, struct RTCCompressionStatistics* stats);

RTC_NAMESPACE_END
