// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#ifndef CBVH_CBVH_H
#define CBVH_CBVH_H

/* Compressed surfaces beside any Embree: libembree_cbvh.so has the kernels of Embree CBVH, and exports this API alone. It may be
 * loaded with any version of Embree, or with none: cbvh/embree.h makes its surfaces a geometry of the Embree that a renderer has.
 *
 *   CbvhContext context;  cbvhNewContext(NULL, NULL, NULL, &context);
 *   CbvhSurface surface;  cbvhNewSurface(context, &surface);
 *   struct CbvhCage cage = {.structSize = sizeof(cage)};  // in C++: CbvhCage cage = CbvhCage();
 *   cage.numFaces = ...
 *   cbvhSetCage(surface, &cage);                     // a Catmull-Clark control cage, with displacement
 *   cbvhCommitSurface(surface, NULL, NULL);          // from here on the cage's buffers may be freed
 *   CbvhGroup group;      cbvhNewGroup(context, &surface, 1, &group);
 *   cbvhCommitGroup(group);
 *   if (cbvhIntersect1(group, &ray, NULL)) ...
 *
 * Surfaces are stored as cVERT: the triangles of a fine tessellation, whose vertices lie on a lattice, in 2 to 4 bytes a quad.
 *
 * Functions return an error, CBVH_OK if there is none; cbvhGetErrorText says more of the last one. Objects are made with one reference.
 * Thread safety: of one object one thread may change something at a time, and nobody trace it meanwhile; otherwise any
 * thread may call any function.
 *
 * Structs that may grow in later versions begin with structSize, which the application sets to the sizeof of the
 * struct as it was compiled. In C++ a default member initializer does so; in C write {.structSize = sizeof(cage)}.
 * Versions only append members:
 *
 * - Of a struct that the library reads, members that the application's version lacks count as zero. A struct that is
 *   larger than the library's own is accepted if all bytes after the members that the library knows are zero.
 * - Of a struct that the library writes, it writes the members that both versions have, and sets the remaining
 *   bytes of the application's struct to zero. structSize keeps its value.
 * - A structSize that is below the size in the first version, above 1024, or not a multiple of sizeof(size_t) is an
 *   error: CBVH_ERROR_INVALID_ARGUMENT.
 *
 * Structs without structSize never grow if an application passes them: CbvhVertices, CbvhAttribute, CbvhGrid, rays,
 * hits and CbvhTriangle. Those that the library passes to callbacks may grow at their end: CbvhDisplacementArguments,
 * CbvhFilterArguments, CbvhPart and CbvhCluster. Do not store arrays of them. */

#include <stddef.h>

#if defined(__cplusplus)
extern "C" {
#endif

#define CBVH_API __attribute__((visibility("default")))
#define CBVH_ALIGNED __attribute__((aligned(16)))

/* Default value of structSize in C++. C has none. */
#if defined(__cplusplus)
#  define CBVH_SIZE_OF(type) = sizeof(type)
#else
#  define CBVH_SIZE_OF(type)
#endif

/* The result of a call. CBVH_OK: the call did what it is for. Anything else: it failed, and cbvhGetErrorText returns the
 * reason as a text. */
enum CbvhError
{
  CBVH_OK = 0,
  CBVH_ERROR_UNKNOWN = 1,
  CBVH_ERROR_INVALID_ARGUMENT = 2,
  CBVH_ERROR_INVALID_OPERATION = 3,
  CBVH_ERROR_OUT_OF_MEMORY = 4,
  CBVH_ERROR_UNSUPPORTED_CPU = 5,
  CBVH_ERROR_CANCELLED = 6
};

/* What went wrong in the last call of this thread that returned an error. Valid until the next one. */
CBVH_API const char* cbvhGetErrorText(void);

/* The library's version: 10203 is 1.2.3. */
CBVH_API unsigned int cbvhGetVersion(void);

/* --- contexts: threads, and whom errors are told --------------------------------------- */

typedef struct CbvhContextTy* CbvhContext;

/* Is told of each error, by the thread that it happens to, before the call returns. */
typedef void (*CbvhErrorFunction)(void* userPtr, enum CbvhError code, const char* text);

/* Creates a context with a reference count of 1. `settings` has the syntax of Embree's device configuration, for example "threads=4,isa=avx2"; NULL
 * selects the defaults. An unknown key or instruction set is an error, whose text names the nearest one. `function` may be NULL. `context` is written
 * if there is no error. */
CBVH_API enum CbvhError cbvhNewContext(const char* settings, CbvhErrorFunction function, void* userPtr, CbvhContext* context);
CBVH_API void cbvhRetainContext(CbvhContext context);
CBVH_API void cbvhReleaseContext(CbvhContext context);

/* --- surfaces --------------------------------------------------------------------------- */

typedef struct CbvhSurfaceTy* CbvhSurface;

/* Positions of vertices at each time step: three floats each. Those of grids and meshes are the caller's, and are read until the surface is
 * committed; 4 bytes behind the last vertex have to be readable, as for Embree. */
struct CbvhVertices
{
  size_t count;
  size_t stride;              /* bytes from one vertex to the next, a multiple of 4 */
  const float* const* steps;  /* a pointer a time step */
  unsigned int numSteps;      /* 1, or up to 129 of what moves */
  float begin, end;           /* times of the first and the last step; linear between steps, and no surface outside. Without meaning for 1 */
};

/* Moves points of the limit surface. P: x, y, z of `count` points in three arrays, read and written; Ng: their normals of length 1,
 * likewise, read; u, v: where on the face. Called by several threads at a time. */
struct CbvhDisplacementArguments
{
  void* userPtr;
  unsigned int primID;        /* the face */
  unsigned int timeStep;
  const float *u, *v;
  const float *Ng_x, *Ng_y, *Ng_z;
  float *P_x, *P_y, *P_z;
  unsigned int count;
};
typedef void (*CbvhDisplacementFunction)(const struct CbvhDisplacementArguments* args);

enum CbvhBoundary
{
  CBVH_BOUNDARY_SMOOTH = 0,       /* borders are curves */
  CBVH_BOUNDARY_PIN_CORNERS = 1,  /* and go through corners of one face */
  CBVH_BOUNDARY_PIN_BOUNDARY = 2, /* all vertices of borders stay */
  CBVH_BOUNDARY_PIN_ALL = 3       /* all vertices stay: faces are bilinear */
};

/* Values at the corners of faces for cbvhInterpolate, copied by cbvhSetCage: texture coordinates and the like. */
struct CbvhAttribute
{
  const float* values;
  size_t count, stride;          /* values, and bytes from one to the next */
  unsigned int width;            /* floats of a value, 1 to 16 */
  const unsigned int* indices;   /* of values, one a corner of each face; NULL: those of vertices */
  enum CbvhBoundary boundary;
};

/* A control cage for Catmull-Clark subdivision. Set structSize and zero all other members first. In C++,
 * CbvhCage cage = CbvhCage() does both. */
struct CbvhCage
{
  size_t structSize CBVH_SIZE_OF(CbvhCage);
  size_t numFaces;
  const unsigned int* faceVertices;  /* vertices of each face, from 3 */
  size_t numIndices;                 /* the sum of these */
  const unsigned int* indices;       /* of vertices, face by face */
  struct CbvhVertices vertices;

  float rate;                        /* quads along each edge, 1 to 4096 */
  const float* rates;                /* or of each edge, likewise, one an index: from that vertex to the next of its face; NULL: rate */
  enum CbvhBoundary boundary;

  size_t numCreases;
  const unsigned int* creases;       /* two vertices each */
  const float* creaseSharpness;      /* infinity: a sharp edge */
  size_t numCorners;
  const unsigned int* corners;
  const float* cornerSharpness;
  size_t numHoles;
  const unsigned int* holes;         /* faces that are left out */

  CbvhDisplacementFunction displacement; /* NULL: none */
  void* displacementPtr;

  size_t numAttributes;
  const struct CbvhAttribute* attributes;
};

/* A grid of vertices, row by row. */
struct CbvhGrid
{
  unsigned int first, stride;       /* vertex, and vertices from row to row */
  unsigned short width, height;     /* in vertices, from 2 */
};

struct CbvhGrids
{
  size_t structSize CBVH_SIZE_OF(CbvhGrids);
  size_t count;
  const struct CbvhGrid* grids;
  struct CbvhVertices vertices;
};

/* Quads or triangles that were diced, in any order: grids are found in them by the vertices that they share. Two
 * triangles that share an edge make a quad. Vertices with the same position are one. */
struct CbvhMesh
{
  size_t structSize CBVH_SIZE_OF(CbvhMesh);
  unsigned int corners;             /* 4: quads, 3: triangles */
  size_t count;                     /* of them */
  const unsigned int* indices;
  struct CbvhVertices vertices;
};

/* A camera, and how large quads may be in its picture. If all members but structSize, position and pixelSize are zero,
 * quads have the size of a pixel, and everything around the camera counts as inside of the picture. */
struct CbvhDicing
{
  size_t structSize CBVH_SIZE_OF(CbvhDicing);
  float position[3];                /* world space; of an orthographic camera only pixelSize and what lies in the picture matter */
  float direction[3];               /* into the middle of the picture, of any length */
  float up[3];                      /* of the picture, of any length, not along direction */
  int orthographic;                 /* 0: a perspective camera */
  float pixelSize;                  /* width of a pixel at distance 1; of an orthographic camera anywhere */
  float width, height;              /* of the picture in pixels. 0: direction and up do not matter */
  const float* transform;           /* surface to world, 12 floats, column by column; NULL: it is in world space */
  float quadSize;                   /* length of quads' edges in pixels, about; 0: 1 */
  float outside;                    /* so many times as large far outside of the picture, and behind the camera; 0: 8 */
  float maxRate;                    /* quads along an edge, 1 to 4096; 0: 4096 */
  const float* maxRates;            /* of each edge, likewise, one an index, for example the texels along it; NULL: maxRate alone */
};

/* How near to its vertices a surface is stored. Zeros: a spacing of 1/36 of the quads' edges, or less, of
 * a cage, of 1/512 of grids, of 1/2048 of meshes; see also cbvhSetLossless. */
struct CbvhAccuracy
{
  size_t structSize CBVH_SIZE_OF(CbvhAccuracy);
  float maxError;                   /* world units; the largest spacing of the lattice. A vertex moves by at most half of it on each axis, 0.866 in space. */
  float maxPixelError;              /* the same in pixels of a camera */
  float cameraPosition[3];
  float pixelSize;                  /* width of a pixel at distance 1 */
};

/* Makes a surface without anything in it. */
CBVH_API enum CbvhError cbvhNewSurface(CbvhContext context, CbvhSurface* surface);
CBVH_API void cbvhRetainSurface(CbvhSurface surface);
CBVH_API void cbvhReleaseSurface(CbvhSurface surface);

/* Set what the next commit makes the surface of, in place of what was there. All is read during the call but the vertices of grids and meshes, which
 * the next cbvhCommitSurface reads, and nobody after it. Of cages and grids primitives are faces and grids, of meshes their quads or triangles. */
CBVH_API enum CbvhError cbvhSetCage(CbvhSurface surface, const struct CbvhCage* cage);
CBVH_API enum CbvhError cbvhSetGrids(CbvhSurface surface, const struct CbvhGrids* grids);
CBVH_API enum CbvhError cbvhSetMesh(CbvhSurface surface, const struct CbvhMesh* mesh);

/* Sets the rates of a cage's edges, for the next commit, so that its quads are about as large in a picture as is asked for: after cbvhSetCage, in place of
 * the rates that it had. A commit lets the cage go: another view needs cbvhSetCage again. Edges are measured on the displaced surface, for which the
 * displacement function is called by several threads, and each gets a power of two. rates: written, one an index; NULL: not wanted. */
CBVH_API enum CbvhError cbvhDiceSurface(CbvhSurface surface, const struct CbvhDicing* dicing, float* rates);

/* Sets how the next commit stores it. NULL: as by default. */
CBVH_API enum CbvhError cbvhSetAccuracy(CbvhSurface surface, const struct CbvhAccuracy* accuracy);

/* Sets whether the next commit stores vertices as they are, to the bit, whatever cbvhSetAccuracy says: those of grids and meshes, and those that Embree
 * evaluates of a cage. lossless: 1 or 0, which it is by default. */
CBVH_API enum CbvhError cbvhSetLossless(CbvhSurface surface, int lossless);

/* Sets the mask of a surface, all bits by default: rays see the surface if their mask shares a bit with it. The mask takes effect with the next
 * cbvhCommitGroup of a group that contains the surface, then for all of its groups. */
CBVH_API enum CbvhError cbvhSetSurfaceMask(CbvhSurface surface, unsigned int mask);

/* Called with the part of a commit that is done, 0 to 1, on any thread. Returning 0 cancels the commit. Like displacement functions, it must not
 * change its surface: functions that do so return CBVH_ERROR_INVALID_OPERATION. */
typedef int (*CbvhProgressFunction)(void* userPtr, double done);

/* Tessellates and compresses with all threads of the context. Returns CBVH_ERROR_CANCELLED where progress said so: the surface is as before,
 * and keeps its input. Quads with vertices that are not finite are left out, which cbvhCommitGroup says. Without changes since the last commit
 * nothing is done. */
CBVH_API enum CbvhError cbvhCommitSurface(CbvhSurface surface, CbvhProgressFunction progress, void* userPtr);

/* Number of primitives of what was set last. */
CBVH_API unsigned int cbvhGetSurfacePrimitiveCount(CbvhSurface surface);

/* Evaluates an attribute of a cage at a hit: `width` floats, and their derivatives; NULL for what is not wanted. A displacement function may call it
 * for its own surface, during cbvhCommitSurface and cbvhDiceSurface: the attributes are then those of the cage that is displaced. u and v must be
 * parameters of the face, as hits have them: 0 to 1 on a face of four corners, otherwise on one of its sub-patches. */
CBVH_API enum CbvhError cbvhInterpolate(CbvhSurface surface, unsigned int primID, float u, float v, unsigned int attribute, float* P, float* dPdu, float* dPdv);

/* Points of one face, for which an attribute is evaluated, as by cbvhInterpolate. */
struct CbvhInterpolation
{
  size_t structSize CBVH_SIZE_OF(CbvhInterpolation);
  unsigned int primID, attribute;
  size_t count;
  const float *u, *v;             /* `count` of each, as a displacement function has them */
  float *P, *dPdu, *dPdv;         /* written, `width` floats for each point, point by point; NULL for what is not wanted */
};

/* Evaluates an attribute of a cage at many points of a face. If one of them has no valid u, v, an error is returned that names it, and nothing is
 * written. A displacement function looks up its height map with it: the points of a call are all on one face. */
CBVH_API enum CbvhError cbvhInterpolatePoints(CbvhSurface surface, const struct CbvhInterpolation* points);

/* Saves a committed surface to a file, which cbvhLoadSurface maps, and rtcLoadCompressedGeometry of Embree CBVH; not its mask and its attributes. A file that is
 * there is replaced when all is written: a crash or a full disk leaves it as it was. */
CBVH_API enum CbvhError cbvhSaveSurface(CbvhSurface surface, const char* path);

/* Makes a surface of a file, committed, without its cage: rays are traced at once, with the same hits to the bit, what none meets stays on disk, and processes
 * share the memory. The file may be replaced or removed meanwhile, but not written into. Foreign, truncated, altered, older and newer files are
 * refused, CBVH_ERROR_INVALID_ARGUMENT, with the reason; blocks that are damaged are left out when rays meet them, which the error function is told
 * once. surface: written if there is no error. */
CBVH_API enum CbvhError cbvhLoadSurface(CbvhContext context, const char* path, CbvhSurface* surface);

/* --- groups: surfaces that rays meet together ------------------------------------------ */

typedef struct CbvhGroupTy* CbvhGroup;

/* Makes a group of committed surfaces, which it retains. A surface may be in several groups. */
CBVH_API enum CbvhError cbvhNewGroup(CbvhContext context, const CbvhSurface* surfaces, size_t count, CbvhGroup* group);
CBVH_API void cbvhRetainGroup(CbvhGroup group);
CBVH_API void cbvhReleaseGroup(CbvhGroup group);

/* Takes the surfaces as they are now: call it before the first ray, and after commits of surfaces. If a displacement function returned numbers that are
 * not finite, or a grid has vertices outside of its buffer, the rest is committed, and CBVH_ERROR_INVALID_ARGUMENT is returned, once, whose text names the
 * surface, as "geometry" and its index, and its first face or grid. The same is returned, with their number, if faces are left out because they have more
 * than 16 corners, or a vertex has more than 64 faces. */
CBVH_API enum CbvhError cbvhCommitGroup(CbvhGroup group);

/* Its surfaces: how many they are, and one of them, or NULL. They stay the group's. */
CBVH_API size_t cbvhGetGroupSize(CbvhGroup group);
CBVH_API CbvhSurface cbvhGetGroupSurface(CbvhGroup group, size_t index);

/* What an application keeps with a group. */
CBVH_API void cbvhSetGroupUserPtr(CbvhGroup group, void* userPtr);
CBVH_API void* cbvhGetGroupUserPtr(CbvhGroup group);

/* Number the primitives of all surfaces consecutively. cbvhGetGroupFirstPrimitive returns the number of the first primitive of a surface; for
 * index cbvhGetGroupSize, the number of all primitives; 0 for an index after that. It returns at most 4294967295. cbvhFindGroupPrimitive writes the
 * surface and the primitive of a number and returns 1, or returns 0 if no primitive has the number. */
CBVH_API unsigned int cbvhGetGroupFirstPrimitive(CbvhGroup group, size_t index);
CBVH_API int cbvhFindGroupPrimitive(CbvhGroup group, unsigned int number, size_t* index, unsigned int* primID);

/* Bounds at all times: x, y, z. lower is above upper where there is nothing. */
CBVH_API void cbvhGetGroupBounds(CbvhGroup group, float lower[3], float upper[3]);

/* Sizes in bytes. */
struct CbvhStatistics
{
  size_t structSize CBVH_SIZE_OF(CbvhStatistics);
  size_t bytes;                 /* all that the group keeps, with what other groups share */
  size_t numQuads;              /* of the tessellation */
  size_t numMovingQuads;        /* of them those with several time steps */
  size_t numInvalidQuads;       /* that were left out */
  float maxVertexDeviation;     /* world units: by which a vertex was moved, at most */
};
CBVH_API enum CbvhError cbvhGetGroupStatistics(CbvhGroup group, struct CbvhStatistics* statistics);

/* --- rays -------------------------------------------------------------------------------- */

/* As RTCRay and RTCHit of Embree 3 and 4, without what RTCHit of 4 has behind: aligned to 16 bytes. */
struct CBVH_ALIGNED CbvhRay
{
  float org_x, org_y, org_z, tnear;
  float dir_x, dir_y, dir_z, time;
  float tfar;
  unsigned int mask, id, flags;
};

struct CBVH_ALIGNED CbvhHit
{
  float Ng_x, Ng_y, Ng_z;         /* normal of the triangle, of any length */
  float u, v;
  unsigned int primID, geomID, instID; /* geomID: index of the surface in its group */
};

struct CBVH_ALIGNED CbvhRayHit
{
  struct CbvhRay ray;
  struct CbvhHit hit;
};

/* Is asked of each hit before it counts. rays, hits: as RTCRayN and RTCHitN of `count` rays; valid: -1 for those that are asked about, to be set to 0 where
 * the hit does not count. */
struct CbvhFilterArguments
{
  int* valid;
  void* userPtr;
  void *rays, *hits;
  unsigned int count;
};
typedef void (*CbvhFilterFunction)(const struct CbvhFilterArguments* args);

enum CbvhQueryFlags
{
  CBVH_QUERY_COHERENT = 1      /* rays of a packet start near each other, and go alike */
};

struct CbvhQuery
{
  size_t structSize CBVH_SIZE_OF(CbvhQuery);
  unsigned int flags;
  CbvhFilterFunction filter;   /* NULL: every hit counts */
  void* filterPtr;
};

/* Closest hits. Where something is hit nearer than tfar, tfar becomes its distance and the hit is written; all else stays as it
 * is. query: NULL for zeros. Returns whether it was.
 *
 * If structSize of the query is wrong, functions that trace rays call the error function, trace nothing and return 0.
 *
 * Packets are as RTCRayHit4, 8 and 16 of Embree; valid: -1 for rays that count, else 0, aligned as the rays, or NULL for all. They return a bit a ray. */
CBVH_API int cbvhIntersect1(CbvhGroup group, struct CbvhRayHit* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* Any hit: tfar becomes -infinity where there is one. Packets are as RTCRay4, 8 and 16. */
CBVH_API int cbvhOccluded1(CbvhGroup group, struct CbvhRay* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* --- triangles out again ----------------------------------------------------------------- */

struct CbvhTriangle
{
  float vertices[3][3];        /* x, y, z */
  float u[3], v[3];            /* parameters of the vertices on the primitive */
};

/* Looks up the triangle that a hit is on, at the time of its ray; Ng of the hit, or NULL, tells triangles of a common edge apart. Returns whether there is one. */
CBVH_API int cbvhGetTriangle(CbvhSurface surface, float time, unsigned int primID, float u, float v, const float* Ng, struct CbvhTriangle* triangle);

/* Up to 16 x 16 quads. */
struct CbvhPart
{
  unsigned int primID;         /* that all quads are of, where primitivesPerQuad is 0 */
  unsigned int width, height;  /* in vertices */
  const float* vertices;       /* x, y, z of each, row by row. Triangles with one that is not a number are left out */
  const float* parameters;     /* u, v of each; NULL where primitivesPerQuad is not 0 */
  const unsigned int* primIDs; /* row by row, primitivesPerQuad of each quad */
  unsigned int primitivesPerQuad;
};
/* Valid until it returns; 0 ends the calls. */
typedef int (*CbvhPartFunction)(void* userPtr, const struct CbvhPart* part);

/* Hands out all of a surface as it is stored, as it is at a time. */
CBVH_API enum CbvhError cbvhForEachPart(CbvhSurface surface, float time, CbvhPartFunction function, void* userPtr);

/* --- clusters that GPUs read: docs/formats/clusters.md describes them and names the specifications ---- */

enum CbvhClusterFormat
{
  CBVH_CLUSTER_FLOAT3 = 0,      /* x, y, z of each vertex as floats */
  CBVH_CLUSTER_COMPRESSED1 = 1, /* D3D12_VERTEX_FORMAT_COMPRESSED1 of DirectX Raytracing: its header and vertices, filled up to 4 bytes */
  CBVH_CLUSTER_DGF1 = 2         /* a block of 128 bytes of AMD's Dense Geometry Format, with its topology */
};

/* Why a cluster has floats where another format was asked for. */
enum CbvhClusterReason
{
  CBVH_CLUSTER_FITS = 0,   /* it has not */
  CBVH_CLUSTER_RAW = 1,    /* its block keeps vertices as floats */
  CBVH_CLUSTER_MOVING = 2, /* vertices are between two time steps, and so on no lattice */
  CBVH_CLUSTER_RANGE = 3   /* on a lattice, but further from the origin than 2^23 of its steps, or with steps below 2^-126 */
};

/* Up to 8 x 8 quads: 81 vertices and 128 triangles; of DGF 64 of both. */
struct CbvhCluster
{
  enum CbvhClusterFormat format; /* of data: what was asked for, or CBVH_CLUSTER_FLOAT3 */
  enum CbvhClusterReason reason;
  unsigned int numVertices, numTriangles;
  const void* data;              /* aligned to 4 bytes */
  size_t bytes;
  const unsigned char* indices;  /* of three vertices of each triangle; of DGF in the order of a decoder */
  const unsigned int* triangles; /* which each is of the part: 2 ((width-1) y + x) of quad x, y, and 1 more for its second */
  unsigned int firstTriangle;    /* triangles that were handed out before; of DGF those of a block have their primitive indices from here on */
  unsigned int width, height;    /* in vertices, if it is a whole grid, row by row: all clusters of that size have the same indices. Otherwise, and of DGF, 0, 0 */
  const struct CbvhPart* part;   /* that it is cut from: parameters, primIDs */
};

/* Sums over clusters. */
struct CbvhClusterReport
{
  size_t structSize CBVH_SIZE_OF(CbvhClusterReport);
  size_t numClusters, numTriangles;
  size_t numVertices;            /* those that clusters share count in each */
  size_t bytes;                  /* of data */
  size_t indexBytes;             /* of indices that are not those of a whole grid, 3 bytes a triangle. DGF has its own */
  size_t numClustersOf[4];       /* by reason */
  size_t numTrianglesOf[4];      /* likewise */
};

/* Valid until it returns; 0 ends the calls. */
typedef int (*CbvhClusterFunction)(void* userPtr, const struct CbvhCluster* cluster);

/* Hands out all of a surface as it is at a time, cluster by cluster, by the calling thread. No vertex is moved: a decoder of the format gets the floats that rays meet here, but
 * 0 for -0, so clusters meet as triangles do. Triangles with a vertex that is not finite, or with two vertices in the same place, are left out: no ray hits them. What a
 * format cannot hold comes as floats, with the reason. function: may be NULL where only the report is wanted; report: may be NULL. Returns
 * CBVH_ERROR_INVALID_OPERATION where DGF has more triangles than the 29 bits of its primitive indices count. */
CBVH_API enum CbvhError cbvhForEachCluster(CbvhSurface surface, float time, enum CbvhClusterFormat format, CbvhClusterFunction function, void* userPtr, struct CbvhClusterReport* report);

#if defined(__cplusplus)
}
#endif

#endif
