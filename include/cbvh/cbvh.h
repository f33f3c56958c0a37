// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#ifndef CBVH_CBVH_H
#define CBVH_CBVH_H

/* Compressed surfaces for any version of Embree, or without Embree.
 *
 * libembree_cbvh.so contains the kernels of Embree CBVH and exports only this API. It can be loaded next to any version
 * of Embree. cbvh/embree.h makes its surfaces a geometry of the Embree that a renderer uses.
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
 * Surfaces are stored as cVERT: the triangles of a fine tessellation with vertices on a lattice, in 2 to 4 bytes per
 * quad. Irregular triangles mostly need 7 to 8 bytes each.
 *
 * Functions return an error code, CBVH_OK on success. cbvhGetErrorText returns the message of the last error. New
 * objects have a reference count of 1.
 *
 * Thread safety: any thread may call any function, with one restriction: while a thread changes an object, no other
 * thread may change or trace the same object.
 *
 * Structs that may grow in later versions begin with structSize, which the application sets to the sizeof of the
 * struct. In C++ a default member initializer does so; in C write {.structSize = sizeof(cage)}. Versions only append
 * members:
 *
 * - When the library reads a struct, members that the application's version lacks count as zero. The library accepts a
 *   larger struct than its own if all additional bytes are zero.
 * - When the library writes a struct, it writes the members that both versions have, and zeros all other bytes of the
 *   application's struct except structSize.
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

/* Result of a call. Any code other than CBVH_OK means that the call failed; cbvhGetErrorText returns the reason. */
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

/* Returns the message of the last error on the calling thread. Valid until the next error on this thread. */
CBVH_API const char* cbvhGetErrorText(void);

/* Returns the version of the library: 10203 is 1.2.3. */
CBVH_API unsigned int cbvhGetVersion(void);

/* --- contexts: threads and the error function ------------------------------------------ */

typedef struct CbvhContextTy* CbvhContext;

/* Called for every error, on the thread that caused it, before the failing function returns. */
typedef void (*CbvhErrorFunction)(void* userPtr, enum CbvhError code, const char* text);

/* Creates a context with a reference count of 1.
 *
 * settings: in the syntax of Embree's device configuration, for example "threads=4,isa=avx2". NULL selects the
 *           defaults. An unknown key or instruction set is an error whose message names the nearest valid one.
 * function: called for errors, or NULL.
 * userPtr:  passed to the function.
 * context:  written on success. */
CBVH_API enum CbvhError cbvhNewContext(const char* settings, CbvhErrorFunction function, void* userPtr,
    CbvhContext* context);
CBVH_API void cbvhRetainContext(CbvhContext context);
CBVH_API void cbvhReleaseContext(CbvhContext context);

/* --- surfaces --------------------------------------------------------------------------- */

typedef struct CbvhSurfaceTy* CbvhSurface;

/* Positions of vertices at each time step, three floats each. For grids and meshes the library reads the caller's
 * arrays until the surface is committed. As in Embree, 4 bytes after the last vertex must be readable. */
struct CbvhVertices
{
  size_t count;
  size_t stride;              /* bytes from one vertex to the next, a multiple of 4 */
  const float* const* steps;  /* one pointer per time step */
  unsigned int numSteps;      /* 1 for a surface that does not move, otherwise up to 129 */
  float begin, end;           /* times of the first and the last step. Vertices are interpolated linearly between steps.
                               * Outside of the time range there is no surface. Ignored if numSteps is 1 */
};

/* Arguments of a displacement function, which moves points of the limit surface of one face. P: positions of `count`
 * points, read and written. Ng: their normals, of length 1. u, v: parameters on the face. Each coordinate has an
 * array of its own. Several threads call the function at the same time. */
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
  CBVH_BOUNDARY_SMOOTH = 0,       /* borders are smooth curves */
  CBVH_BOUNDARY_PIN_CORNERS = 1,  /* the same, but through vertices that belong to one face only */
  CBVH_BOUNDARY_PIN_BOUNDARY = 2, /* vertices on borders do not move */
  CBVH_BOUNDARY_PIN_ALL = 3       /* no vertex moves: faces are bilinear */
};

/* Values at the corners of faces for cbvhInterpolate, for example texture coordinates. cbvhSetCage copies them. */
struct CbvhAttribute
{
  const float* values;
  size_t count, stride;          /* number of values, and bytes from one value to the next */
  unsigned int width;            /* floats per value, 1 to 16 */
  const unsigned int* indices;   /* of values, one for each corner of each face. NULL: the indices of the vertices */
  enum CbvhBoundary boundary;
};

/* A control cage for Catmull-Clark subdivision. Set structSize and zero all other members first. In C++,
 * CbvhCage cage = CbvhCage() does both. */
struct CbvhCage
{
  size_t structSize CBVH_SIZE_OF(CbvhCage);
  size_t numFaces;
  const unsigned int* faceVertexCounts; /* number of vertices of each face, at least 3 */
  size_t numIndices;                 /* sum of faceVertexCounts */
  const unsigned int* indices;       /* of vertices, face by face */
  struct CbvhVertices vertices;

  float rate;                        /* quads along each edge, 1 to 4096 */
  const float* rates;                /* quads along each edge from a vertex of a face to the next, one entry per index.
                                      * NULL: rate holds for all edges */
  enum CbvhBoundary boundary;

  size_t numCreases;
  const unsigned int* creases;       /* two vertices each */
  const float* creaseSharpness;      /* infinity is a sharp edge */
  size_t numCorners;
  const unsigned int* corners;       /* vertices */
  const float* cornerSharpness;
  size_t numHoles;
  const unsigned int* holes;         /* faces that are left out */

  CbvhDisplacementFunction displacement; /* NULL: none */
  void* displacementPtr;

  size_t numAttributes;
  const struct CbvhAttribute* attributes;
};

/* A grid of vertices in row-major order. */
struct CbvhGrid
{
  unsigned int first, stride;       /* first vertex, and number of vertices from one row to the next */
  unsigned short width, height;     /* in vertices, at least 2 */
};

struct CbvhGrids
{
  size_t structSize CBVH_SIZE_OF(CbvhGrids);
  size_t count;
  const struct CbvhGrid* grids;
  struct CbvhVertices vertices;
};

/* Quads or triangles, in any order. The library stores the parts of a mesh in which quads form grids as grids, and the
 * remaining triangles in mesh blocks. Two triangles that share an edge can form a quad. Vertices with equal positions
 * count as one. */
struct CbvhMesh
{
  size_t structSize CBVH_SIZE_OF(CbvhMesh);
  unsigned int corners;             /* 4: quads, 3: triangles */
  size_t count;                     /* number of quads or triangles */
  const unsigned int* indices;      /* of vertices, `corners` per quad or triangle */
  struct CbvhVertices vertices;
};

/* A camera, and the size of quads in its picture. If all members but structSize, position and pixelSize are zero, quads
 * have the size of a pixel, and everything around the camera counts as inside of the picture. */
struct CbvhDicing
{
  size_t structSize CBVH_SIZE_OF(CbvhDicing);
  float position[3];                /* in world space. For an orthographic camera, only pixelSize and the region of the
                                     * picture matter */
  float direction[3];               /* towards the center of the picture, of any length */
  float up[3];                      /* up direction of the picture, of any length, not parallel to direction */
  int orthographic;                 /* 0: a perspective camera */
  float pixelSize;                  /* width of a pixel at distance 1; for an orthographic camera at any distance */
  float width, height;              /* of the picture in pixels. 0: direction and up are ignored */
  const float* transform;           /* from the surface's space to world space: 12 floats, column by column. NULL: the
                                     * identity */
  float quadSize;                   /* target length of the edges of quads in pixels. 0: 1 */
  float outside;                    /* factor of quadSize far outside of the picture and behind the camera. 0: 8 */
  float maxRate;                    /* largest number of quads along an edge, 1 to 4096. 0: 4096 */
  const float* maxRates;            /* the same for each edge, for example the number of texels along it: one entry per
                                     * index. NULL: maxRate holds for all edges */
};

/* Bounds of the error of stored vertices. If all members are zero, the spacing of the lattice is at most 1/36 of the
 * median edge of quads for cages, 1/512 for grids, and 1/2048 for meshes. See also cbvhSetLossless. */
struct CbvhAccuracy
{
  size_t structSize CBVH_SIZE_OF(CbvhAccuracy);
  float maxError;                   /* world units: largest spacing of the lattice. 0: no bound. A vertex moves by at
                                     * most half a spacing on each axis, which is 0.866 spacings in space */
  float maxPixelError;              /* the same bound in pixels of a camera. 0: no bound */
  float cameraPosition[3];
  float pixelSize;                  /* width of a pixel at distance 1 */
};

/* Creates an empty surface. */
CBVH_API enum CbvhError cbvhNewSurface(CbvhContext context, CbvhSurface* surface);
CBVH_API void cbvhRetainSurface(CbvhSurface surface);
CBVH_API void cbvhReleaseSurface(CbvhSurface surface);

/* Set the input of the next commit, and replace an earlier input. The functions read everything during the call, except
 * the vertices of grids and meshes: cbvhCommitSurface reads these, and the application may free them afterwards. The
 * primitives of the surface are the faces of a cage, the grids, or the quads or triangles of a mesh. */
CBVH_API enum CbvhError cbvhSetCage(CbvhSurface surface, const struct CbvhCage* cage);
CBVH_API enum CbvhError cbvhSetGrids(CbvhSurface surface, const struct CbvhGrids* grids);
CBVH_API enum CbvhError cbvhSetMesh(CbvhSurface surface, const struct CbvhMesh* mesh);

/* Sets the edge rates of a cage so that its quads have about the requested size in a picture. Call it after
 * cbvhSetCage, whose rates it replaces by powers of two. A commit releases the cage: for another view, call
 * cbvhSetCage again. Edges are measured on the displaced surface: several threads call the displacement function.
 * rates: written, one entry per index, or NULL. */
CBVH_API enum CbvhError cbvhDiceSurface(CbvhSurface surface, const struct CbvhDicing* dicing, float* rates);

/* Sets the accuracy of the next commit. NULL selects the defaults. */
CBVH_API enum CbvhError cbvhSetAccuracy(CbvhSurface surface, const struct CbvhAccuracy* accuracy);

/* Sets whether the next commit is lossless: it stores the exact vertices of grids and meshes, and of cages the vertices
 * that Embree evaluates. It then ignores cbvhSetAccuracy. lossless: 1 or 0, the default is 0. */
CBVH_API enum CbvhError cbvhSetLossless(CbvhSurface surface, int lossless);

/* Sets the mask of a surface. A ray can hit the surface if its mask and the surface's mask have a common bit. By
 * default all bits are set. The mask takes effect with the next cbvhCommitGroup of a group that contains the
 * surface, and then in all of its groups. */
CBVH_API enum CbvhError cbvhSetSurfaceMask(CbvhSurface surface, unsigned int mask);

/* Called with the completed fraction of a commit, 0 to 1, on any thread. Returning 0 cancels the commit. Like a
 * displacement function, it must not change its surface: functions that do so return CBVH_ERROR_INVALID_OPERATION. */
typedef int (*CbvhProgressFunction)(void* userPtr, double done);

/* Tessellates and compresses a surface with all threads of the context. Does nothing if the surface did not change
 * since its last commit. Returns CBVH_ERROR_CANCELLED if the progress function cancels: the surface is then
 * unchanged and keeps its input. Quads with vertices that are not finite are left out, and cbvhCommitGroup reports
 * them. progress: may be NULL. */
CBVH_API enum CbvhError cbvhCommitSurface(CbvhSurface surface, CbvhProgressFunction progress, void* userPtr);

/* Returns the number of primitives of the input that was set last. */
CBVH_API unsigned int cbvhGetSurfacePrimitiveCount(CbvhSurface surface);

/* Evaluates an attribute of a cage at a hit. P receives the value, of the attribute's width, and dPdu and dPdv its
 * derivatives; each may be NULL. u and v must be valid parameters of the face: 0 to 1 on a face with four corners,
 * otherwise on one of its sub-patches, as in hits.
 *
 * A displacement function may call it for its own surface during cbvhCommitSurface and cbvhDiceSurface. It then uses
 * the attributes of the cage that is displaced. */
CBVH_API enum CbvhError cbvhInterpolate(CbvhSurface surface, unsigned int primID, float u, float v,
    unsigned int attribute, float* P, float* dPdu, float* dPdv);

/* Points on one face, for cbvhInterpolatePoints. */
struct CbvhInterpolation
{
  size_t structSize CBVH_SIZE_OF(CbvhInterpolation);
  unsigned int primID, attribute;
  size_t count;
  const float *u, *v;             /* parameters of the points, as for a displacement function */
  float *P, *dPdu, *dPdv;         /* written, one value after the other, each of the attribute's width; may be NULL */
};

/* Evaluates an attribute of a cage at many points of a face. If the parameters of a point are not valid, the function
 * returns an error that names the point, and writes nothing. Displacement functions use it to look up height maps,
 * because all points of one call are on the same face. */
CBVH_API enum CbvhError cbvhInterpolatePoints(CbvhSurface surface, const struct CbvhInterpolation* points);

/* Saves a committed surface to a file, without its mask and attributes. cbvhLoadSurface loads the file, and so does
 * rtcLoadCompressedGeometry of Embree CBVH. An existing file is replaced after everything is written: a crash or a full
 * disk leaves it unchanged. */
CBVH_API enum CbvhError cbvhSaveSurface(CbvhSurface surface, const char* path);

/* Loads a surface from a file. The surface is committed and has no input. The file is mapped: rays can be traced at
 * once, blocks that no ray visits stay on disk, and processes share the memory. Hits are equal to the bit. The file may
 * be replaced or removed while the surface exists, but must not be written to.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for files that have another format or a newer version, or are truncated or
 * altered; the message states the reason. Damaged blocks are left out when a ray visits them, and reported once to
 * the error function. surface: written on success. */
CBVH_API enum CbvhError cbvhLoadSurface(CbvhContext context, const char* path, CbvhSurface* surface);

/* --- groups: surfaces that are traced together ----------------------------------------- */

typedef struct CbvhGroupTy* CbvhGroup;

/* Creates a group of committed surfaces, and retains them. A surface may be in several groups. */
CBVH_API enum CbvhError cbvhNewGroup(CbvhContext context, const CbvhSurface* surfaces, size_t count, CbvhGroup* group);
CBVH_API void cbvhRetainGroup(CbvhGroup group);
CBVH_API void cbvhReleaseGroup(CbvhGroup group);

/* Builds the tree of a group from the last commits of its surfaces. Call it before the first ray, and after commits of
 * surfaces.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT, once, in three cases: a displacement function returned numbers that are not
 * finite; a grid has vertices outside of its buffer; faces were left out because they have more than 16 corners, or
 * a vertex has more than 64 faces. The message names the surface ("geometry" and its index) and the first face or
 * grid, or the number of faces. The rest of the group is committed. */
CBVH_API enum CbvhError cbvhCommitGroup(CbvhGroup group);

/* Return the number of surfaces of a group, and one of them, or NULL for an index out of range. The group keeps its
 * reference. */
CBVH_API size_t cbvhGetGroupSize(CbvhGroup group);
CBVH_API CbvhSurface cbvhGetGroupSurface(CbvhGroup group, size_t index);

/* Set and return a pointer that the application stores with a group. */
CBVH_API void cbvhSetGroupUserPtr(CbvhGroup group, void* userPtr);
CBVH_API void* cbvhGetGroupUserPtr(CbvhGroup group);

/* Number the primitives of all surfaces of a group consecutively.
 *
 * cbvhGetGroupFirstPrimitive returns the number of the first primitive of a surface. For the index cbvhGetGroupSize it
 * returns the number of all primitives, and 0 for larger indices. It returns at most 4294967295.
 *
 * cbvhFindGroupPrimitive writes the surface and the primitive of a number and returns 1, or returns 0 if no
 * primitive has this number. */
CBVH_API unsigned int cbvhGetGroupFirstPrimitive(CbvhGroup group, size_t index);
CBVH_API int cbvhFindGroupPrimitive(CbvhGroup group, unsigned int number, size_t* index, unsigned int* primID);

/* Returns the bounds of a group at all times: x, y, z. lower is above upper if the group is empty. */
CBVH_API void cbvhGetGroupBounds(CbvhGroup group, float lower[3], float upper[3]);

/* Memory and size of a group. */
struct CbvhStatistics
{
  size_t structSize CBVH_SIZE_OF(CbvhStatistics);
  size_t bytes;                 /* total memory of the group, including memory that it shares with other groups */
  size_t numQuads;              /* of the tessellation */
  size_t numMovingQuads;        /* quads with several time steps */
  size_t numInvalidQuads;       /* quads that were left out */
  float maxVertexDeviation;     /* world units: largest distance by which a vertex was moved */
};
CBVH_API enum CbvhError cbvhGetGroupStatistics(CbvhGroup group, struct CbvhStatistics* statistics);

/* --- rays -------------------------------------------------------------------------------- */

/* The layout of RTCRay and RTCHit of Embree 3 and 4, without the last member of Embree 4's RTCHit. Aligned to 16
 * bytes. */
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

/* Arguments of a filter function, which accepts or rejects hits. rays, hits: in the layout of RTCRayN and RTCHitN for
 * `count` rays. valid: -1 for each hit, otherwise 0; the function sets it to 0 to reject the hit. */
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
  CBVH_QUERY_COHERENT = 1      /* the rays of a packet have similar origins and directions */
};

/* Options of a query. */
struct CbvhQuery
{
  size_t structSize CBVH_SIZE_OF(CbvhQuery);
  unsigned int flags;          /* bits of CbvhQueryFlags */
  CbvhFilterFunction filter;   /* NULL: every hit counts */
  void* filterPtr;
};

/* Find closest hits. If a ray hits a surface at a distance below tfar, tfar becomes this distance and the hit is
 * written. All other members are unchanged. query: NULL selects the defaults.
 *
 * cbvhIntersect1 returns 1 if the ray hits. The packet functions return one bit per ray. Packets have the layout of
 * Embree's RTCRayHit4, 8 and 16. valid: -1 for rays that are traced, otherwise 0, with the alignment of the rays; NULL
 * traces all rays.
 *
 * If structSize of the query is wrong, functions that trace rays call the error function, trace nothing and return
 * 0. */
CBVH_API int cbvhIntersect1(CbvhGroup group, struct CbvhRayHit* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* Test for any hit: tfar becomes -infinity if a ray hits. Packets have the layout of RTCRay4, 8 and 16. */
CBVH_API int cbvhOccluded1(CbvhGroup group, struct CbvhRay* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* --- access to stored triangles ---------------------------------------------------------- */

struct CbvhTriangle
{
  float vertices[3][3];        /* x, y, z */
  float u[3], v[3];            /* parameters of the vertices on the primitive */
};

/* Finds the triangle of a hit, at the time of its ray. Ng: of the hit, to select between triangles with a common
 * edge, or NULL. Returns 1 if there is a triangle. */
CBVH_API int cbvhGetTriangle(CbvhSurface surface, float time, unsigned int primID, float u, float v, const float* Ng,
    struct CbvhTriangle* triangle);

/* A part of a surface: a grid of up to 16 x 16 quads. */
struct CbvhPart
{
  unsigned int primID;         /* primitive of all quads, if primitivesPerQuad is 0 */
  unsigned int width, height;  /* in vertices */
  const float* vertices;       /* x, y, z of each vertex, row by row. Triangles with a NaN are left out */
  const float* parameters;     /* u, v of each vertex; NULL if primitivesPerQuad is not 0 */
  const unsigned int* primIDs; /* row by row, primitivesPerQuad entries per quad */
  unsigned int primitivesPerQuad; /* 0: cages and grids. 1: meshes of quads. 2: meshes of triangles; the second
                                   * primitive is the first one again if the quad has one triangle */
};
/* Called with a part, which is valid until the function returns. Returning 0 ends the enumeration. */
typedef int (*CbvhPartFunction)(void* userPtr, const struct CbvhPart* part);

/* Calls a function for all parts of a surface at a time. */
CBVH_API enum CbvhError cbvhForEachPart(CbvhSurface surface, float time, CbvhPartFunction function, void* userPtr);

/* --- clusters that GPUs read: docs/formats/clusters.md describes them and names the specifications ---- */

enum CbvhClusterFormat
{
  CBVH_CLUSTER_FORMAT_FLOAT3 = 0, /* x, y, z of each vertex as floats */
  CBVH_CLUSTER_FORMAT_COMPRESSED1 = 1, /* header and vertices of D3D12_VERTEX_FORMAT_COMPRESSED1 (DirectX Raytracing),
                                        * padded to a multiple of 4 bytes */
  CBVH_CLUSTER_FORMAT_DGF1 = 2  /* a block of 128 bytes of AMD's Dense Geometry Format, including the topology */
};

/* Reason why a cluster stores floats instead of the requested format. */
enum CbvhClusterReason
{
  CBVH_CLUSTER_REASON_NONE = 0,        /* the cluster has the requested format */
  CBVH_CLUSTER_REASON_RAW = 1,         /* the block stores these vertices as floats */
  CBVH_CLUSTER_REASON_MOVING = 2,      /* the vertices are interpolated between two time steps, not on a lattice, or
                                        * belong to a moving mesh block */
  CBVH_CLUSTER_REASON_OUT_OF_RANGE = 3 /* the vertices are over 2^23 spacings from the origin, or the spacing is below
                                        * 2^-126 */
};

/* A cluster: up to 8 x 8 quads with 81 vertices and 128 triangles; DGF has up to 64 of both. */
struct CbvhCluster
{
  enum CbvhClusterFormat format; /* of data: the requested format, or CBVH_CLUSTER_FORMAT_FLOAT3 */
  enum CbvhClusterReason reason;
  unsigned int numVertices, numTriangles;
  const void* data;              /* aligned to 4 bytes */
  size_t bytes;                  /* of data */
  const unsigned char* indices;  /* three vertices for each triangle; with DGF in the order in which a decoder emits
                                  * them */
  const unsigned int* triangles; /* number in the part of each triangle: 2 ((width-1) y + x) for the first triangle of
                                  * quad x, y, and 1 more for its second */
  unsigned int firstTriangle;    /* number of triangles in all clusters before. With DGF the primitive indices of the
                                  * block start here */
  unsigned int width, height;    /* in vertices, row by row, if the cluster is a complete grid: all clusters of this
                                  * size have the same indices. 0, 0 otherwise and with DGF */
  const struct CbvhPart* part;   /* the part that contains the cluster: parameters and primIDs */
};

/* Totals over clusters. */
struct CbvhClusterReport
{
  size_t structSize CBVH_SIZE_OF(CbvhClusterReport);
  size_t numClusters, numTriangles;
  size_t numVertices;            /* shared vertices count once for each cluster */
  size_t bytes;                  /* of data */
  size_t indexBytes;             /* of the indices of clusters that are not complete grids, 3 bytes per triangle. 0 for
                                  * DGF, whose blocks contain indices */
  size_t numClustersOf[4];       /* by CbvhClusterReason */
  size_t numTrianglesOf[4];      /* by CbvhClusterReason */
};

/* Called with a cluster, which is valid until the function returns. Returning 0 ends the enumeration. */
typedef int (*CbvhClusterFunction)(void* userPtr, const struct CbvhCluster* cluster);

/* Calls a function for all clusters of a surface at a time, on the calling thread.
 *
 * Vertices are not rounded: a decoder of the format returns the floats that rays hit, except that -0 becomes 0. There
 * are no cracks between clusters. Triangles with a vertex that is not finite, or with two equal vertices, are left
 * out, because no ray hits them. Clusters that the format cannot represent have floats, and their reason is set.
 *
 * function: NULL if only the report is needed.
 * report:   totals, or NULL.
 *
 * Returns CBVH_ERROR_INVALID_OPERATION if the surface has more triangles than the 29-bit primitive indices of DGF
 * can count. */
CBVH_API enum CbvhError cbvhForEachCluster(CbvhSurface surface, float time, enum CbvhClusterFormat format,
    CbvhClusterFunction function, void* userPtr, struct CbvhClusterReport* report);

#if defined(__cplusplus)
}
#endif

#endif
