// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#ifndef CBVH_CBVH_H
#define CBVH_CBVH_H

/* Compressed surfaces for any version of Embree, or without Embree.
 *
 * libembree_cbvh.so contains the kernels of Embree CBVH and exports only this API. It can be loaded next to any version
 * of Embree. cbvh/embree.h makes its surfaces a geometry of the Embree that a renderer uses.
 *
 * The drop-in replacement libembree3.so.3 exports the same functions, for its geometries: embree3/rtcore_surface.h
 * returns the context of a device and the surface behind a geometry. A process may load both libraries, but objects of
 * one are invalid in the other: link a program with one of them only.
 *
 *   CbvhContext context;  cbvhNewContext(NULL, NULL, NULL, &context);
 *   CbvhSurface surface;  cbvhNewSurface(context, &surface);
 *   struct CbvhCage cage = {.structSize = sizeof(cage)};  // in C++: CbvhCage cage;
 *   cage.numFaces = ...
 *   cbvhSetSurfaceCage(surface, &cage);              // a Catmull-Clark control cage, with displacement
 *   cbvhCommitSurface(surface, NULL, NULL);          // from here on the cage's buffers may be freed
 *   CbvhGroup group;      cbvhNewGroup(context, &surface, 1, &group);
 *   cbvhCommitGroup(group);
 *   if (cbvhIntersect1(group, &ray, NULL)) ...
 *
 * Surfaces are stored as the triangles of a fine tessellation with vertices on a lattice. Displaced cages mostly need 5
 * to 7 bytes per quad as tiles (cTILE), the default, and 2 to 4 as cVERT, which rays decode; irregular meshes
 * need 9 to 11 bytes per triangle, as cVERT 7 to 8. docs/error.md lists noisy surfaces.
 *
 * Errors: most functions return an error code, CBVH_OK on success. Functions that return a value return 0 or NULL on
 * failure. cbvhGetErrorText returns the message of the last error. Functions that return a count, a pointer or bounds
 * set no message if the object is NULL. The comment of a function names its error codes, except three that many
 * functions share:
 *
 * - CBVH_ERROR_INVALID_ARGUMENT for an argument that is NULL, unless the comment allows NULL, and for a wrong
 *   structSize. Functions that return a value return 0 or NULL.
 * - CBVH_ERROR_OUT_OF_MEMORY.
 * - CBVH_ERROR_UNKNOWN for failures that have no code, such as a C++ exception of a displacement function.
 *
 * Ownership: new objects have a reference count of 1. The retain functions add a reference, the release functions
 * remove one, and the last one frees the object; both ignore NULL. Files and writers have one owner: their release
 * functions free them. Surfaces, files and writers retain their context, a group its context and its surfaces. Arrays,
 * structs and texts that an application passes are read during the call only, unless the comment of the function states
 * otherwise.
 *
 * Thread safety: any thread may call any function, with one restriction: while a thread changes an object, no other
 * thread may use the same object. The functions cbvhSet..., cbvhDiceSurface, cbvhCommitSurface and cbvhCommitGroup
 * change their object, and all functions of a CbvhFileWriter change it. cbvhCommitGroup also reads its surfaces, and
 * changes surfaces whose mask was set. Rays read only the group: it may be traced while its surfaces are set, diced or
 * committed. A function that changes a surface while another change of the surface is in progress, for example from a
 * callback, returns CBVH_ERROR_INVALID_OPERATION.
 *
 * Filter functions and error functions must not throw exceptions.
 *
 * The manual page of a function names the version since which the function is available.
 *
 * Structs that may grow in later versions begin with structSize, which the application sets to the sizeof of the
 * struct. In C++ default member initializers do so, and zero all other members; in C write {.structSize =
 * sizeof(cage)}. Versions only append members:
 *
 * - When the library reads a struct, members that the application's version lacks count as zero. The library accepts a
 *   larger struct than its own if all additional bytes are zero.
 * - When the library writes a struct, it writes the members that both versions have, and zeros all other bytes of the
 *   application's struct except structSize.
 * - A structSize that is below the size in the first version, above 4096, or not a multiple of sizeof(size_t) is an
 *   error: CBVH_ERROR_INVALID_ARGUMENT.
 *
 * Structs without structSize never grow if an application passes them: CbvhVertices, CbvhAttribute, CbvhGrid, rays,
 * hits, CbvhTriangle and CbvhGeometryQuery. Structs that the library passes to callbacks may grow at their end:
 * CbvhDisplacementArguments, CbvhFilterArguments, CbvhPart and CbvhCluster. Do not store arrays of them. */

#include <stddef.h>

#if defined(__cplusplus)
extern "C" {
#endif

#define CBVH_API __attribute__((visibility("default")))
#define CBVH_ALIGNED __attribute__((aligned(16)))

/* Default values of members in C++: sizeof for structSize, otherwise zero. C has none. CBVH_ZERO14 is for structs that
 * begin without structSize, which stay aggregates in C++11. */
#if defined(__cplusplus)
#define CBVH_SIZE_OF(type) = sizeof(type)
#define CBVH_ZERO \
  {}
#else
#define CBVH_SIZE_OF(type)
#define CBVH_ZERO
#endif
#if defined(__cplusplus) && __cplusplus >= 201402L
#define CBVH_ZERO14 \
  {}
#else
#define CBVH_ZERO14
#endif

/* Result of a call. Any code other than CBVH_OK means that the call failed, or, from cbvhCommitGroup, that parts of a
 * surface are missing. cbvhGetErrorText returns the reason. */
enum CbvhError {
  CBVH_OK = 0,
  CBVH_ERROR_UNKNOWN = 1,           /* a failure that has no code of its own */
  CBVH_ERROR_INVALID_ARGUMENT = 2,  /* an argument, a member of a struct or a file is invalid */
  CBVH_ERROR_INVALID_OPERATION = 3, /* the state of the object does not allow the call, or writing a file failed */
  CBVH_ERROR_OUT_OF_MEMORY = 4,
  CBVH_ERROR_UNSUPPORTED_CPU = 5, /* returned by cbvhNewContext only */
  CBVH_ERROR_CANCELLED = 6        /* returned by cbvhCommitSurface only */
};

/* Returns the message of the last error on the calling thread, or an empty text if there was none. Valid until the next
 * error on this thread. A call that succeeds does not clear it. */
CBVH_API const char* cbvhGetErrorText(void);

/* Returns the version of the library: 10203 is 1.2.3. */
CBVH_API unsigned int cbvhGetVersion(void);

/* --- contexts: threads and the error function ------------------------------------------ */

typedef struct CbvhContextTy* CbvhContext;

/* Called for every error of a context, on the thread that caused it, before the failing function returns. Several
 * threads may call it at the same time. text is valid during the call. The error function is not always called if an
 * argument is NULL, and not if an index of cbvhGetGroupFirstPrimitive is out of range. */
typedef void (*CbvhErrorFunction)(void* userPtr, enum CbvhError code, const char* text);

/* Creates a context with a reference count of 1.
 *
 * settings: in the syntax of Embree's device configuration, for example "threads=4,isa=avx2". NULL selects the
 *           defaults. An unknown key or instruction set is an error whose message names the nearest valid one.
 *           "cbvh_max_error=0.01" changes the default of CbvhAccuracy, where 0 is lossless, and so does max_error in
 *           the environment variable EMBREE_CBVH, whose item verbose prints a line per commit of a group.
 *           "subdiv_accel=cbvh.vert" stores surfaces as cVERT instead of tiles, "cbvh_memory=512M" limits the memory of
 *           the context's surfaces (embree3/rtcore_compression.h); EMBREE_CBVH has the items vert and memory=512M.
 *           Other representations have no effect.
 * function: called for errors, or NULL.
 * userPtr:  passed to the function.
 * context:  written on success.
 *
 * cbvhRetainContext and cbvhReleaseContext add and remove a reference.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for invalid settings and for an invalid EMBREE_CBVH, and
 * CBVH_ERROR_UNSUPPORTED_CPU if the CPU lacks the instruction set that the library requires or that the settings
 * select. */
CBVH_API enum CbvhError cbvhNewContext(const char* settings, CbvhErrorFunction function, void* userPtr,
                                       CbvhContext* context);
CBVH_API void cbvhRetainContext(CbvhContext context);
CBVH_API void cbvhReleaseContext(CbvhContext context);

/* --- surfaces --------------------------------------------------------------------------- */

typedef struct CbvhSurfaceTy* CbvhSurface;

/* Positions of vertices at each time step, three floats each. cbvhSetSurfaceCage copies them. For grids and meshes the
 * library reads the caller's arrays until the surface is committed; as in Embree, the 4 bytes after the last vertex of
 * each time step must then be readable. */
struct CbvhVertices {
  size_t numVertices CBVH_ZERO14;
  size_t stride CBVH_ZERO14;             /* bytes from one vertex to the next, a multiple of 4, at least 12 */
  const float* const* steps CBVH_ZERO14; /* one pointer per time step */
  unsigned int numSteps CBVH_ZERO14;     /* 1 for a surface that does not move, otherwise up to 129 */
  float startTime CBVH_ZERO14, endTime CBVH_ZERO14; /* times of the first and the last step, finite, startTime <
                                                     * endTime. Steps are evenly spaced. Vertices are interpolated
                                                     * linearly between steps. Outside of the time range there is no
                                                     * surface. The range may exceed 0 to 1, the times of rays, but
                                                     * rays do not hit a surface whose range is entirely outside.
                                                     * Ignored if numSteps is 1 */
};

/* Arguments of a displacement function, which moves points of the limit surface of one face. P: positions of `count`
 * points, read and written. Ng: their normals, of length 1, or 0 where the surface has no normal. u, v: parameters on
 * the face, as for cbvhInterpolateAttribute. Each coordinate has an array of its own. Several threads call the function
 * at the same time. */
struct CbvhDisplacementArguments {
  void* userPtr;
  unsigned int primID; /* the face */
  unsigned int timeStep;
  const float *u, *v;
  const float *Ng_x, *Ng_y, *Ng_z;
  float *P_x, *P_y, *P_z;
  unsigned int count;
};
typedef void (*CbvhDisplacementFunction)(const struct CbvhDisplacementArguments* args);

enum CbvhBoundary {
  CBVH_BOUNDARY_SMOOTH = 0,       /* borders are smooth curves */
  CBVH_BOUNDARY_PIN_CORNERS = 1,  /* the same, but through vertices that belong to one face only */
  CBVH_BOUNDARY_PIN_BOUNDARY = 2, /* vertices on borders do not move */
  CBVH_BOUNDARY_PIN_ALL = 3       /* no vertex moves: faces are bilinear */
};

/* Values at the corners of faces for cbvhInterpolateAttribute, for example texture coordinates. cbvhSetSurfaceCage
 * copies them. They are subdivided with the creases and corners of the cage. A value that is not finite makes results
 * on the faces around it not finite, and changes nothing else. */
struct CbvhAttribute {
  const float* values CBVH_ZERO14;
  size_t numValues CBVH_ZERO14;
  size_t stride CBVH_ZERO14;               /* bytes from one value to the next, a multiple of 4, at least 4*width */
  unsigned int width CBVH_ZERO14;          /* floats per value, 1 to 16 */
  const unsigned int* indices CBVH_ZERO14; /* of values, one for each corner of each face. NULL: the indices of the
                                            * vertices */
  enum CbvhBoundary boundary CBVH_ZERO14;  /* of the values. Ignored if indices is NULL: the boundary of the cage
                                            * holds */
};

/* A control cage for Catmull-Clark subdivision. Set structSize and zero all other members first, as default member
 * initializers do in C++. */
struct CbvhCage {
  size_t structSize CBVH_SIZE_OF(CbvhCage);
  size_t numFaces CBVH_ZERO;                      /* below 2^32 - 1, as numIndices */
  const unsigned int* faceVertexCounts CBVH_ZERO; /* number of vertices of each face, at least 3 */
  size_t numIndices CBVH_ZERO;                    /* sum of faceVertexCounts */
  const unsigned int* indices CBVH_ZERO;          /* of vertices, face by face */
  struct CbvhVertices vertices CBVH_ZERO;

  float rate CBVH_ZERO;         /* quads along each edge, 1 to 4096. Ignored if rates is not NULL */
  const float* rates CBVH_ZERO; /* quads along each edge from a vertex of a face to the next, 1 to 4096, one entry
                                 * per index. NULL: rate holds for all edges */
  enum CbvhBoundary boundary CBVH_ZERO;

  size_t numCreases CBVH_ZERO;
  const unsigned int* creases CBVH_ZERO;  /* two vertices each */
  const float* creaseSharpness CBVH_ZERO; /* one entry per crease, 0 to infinity, a sharp edge. 10 and more mean
                                           * infinity, also for corners, as in OpenSubdiv and USD */
  size_t numCorners CBVH_ZERO;
  const unsigned int* corners CBVH_ZERO;  /* vertices */
  const float* cornerSharpness CBVH_ZERO; /* one entry per corner, 0 to infinity */
  size_t numHoles CBVH_ZERO;
  const unsigned int* holes CBVH_ZERO; /* numHoles faces that are left out */

  CbvhDisplacementFunction displacement CBVH_ZERO; /* called by cbvhDiceSurface and cbvhCommitSurface. NULL: none */
  void* displacementUserPtr CBVH_ZERO;             /* passed to the displacement function. Must be valid until the
                                                    * commit */

  size_t numAttributes CBVH_ZERO;
  const struct CbvhAttribute* attributes CBVH_ZERO;
};

/* A grid of vertices in row-major order, in the layout of RTCGrid. */
struct CbvhGrid {
  unsigned int startVertexID;   /* first vertex */
  unsigned int stride;          /* number of vertices from one row to the next */
  unsigned short width, height; /* in vertices. A grid of less than 2 x 2 vertices has no quads */
};

/* Grids of vertices, for example diced patches. */
struct CbvhGrids {
  size_t structSize CBVH_SIZE_OF(CbvhGrids);
  size_t numGrids CBVH_ZERO; /* below 2^32 - 1 */
  const struct CbvhGrid* grids CBVH_ZERO;
  struct CbvhVertices vertices CBVH_ZERO;
};

/* Quads or triangles, in any order. The library stores the parts of a mesh in which quads form grids as grids, and the
 * remaining triangles in mesh blocks. Two triangles that share an edge can form a quad. Vertices with equal positions
 * count as one. Quads and triangles with an index past the vertices are left out. */
struct CbvhMesh {
  size_t structSize CBVH_SIZE_OF(CbvhMesh);
  unsigned int verticesPerFace CBVH_ZERO; /* 4: quads, 3: triangles */
  size_t numFaces CBVH_ZERO;              /* number of quads or triangles, below 2^32 - 1 */
  const unsigned int* indices CBVH_ZERO;  /* of vertices, `verticesPerFace` per quad or triangle */
  struct CbvhVertices vertices CBVH_ZERO;
};

/* A camera, and the size of quads in its picture. If all members but structSize, position and pixelSize are zero, quads
 * have the size of a pixel, and everything around the camera counts as inside of the picture. */
struct CbvhDicingArguments {
  size_t structSize CBVH_SIZE_OF(CbvhDicingArguments);
  float position[3] CBVH_ZERO;             /* in world space. For an orthographic camera, only pixelSize and the
                                            * region of the picture matter */
  float direction[3] CBVH_ZERO;            /* towards the center of the picture, of any length */
  float up[3] CBVH_ZERO;                   /* up direction of the picture, of any length, not parallel to direction */
  int orthographic CBVH_ZERO;              /* 0: a perspective camera */
  float pixelSize CBVH_ZERO;               /* width of a pixel at distance 1; for an orthographic camera at any
                                            * distance. Positive */
  float width CBVH_ZERO, height CBVH_ZERO; /* of the picture in pixels. 0: direction and up are ignored */
  const float* transform CBVH_ZERO;        /* from the surface's space to world space: 12 floats, column by column.
                                            * NULL: the identity */
  float quadSize CBVH_ZERO;                /* target length of the edges of quads in pixels. 0: 1 */
  float outsideFactor CBVH_ZERO;           /* factor of quadSize far outside of the picture and behind the camera,
                                            * at least 1. 0: 8 */
  float maxRate CBVH_ZERO;                 /* largest number of quads along an edge, 1 to 4096. 0: 4096 */
  const float* maxRates CBVH_ZERO;         /* further bound for each edge, for example the number of texels along
                                            * it: one entry per index, at least 1. An edge of two faces gets the
                                            * higher of their rates. NULL: only maxRate holds */
};

/* Bounds of the error of stored vertices. If both bounds are zero, the spacing of the lattice is at most 1/36 of the
 * median edge of quads for cages, 1/512 for grids, and 1/2048 for meshes. See also cbvhSetSurfaceLossless. */
struct CbvhAccuracy {
  size_t structSize CBVH_SIZE_OF(CbvhAccuracy);
  float maxError CBVH_ZERO;          /* in units of the vertices: largest spacing of the lattice. The spacing is a
                                      * power of two, and coordinates that are multiples of it do not move. A vertex
                                      * moves by at most half a spacing on each axis, which is 0.866 spacings in space.
                                      * If it lies on an edge of a coarser grid, it moves with that edge, by at most
                                      * maxError. 0: the bound in the settings of the context, where 0 is lossless.
                                      * If they have none, there is no bound besides maxPixelError and the default
                                      * above */
  float maxPixelError CBVH_ZERO;     /* the same bound in pixels of a camera. 0: no bound. If both bounds are set,
                                      * the smaller one holds */
  float cameraPosition[3] CBVH_ZERO; /* in the space of the vertices */
  float pixelSize CBVH_ZERO;         /* width of a pixel at distance 1. Positive if maxPixelError is not 0 */
};

/* Creates a surface without input.
 *
 * context: retained by the surface.
 * surface: written on success.
 *
 * cbvhRetainSurface and cbvhReleaseSurface add and remove a reference.
 *
 * Returns CBVH_OK, or an error that all functions share. */
CBVH_API enum CbvhError cbvhNewSurface(CbvhContext context, CbvhSurface* surface);
CBVH_API void cbvhRetainSurface(CbvhSurface surface);
CBVH_API void cbvhReleaseSurface(CbvhSurface surface);

/* Set the input of the next commit, and replace an earlier input. The functions read everything during the call, except
 * the vertices of grids and meshes: cbvhCommitSurface reads these, and the application may free them afterwards. The
 * primitives of the surface are the faces of a cage, the grids, or the quads or triangles of a mesh. Until the commit,
 * rays hit the surface of the last commit.
 *
 * cage, grids, mesh: structSize is read.
 *
 * Return CBVH_ERROR_INVALID_ARGUMENT if a member is invalid; the message states which. After an error, the earlier
 * input is kept. Vertices that are not finite are no error here, but see cbvhCommitGroup. The functions do not check
 * the vertices that grids and meshes refer to: see cbvhCommitGroup and CbvhMesh. */
CBVH_API enum CbvhError cbvhSetSurfaceCage(CbvhSurface surface, const struct CbvhCage* cage);
CBVH_API enum CbvhError cbvhSetSurfaceGrids(CbvhSurface surface, const struct CbvhGrids* grids);
CBVH_API enum CbvhError cbvhSetSurfaceMesh(CbvhSurface surface, const struct CbvhMesh* mesh);

/* Sets the edge rates of a cage so that its quads have about the requested size in a picture. Call it after
 * cbvhSetSurfaceCage, whose rates it replaces by powers of two. A commit releases the cage: for another view, call
 * cbvhSetSurfaceCage again.
 *
 * Edges are measured on the displaced surface: several threads call the displacement function, for about 1/16 as many
 * points as there will be quads. Lengths are measured as if the camera looked at them from the front: silhouettes,
 * shadows and reflections get quads as fine as those of visible surfaces. The rate of an edge is the power of two that
 * is nearest to the measured rate, so quads are between 0.7 and 1.4 times as long as requested. Both faces at an edge
 * get the higher of their two rates. If the cage has several time steps, the step that requires the highest rates
 * counts. Vertices that are not finite, and holes, are ignored.
 *
 * dicing: structSize is read.
 * rates:  written on success, one entry per index of the cage, or NULL.
 *
 * Returns CBVH_ERROR_INVALID_OPERATION if no cage was set since the last commit, and CBVH_ERROR_INVALID_ARGUMENT for
 * an invalid member, which the message names. After an error, the cage keeps its rates.
 *
 * For the surface of a geometry of type RTC_GEOMETRY_TYPE_SUBDIVISION (embree3/rtcore_surface.h), sets its level buffer
 * (RTC_BUFFER_TYPE_LEVEL); an existing one is replaced, not written to. The geometry must be committed since the last
 * change of its buffers, and again afterwards. Returns CBVH_ERROR_INVALID_OPERATION for a geometry of another type, for
 * a geometry that is not committed, that released its input or was loaded from a file, and if a time step has fewer
 * vertices than the first one; and CBVH_ERROR_INVALID_ARGUMENT also for faces with an index past the vertices. */
CBVH_API enum CbvhError cbvhDiceSurface(CbvhSurface surface, const struct CbvhDicingArguments* dicing, float* rates);

/* Sets the accuracy of all later commits. A commit without new input fails if the accuracy changed, because
 * the earlier commit released the input. The same values again, or values that are ignored, are no change.
 *
 * accuracy: structSize is read. NULL selects the defaults.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT if a bound is negative or not finite, or if maxPixelError is not 0 and the camera
 * is not finite or pixelSize is not positive. */
CBVH_API enum CbvhError cbvhSetSurfaceAccuracy(CbvhSurface surface, const struct CbvhAccuracy* accuracy);

/* Sets whether later commits are lossless. A lossless commit stores the exact vertices of grids and meshes, and of
 * cages the vertices that Embree evaluates, and ignores cbvhSetSurfaceAccuracy. A commit without new input fails if the
 * setting changed.
 *
 * lossless: 1 or 0, the default is 0.
 *
 * Returns CBVH_OK, or an error that all functions share. */
CBVH_API enum CbvhError cbvhSetSurfaceLossless(CbvhSurface surface, int lossless);

/* Sets the mask of a surface. A ray can hit the surface if its mask and the surface's mask have a common bit. By
 * default all bits are set. The mask takes effect with the next cbvhCommitGroup of a group that contains the
 * surface, and then in all groups that contain it: rays that trace another group meanwhile use the former mask or the
 * new one.
 *
 * Returns CBVH_OK, or an error that all functions share. */
CBVH_API enum CbvhError cbvhSetSurfaceMask(CbvhSurface surface, unsigned int mask);

/* Called with the completed fraction of a commit, 0 to 1, on any thread, and by several threads at the same time.
 * Returning 0 cancels the commit. Like a displacement function, it must not change its surface: functions that do so
 * return CBVH_ERROR_INVALID_OPERATION. */
typedef int (*CbvhProgressFunction)(void* userPtr, double done);

/* Tessellates and compresses a surface with all threads of the context, and releases its input. Does nothing if no
 * input was set since the last commit and the accuracy is unchanged. Rays of a group hit the new surface after the next
 * cbvhCommitGroup. Triangles with a vertex that is not finite are left out, in cGRID, cVOXEL and cLEAF their quads; so
 * are quads of a mesh with an index past the vertices. CbvhGroupStatistics counts quads, cbvhCommitGroup reports some.
 *
 * progress: may be NULL.
 * userPtr:  passed to the progress function.
 *
 * Returns CBVH_ERROR_CANCELLED if the progress function cancels. Returns CBVH_ERROR_INVALID_OPERATION if the surface
 * has no input, or if cbvhSetSurfaceAccuracy or cbvhSetSurfaceLossless changed it but no input was set again. Returns
 * CBVH_ERROR_INVALID_ARGUMENT if a grid of over 2^24 vertices has a stride of 0. The message states the reason. After
 * an error the surface is unchanged and keeps its input.
 *
 * Prints a warning on stderr for a crease between two vertices that share no edge. Such a crease has no effect. */
CBVH_API enum CbvhError cbvhCommitSurface(CbvhSurface surface, CbvhProgressFunction progress, void* userPtr);

/* Returns the number of primitives of the input that was set last, or of a loaded surface; 0 if there is none. */
CBVH_API unsigned int cbvhGetSurfacePrimitiveCount(CbvhSurface surface);

/* Evaluates an attribute of a cage at a hit. Grids, meshes and loaded surfaces have no attributes. If an attribute
 * contains the cage's vertices, the cross product of dPdu and dPdv is the smooth normal of the surface without
 * displacement.
 *
 * attribute:     index in CbvhCage::attributes.
 * primID, u, v:  face and parameters, as in hits. On a face with four corners, u and v are 0 to 1. Another face has a
 *                sub-patch for each corner: in sub-patch i + 4 j, with i from 0 to 3, u is 2 i + 0.5 to 2 i + 1.5, and
 *                v is 2 j + 0.5 to 2 j + 1.5.
 * P, dPdu, dPdv: the value and its derivatives, written. Each has as many floats as the attribute is wide, or is NULL.
 *
 * A displacement function may call it for its own surface during cbvhCommitSurface and cbvhDiceSurface. It then uses
 * the attributes of the cage that is displaced.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for an attribute, a face or parameters that the cage does not have, and
 * CBVH_ERROR_INVALID_OPERATION if the surface is not committed. */
CBVH_API enum CbvhError cbvhInterpolateAttribute(CbvhSurface surface, unsigned int primID, float u, float v,
                                                 unsigned int attribute, float* P, float* dPdu, float* dPdv);

/* Points on one face, for cbvhInterpolateAttributeAtPoints. */
struct CbvhInterpolationPoints {
  size_t structSize CBVH_SIZE_OF(CbvhInterpolationPoints);
  unsigned int primID CBVH_ZERO, attribute CBVH_ZERO;
  size_t count CBVH_ZERO;
  const float *u CBVH_ZERO, *v CBVH_ZERO;               /* parameters of the points, as for a displacement function */
  float *P CBVH_ZERO, *dPdu CBVH_ZERO, *dPdv CBVH_ZERO; /* written: count values of the attribute's width, without
                                                         * gaps. Each may be NULL */
};

/* Evaluates an attribute of a cage at many points of a face. Displacement functions use it to look up height maps,
 * because all points of one call are on the same face.
 *
 * points: structSize is read, and the arrays P, dPdu and dPdv are written.
 *
 * Returns errors as cbvhInterpolateAttribute. The message names the first point with invalid parameters; nothing is
 * written then. */
CBVH_API enum CbvhError cbvhInterpolateAttributeAtPoints(CbvhSurface surface,
                                                         const struct CbvhInterpolationPoints* points);

/* --- files: docs/formats/file.md specifies the format ------------------------------------------------ */

/* Saves a committed surface to a file. The file stores blocks, tree, time steps, primitive numbers and statistics. It
 * does not store the mask, the attributes and the control cage. Reads and writes all blocks. Rays may be traced during
 * the call.
 *
 * path: of the file. An existing file is replaced in one step after everything is written; it is unchanged if anything
 *       fails before. Symbolic links are followed, and permissions of the file are kept. A killed process leaves a file
 *       whose name continues with ".cbvh-part-" and 16 hexadecimal digits. The next save to the same path removes it,
 *       unless another process is still writing it.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for a path that cannot be written or that names a device or a pipe. Returns
 * CBVH_ERROR_INVALID_OPERATION if the surface is not committed, if writing fails, for example on a full disk or at a
 * limit of the file size, and for a surface from a file with a damaged block. For the surface of a geometry, also if
 * the geometry is not compressed or changed since its commit, and if it is compressed only in part, because GRID stores
 * the rest. SIGXFSZ does not reach the application. */
CBVH_API enum CbvhError cbvhSaveSurface(CbvhSurface surface, const char* path);

/* Loads the surface of a file with one surface. The surface is committed and has no input. The file is mapped: rays can
 * be traced at once, blocks that no ray visits stay on disk, and processes share the memory. Two surfaces of one file
 * in a process do not share it: put one surface into several groups instead. Hits are equal to the bit to hits of the
 * saved surface. While the surface exists, the file may be replaced or removed, but must not be written to or
 * truncated.
 *
 * context: retained by the surface. It need not have the settings of the context that saved the file.
 * path:    of a regular file.
 * surface: written on success.
 *
 * The file may have any representation of Embree CBVH. Surfaces in cLEAF and cVOXEL have no triangles. Parts in cGRID
 * have up to 256 x 256 quads, and neighboring parts share equal floats only inside of a face.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for files that do not exist, have another format or version, are truncated, have
 * a damaged header, directory or tree, or contain several surfaces; the message states the reason. Blocks of a surface
 * that moves are checked during the call, other blocks when a ray visits them for the first time: damaged ones are then
 * left out, and the first one is reported to the error function. cbvhVerifyFile checks everything. */
CBVH_API enum CbvhError cbvhLoadSurface(CbvhContext context, const char* path, CbvhSurface* surface);

typedef struct CbvhFileWriterTy* CbvhFileWriter;

/* Creates a writer for a file with any number of surfaces.
 *
 * context: retained by the writer.
 * path:    as for cbvhSaveSurface.
 * writer:  written on success.
 *
 * cbvhReleaseFileWriter frees the writer. It removes surfaces that were not committed; a writer of cbvhResumeFileWriter
 * keeps them.
 *
 * Returns errors as cbvhSaveSurface. */
CBVH_API enum CbvhError cbvhNewFileWriter(CbvhContext context, const char* path, CbvhFileWriter* writer);
CBVH_API void cbvhReleaseFileWriter(CbvhFileWriter writer);

/* Creates a writer that can be resumed after an interruption, for surfaces that take long to build.
 *
 * If the writer is released or the process ends before cbvhCommitFileWriter, the appended surfaces are kept next to the
 * file, under its path with ".part" appended. The next writer with the same path and key continues after them:
 * cbvhGetFileWriterSurfaceCount returns their number, and the application appends the remaining surfaces. A released
 * writer loses no surface. A killed process and a full disk lose the last surface and up to 64 MiB of surfaces before
 * it.
 *
 * key: number that identifies the input of the surfaces, so that files of different input are not mixed.
 *
 * Returns errors as cbvhNewFileWriter, and CBVH_ERROR_INVALID_ARGUMENT if the kept part has another key, is of another
 * version of the library or is damaged, and while another writer uses it. */
CBVH_API enum CbvhError cbvhResumeFileWriter(CbvhContext context, const char* path, unsigned long long key,
                                             CbvhFileWriter* writer);

/* Returns the number of surfaces in a writer, including those that a resumed writer continues after; 0 for NULL. */
CBVH_API size_t cbvhGetFileWriterSurfaceCount(CbvhFileWriter writer);

/* Appends a surface to a file. Its index in the file is the number of surfaces before it. The surface may be released
 * afterwards: an application can save a scene that is larger than memory while it builds it. After a surface that
 * cannot be saved, others can be appended. After a failed write nothing can be appended.
 *
 * Returns errors as cbvhSaveSurface, and CBVH_ERROR_INVALID_OPERATION for a writer that is committed, or whose earlier
 * write failed. */
CBVH_API enum CbvhError cbvhAppendSurface(CbvhFileWriter writer, CbvhSurface surface);

/* Completes a file: writes everything to disk and renames it to its path. If it fails, an existing file at this path is
 * unchanged.
 *
 * Returns CBVH_ERROR_INVALID_OPERATION for a writer without surfaces, to which surfaces can be appended afterwards, for
 * a writer that is committed or whose earlier write failed, and if writing fails. */
CBVH_API enum CbvhError cbvhCommitFileWriter(CbvhFileWriter writer);

typedef struct CbvhFileTy* CbvhFile;

/* Opens a file with any number of surfaces: maps it, and reads and checks its header and directory.
 *
 * context: of surfaces that are loaded from the file. Retained by the file.
 * path:    as for cbvhLoadSurface.
 * file:    written on success.
 *
 * cbvhReleaseFile frees the file. Surfaces that were loaded from it remain valid.
 *
 * Returns errors as cbvhLoadSurface, but several surfaces are no error. */
CBVH_API enum CbvhError cbvhOpenFile(CbvhContext context, const char* path, CbvhFile* file);
CBVH_API void cbvhReleaseFile(CbvhFile file);

/* Returns the number of surfaces in a file; 0 for NULL. */
CBVH_API size_t cbvhGetFileSurfaceCount(CbvhFile file);

/* Input that a surface was built from. */
enum CbvhSurfaceType {
  CBVH_SURFACE_TYPE_CAGE = 0,
  CBVH_SURFACE_TYPE_GRIDS = 1,
  CBVH_SURFACE_TYPE_QUADS = 2,
  CBVH_SURFACE_TYPE_TRIANGLES = 3
};

/* Representation of a surface. The values are those of RTCCompression in embree3/rtcore_compression.h. */
enum CbvhRepresentation {
  CBVH_REPRESENTATION_CGRID = 2,
  CBVH_REPRESENTATION_CVOXEL = 3,
  CBVH_REPRESENTATION_CLEAF = 4,
  CBVH_REPRESENTATION_CVERT = 5
};

/* Description of a surface in a file. */
struct CbvhFileSurfaceInfo {
  size_t structSize CBVH_SIZE_OF(CbvhFileSurfaceInfo);
  enum CbvhSurfaceType type CBVH_ZERO;
  enum CbvhRepresentation representation CBVH_ZERO;
  unsigned int numPrimitives CBVH_ZERO, numTimeSteps CBVH_ZERO;
  float startTime CBVH_ZERO, endTime CBVH_ZERO; /* times of the first and the last time step */
  float lower[3] CBVH_ZERO, upper[3] CBVH_ZERO; /* bounds at all times; lower is above upper if they are empty */
  size_t bytes CBVH_ZERO;                       /* of its tree and blocks in the file */
};

/* Returns the description of a surface in a file, without loading the surface.
 *
 * index: below cbvhGetFileSurfaceCount.
 * info:  written on success; structSize is read.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for an index out of range. */
CBVH_API enum CbvhError cbvhGetFileSurfaceInfo(CbvhFile file, size_t index, struct CbvhFileSurfaceInfo* info);

/* Statistics of a surface in a file, from its last commit. Sizes are in bytes, distances in units of the vertices. */
struct CbvhSurfaceStatistics {
  size_t structSize CBVH_SIZE_OF(CbvhSurfaceStatistics);
  size_t topLevelBytes CBVH_ZERO; /* full-precision BVH over blocks */
  size_t headerBytes CBVH_ZERO;   /* headers of all blocks */
  size_t nodeBytes CBVH_ZERO;     /* compressed inner nodes */
  size_t leafBytes CBVH_ZERO;     /* leaves: vertices or heights */
  size_t motionBytes CBVH_ZERO;   /* the part of leafBytes for all time steps but the first */
  size_t numBlocks CBVH_ZERO;
  size_t numRawBlocks CBVH_ZERO;      /* blocks that store floats */
  size_t numAffineBlocks CBVH_ZERO;   /* blocks that have an affine frame, because no projective frame was possible */
  size_t numSolidLeaves CBVH_ZERO;    /* cLEAF leaves whose box is the surface */
  size_t numQuads CBVH_ZERO;          /* quads in blocks; two triangles of a mesh count as a quad */
  size_t numInvalidQuads CBVH_ZERO;   /* quads that were left out, as in CbvhGroupStatistics */
  size_t numFallbackQuads CBVH_ZERO;  /* quads of a cLEAF surface that are stored as cVERT */
  size_t numFlippedQuads CBVH_ZERO;   /* quads whose stored normal differs from their vertices' normal by more than 90
                                       * degrees */
  size_t numMeshQuads CBVH_ZERO;      /* quads of quad meshes, plus pairs of triangles of triangle meshes */
  size_t numIrregularQuads CBVH_ZERO; /* those of numMeshQuads that are in no grid of at least 4 x 4 quads */
  size_t numMovingQuads CBVH_ZERO;    /* quads with several time steps */
  float maxLeafThickness CBVH_ZERO;   /* largest distance between the two bounds of a leaf */
  float maxVertexSpacing CBVH_ZERO;   /* largest spacing of a lattice */
  float maxVertexDeviation CBVH_ZERO; /* largest distance by which a vertex was moved */
  float maxBorderMismatch CBVH_ZERO;  /* largest distance between the vertices that two faces evaluate at the same
                                       * place; the stored surface has no such gap */
};

/* Returns the statistics of a surface in a file, without loading the surface.
 *
 * index:      below cbvhGetFileSurfaceCount.
 * statistics: written on success; structSize is read.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for an index out of range. */
CBVH_API enum CbvhError cbvhGetFileSurfaceStatistics(CbvhFile file, size_t index,
                                                     struct CbvhSurfaceStatistics* statistics);

/* Loads a surface of an open file, as cbvhLoadSurface does. Each call creates another surface. Several threads may load
 * surfaces of a file at the same time.
 *
 * index:   below cbvhGetFileSurfaceCount.
 * surface: written on success.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for an index out of range, and for a surface that is damaged or that the library
 * does not support. */
CBVH_API enum CbvhError cbvhLoadFileSurface(CbvhFile file, size_t index, CbvhSurface* surface);

/* Reads a whole file, checks all blocks and compares the checksums. Takes as long as reading the file from disk.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT for a damaged file; the message describes the damage. */
CBVH_API enum CbvhError cbvhVerifyFile(CbvhFile file);

/* --- groups: surfaces that are traced together ----------------------------------------- */

typedef struct CbvhGroupTy* CbvhGroup;

/* Creates a group of surfaces, and retains them. A surface may be in several groups.
 *
 * context:  of all surfaces.
 * surfaces: array of `count` surfaces, at least 1. The index of a surface in the array is the geomID of its hits.
 * group:    written on success.
 *
 * cbvhRetainGroup and cbvhReleaseGroup add and remove a reference.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT if there are no surfaces, or if a surface is NULL or belongs to another
 * context. */
CBVH_API enum CbvhError cbvhNewGroup(CbvhContext context, const CbvhSurface* surfaces, size_t count, CbvhGroup* group);
CBVH_API void cbvhRetainGroup(CbvhGroup group);
CBVH_API void cbvhReleaseGroup(CbvhGroup group);

/* Builds the tree of a group from the last commits of its surfaces. Call it before the first ray, and after commits of
 * surfaces. The tree refers to the blocks of the surfaces and copies none of them.
 *
 * Returns CBVH_ERROR_INVALID_OPERATION if a surface was never committed. The group is then unchanged.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT, once per group and commit of a surface, in three cases: a control vertex of a
 * cage, or a vertex that a displacement function returned, is not finite; a grid has vertices outside of its buffer;
 * faces were left out because they, or faces at their vertices, have more than 16 corners, or because one of their
 * vertices has more than 1024 faces, or 1023 at a border, or fewer if these have more than 4 corners. The message names
 * the surface ("geometry" and its index) and the first face or grid, or the number of faces. The rest of the group is
 * committed and can be traced.
 *
 * Vertices of grids and meshes that are not finite are no error, because heights use them for missing samples.
 * CbvhGroupStatistics counts the quads that they leave out, and names the first one. */
CBVH_API enum CbvhError cbvhCommitGroup(CbvhGroup group);

/* Return the number of surfaces of a group, and one of them, or NULL for an index out of range. The surface is not
 * retained: call cbvhRetainSurface if it must outlive the group. */
CBVH_API size_t cbvhGetGroupSurfaceCount(CbvhGroup group);
CBVH_API CbvhSurface cbvhGetGroupSurface(CbvhGroup group, size_t index);

/* Set and return a pointer that the application stores with a group. It is NULL at first. The library does not use
 * it. */
CBVH_API void cbvhSetGroupUserPtr(CbvhGroup group, void* userPtr);
CBVH_API void* cbvhGetGroupUserPtr(CbvhGroup group);

/* Number the primitives of all surfaces of a committed group consecutively.
 *
 * cbvhGetGroupFirstPrimitive returns the number of the first primitive of a surface. For the index
 * cbvhGetGroupSurfaceCount it returns the count of all primitives, and 0 for larger indices. It returns at most
 * 4294967295.
 *
 * cbvhFindGroupPrimitive writes the index of the surface and the primitive of a number and returns 1, or returns 0
 * if no primitive has this number. It searches in the surfaces by bisection.
 *
 * In a group that is not committed, both functions return 0. */
CBVH_API unsigned int cbvhGetGroupFirstPrimitive(CbvhGroup group, size_t index);
CBVH_API int cbvhFindGroupPrimitive(CbvhGroup group, unsigned int number, size_t* index, unsigned int* primID);

/* Checks whether a group can become a geometry of Embree. cbvhNewGeometry in cbvh/embree.h calls this function.
 *
 * group: committed; the function does not check this.
 * flags: of the geometry.
 * known: all bits of flags that the caller supports.
 *
 * Returns CBVH_ERROR_INVALID_ARGUMENT if other bits are set, and CBVH_ERROR_INVALID_OPERATION if the group has 2^32 - 1
 * primitives or more, which the primID of a hit cannot count. The message states the reason. */
CBVH_API enum CbvhError cbvhCheckGeometry(CbvhGroup group, unsigned int flags, unsigned int known);

/* Returns the bounds of a group at all times from 0 to 1: x, y, z. lower is above upper if the group is empty, not
 * committed or NULL.
 *
 * lower, upper: written, or NULL. */
CBVH_API void cbvhGetGroupBounds(CbvhGroup group, float lower[3], float upper[3]);

/* An index that does not exist. */
#define CBVH_NONE ((size_t)-1)

/* Memory and size of a group. */
struct CbvhGroupStatistics {
  size_t structSize CBVH_SIZE_OF(CbvhGroupStatistics);
  size_t bytes CBVH_ZERO;                 /* memory of the tree and all blocks, including blocks that groups share,
                                           * without the attributes of cages */
  size_t numQuads CBVH_ZERO;              /* of the tessellation; two triangles of a mesh count as a quad */
  size_t numMovingQuads CBVH_ZERO;        /* quads with several time steps */
  size_t numInvalidQuads CBVH_ZERO;       /* quads with a vertex that is not finite, or with an index of a mesh past the
                                           * vertices, which were left out as a whole or in part */
  float maxVertexDeviation CBVH_ZERO;     /* world units: largest distance by which a vertex was moved */
  size_t firstInvalidSurface CBVH_ZERO;   /* if numInvalidQuads is not 0: index of the first surface with such quads
                                           * that was not loaded from a file, or CBVH_NONE */
  size_t firstInvalidPrimitive CBVH_ZERO; /* its first face, grid, quad or triangle with such quads, or CBVH_NONE */
};

/* Returns the statistics of the last commit of a group, which the commit computed.
 *
 * statistics: written on success; structSize is read.
 *
 * Returns CBVH_ERROR_INVALID_OPERATION if the group is not committed. */
CBVH_API enum CbvhError cbvhGetGroupStatistics(CbvhGroup group, struct CbvhGroupStatistics* statistics);

/* --- rays -------------------------------------------------------------------------------- */

/* The layout of RTCRay and RTCHit of Embree 3 and 4, without the last member of Embree 4's RTCHit. Aligned to 16
 * bytes. Distances are in lengths of the direction, which may be 1e-20 to 1e18. */
struct CBVH_ALIGNED CbvhRay {
  float org_x, org_y, org_z, tnear; /* tnear: smallest distance of hits, not negative */
  float dir_x, dir_y, dir_z, time;  /* time: 0 to 1, for surfaces that move, otherwise ignored. Rays at other times may
                                     * miss */
  float tfar;                       /* largest distance of hits, may be infinite. A ray with a negative tfar is not
                                     * traced */
  unsigned int mask;                /* see cbvhSetSurfaceMask */
  unsigned int id, flags;           /* not read. Filter functions receive them */
};

struct CBVH_ALIGNED CbvhHit {
  float Ng_x, Ng_y, Ng_z;              /* normal of the triangle, of any length */
  float u, v;                          /* parameters on the primitive */
  unsigned int primID, geomID, instID; /* geomID: index of the surface in its group. instID: not written */
};

struct CBVH_ALIGNED CbvhRayHit {
  struct CbvhRay ray;
  struct CbvhHit hit;
};

/* Arguments of a filter function, which accepts or rejects hits. rays, hits: in the layout of RTCRayN and RTCHitN for
 * `count` rays: word i + count*m is member m of ray i, with all members of CbvhRay and CbvhHit in order, 4 bytes each.
 * tfar of a ray is the distance of its hit. valid: -1 for each hit, otherwise 0; the function sets it to 0 to reject
 * the hit. As in Embree, the function may change Ng, u, v and primID of a hit that it accepts, and decrease tfar. It
 * must not change anything else. It may trace other rays. */
struct CbvhFilterArguments {
  int* valid;
  void* userPtr; /* the filterUserPtr of the query */
  void *rays, *hits;
  unsigned int count;
};
typedef void (*CbvhFilterFunction)(const struct CbvhFilterArguments* args);

enum CbvhQueryFlags {
  CBVH_QUERY_FLAG_COHERENT = 1 /* the rays of a packet have similar origins and directions */
};

/* Options of a query. */
struct CbvhQuery {
  size_t structSize CBVH_SIZE_OF(CbvhQuery);
  unsigned int flags CBVH_ZERO;        /* bits of CbvhQueryFlags, all others 0 */
  CbvhFilterFunction filter CBVH_ZERO; /* called on the tracing thread. NULL: every hit counts */
  void* filterUserPtr CBVH_ZERO;       /* passed to the filter function */
};

/* Find closest hits. If a ray hits a surface at a distance from tnear to tfar, tfar becomes this distance, and the hit
 * is written. All other members are unchanged.
 *
 * cbvhIntersect1 returns 1 if the ray hits, otherwise 0. The packet functions return one bit per ray, bit 0 for the
 * first one.
 *
 * group: committed. If it never was, functions that trace rays call the error function and return 0.
 * ray:   read and written, aligned to 16 bytes.
 * valid: one entry per ray: -1 for rays that are traced, otherwise 0, with the alignment of the rays. NULL traces all
 *        rays.
 * rays:  a packet in the layout of Embree's RTCRayHit4, 8 or 16, aligned to 16, 32 or 64 bytes.
 * query: NULL selects the defaults.
 *
 * If structSize or flags of the query are invalid, functions that trace rays call the error function, trace nothing and
 * return 0. If the group or the rays are NULL, they return 0. */
CBVH_API int cbvhIntersect1(CbvhGroup group, struct CbvhRayHit* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhIntersect16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* Test for any hit: tfar becomes -infinity if a ray hits. Results and arguments are as for the cbvhIntersect functions,
 * but packets have the layout of RTCRay4, 8 and 16. Rays whose tfar is negative before the call have no bit in the
 * result. */
CBVH_API int cbvhOccluded1(CbvhGroup group, struct CbvhRay* ray, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded4(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded8(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);
CBVH_API unsigned int cbvhOccluded16(CbvhGroup group, const int* valid, void* rays, const struct CbvhQuery* query);

/* --- rays of a geometry: for bindings of Embree, such as cbvh/embree.h --------------------- */

/* Called with one hit of a geometry, which it accepts or rejects. ray, hit: an RTCRay and an RTCHit of the
 * application's Embree, with the IDs of its scene. valid: -1; the function sets it to 0 to reject the hit. The function
 * may change Ng, u, v and primID of a hit that it accepts, and decrease tfar; other changes have no effect. */
typedef void (*CbvhGeometryFilterFunction)(void* userPtr, int* valid, void* ray, void* hit);

/* Arguments of a callback that Embree calls for rays that enter the bounds of a geometry. */
struct CbvhGeometryQuery {
  CbvhGroup group;
  const int* valid;                  /* one entry per ray: -1 for rays that are traced, otherwise 0 */
  void* rays;                        /* RTCRayHitN or, for occlusion, RTCRayN of the application's Embree */
  unsigned int N;                    /* number of rays */
  unsigned int flags;                /* bits of CbvhQueryFlags, all others 0 */
  unsigned int geomID;               /* written to hits */
  unsigned int numLevels;            /* of instances, 1 to 32: RTC_MAX_INSTANCE_LEVEL_COUNT */
  const unsigned int* instIDs;       /* one entry per level, written to hits */
  const unsigned int* instPrimIDs;   /* the same; NULL if hits of the application's Embree have no such member */
  CbvhGeometryFilterFunction filter; /* NULL: every hit counts */
  void* filterUserPtr;               /* passed to the filter function */
};

/* Trace rays of the application's Embree through a group, as its callbacks for user geometry must: closest hits with
 * the IDs of its scene, or any hit. The primIDs of hits number the primitives of all surfaces of the group
 * consecutively. Packets of 4, 8 and 16 rays that are coherent are traced as such. If the query or the group is NULL,
 * or numLevels is above 32, the functions trace nothing. */
CBVH_API void cbvhIntersectGeometry(const struct CbvhGeometryQuery* query);
CBVH_API void cbvhOccludedGeometry(const struct CbvhGeometryQuery* query);

/* --- closest points ----------------------------------------------------------------------- */

/* A point of a stored triangle. */
struct CbvhClosestPoint {
  float x, y, z;
  float distance;              /* from the query's point */
  float Ng_x, Ng_y, Ng_z;      /* normal of the triangle as in CbvhHit, of any length */
  float u, v;                  /* parameters on the primitive */
  unsigned int primID, geomID; /* geomID: index of the surface in its group */
};

/* Arguments of a function that is called for the closest point of each triangle within the radius of a query. */
struct CbvhPointFunctionArguments {
  void* userPtr; /* of the query */
  const struct CbvhClosestPoint* point;
  float radius; /* of the query now. The function may decrease it */
};

/* Returns 1 to accept a point: the radius becomes its distance, so that only closer points follow. Returns 0 to ignore
 * it: a function that always returns 0 visits all triangles within the radius, nearby ones first in general. It may
 * trace rays and start other queries. */
typedef int (*CbvhPointFunction)(struct CbvhPointFunctionArguments* args);

/* A query for the closest point. */
struct CbvhPointQuery {
  size_t structSize CBVH_SIZE_OF(CbvhPointQuery);
  float x CBVH_ZERO, y CBVH_ZERO, z CBVH_ZERO;
  float time CBVH_ZERO;                 /* 0 to 1, for surfaces that move, otherwise ignored */
  float radius CBVH_ZERO;               /* largest distance, may be infinite */
  CbvhPointFunction function CBVH_ZERO; /* called on the querying thread. NULL: every point is accepted */
  void* userPtr CBVH_ZERO;              /* passed to the function */
};

/* Finds the point of a group that is closest to a given point, on the triangles that are stored (see below), at a
 * distance of at most the radius. Masks of surfaces are not used. Distances are computed in double precision. Of
 * several triangles that are equally close, it reports one with the least geomID, always the same, on every
 * instruction set. Only triangles with three different, finite vertices are found.
 *
 * group:   committed.
 * query:   read.
 * closest: written if a point was found, or NULL.
 *
 * Returns 1 if a point was found and accepted, otherwise 0.
 *
 * Errors, for which the error function is called: CBVH_ERROR_INVALID_ARGUMENT for coordinates that are not in -1e18 to
 * 1e18, and for a radius that is negative or NaN; CBVH_ERROR_INVALID_OPERATION if the group was never committed, and
 * if a surface within the radius has no triangles, in which case the result is 0. Thread safety: as rays. */
CBVH_API int cbvhPointQuery(CbvhGroup group, const struct CbvhPointQuery* query, struct CbvhClosestPoint* closest);

/* --- access to stored triangles ----------------------------------------------------------
 *
 * Only cTILE, cVERT and cGRID store triangles. Surfaces of cbvhCommitSurface have them. Functions of this section, and
 * cbvhForEachCluster, fail with CBVH_ERROR_INVALID_OPERATION for others: a surface from a file of another
 * representation, and a surface of a geometry that is not compressed, or whose parts are not all stored as one of
 * these. So does cbvhPointQuery, also for cGRID. */

/* A stored triangle. */
struct CbvhTriangle {
  float vertices[3][3]; /* x, y, z */
  float u[3], v[3];     /* parameters of the vertices on the primitive; u and v of hits are interpolated from
                         * them */
};

/* Finds the triangle of a hit. The first call after a commit builds an index with 16 bytes per block; for meshes it has
 * 4 more bytes per primitive.
 *
 * surface:      committed.
 * time:         of the ray. Ignored for a surface that does not move.
 * primID, u, v: of the hit.
 * Ng:           of the hit, 3 floats. It selects between triangles if (u,v) lies on their common edge. NULL selects
 *               any.
 * triangle:     written if a triangle is found. The quads of cages and grids have the triangles of CbvhPart. Triangles
 *               of meshes have the vertex order of the primitive: a quad has the triangles v0, v1, v3 and v2, v3, v1.
 *
 * Returns 1 if (u,v) is on a triangle of the primitive. Returns 0 for an unknown primID, where triangles were left out,
 * outside of the time range, and on errors. The error function is called if the surface is not committed or has no
 * triangles, or if its file has a damaged block. */
CBVH_API int cbvhFindTriangle(CbvhSurface surface, float time, unsigned int primID, float u, float v, const float* Ng,
                              struct CbvhTriangle* triangle);

/* Finds the point of a primitive that is closest to a given point. Meant for functions that rtcPointQuery calls:
 * cbvhPointQuery finds the closest point of all primitives, and is faster. The first call after a commit builds the
 * index of cbvhFindTriangle.
 *
 * surface: committed.
 * time:    0 to 1. Ignored for a surface that does not move.
 * p:       3 floats.
 * radius:  largest distance, may be infinite.
 * closest: written if a point is found. geomID is 0.
 *
 * Returns 1 if a triangle of the primitive is within the radius. Returns 0 otherwise, for an unknown primID, outside of
 * the time range, and on errors, for which the error function is called: those of cbvhFindTriangle and, for p and
 * radius, of cbvhPointQuery. */
CBVH_API int cbvhFindClosestPoint(CbvhSurface surface, float time, unsigned int primID, const float p[3], float radius,
                                  struct CbvhClosestPoint* closest);

/* A part of a surface: a grid of up to 16 x 16 quads, with cGRID up to 256 x 256. Quad (x,y) has the triangles (x,y),
 * (x+1,y), (x,y+1) and (x,y+1), (x+1,y), (x+1,y+1). Vertices that neighboring parts share are equal floats, with cGRID
 * only inside of a face.
 *
 * An irregular quad or triangle of a mesh is a part of its own: a grid of 2 x 2 vertices, in which the second triangle,
 * or the first one, may be missing. A missing triangle has two equal vertices. */
struct CbvhPart {
  unsigned int primID;            /* primitive of all quads, if primitivesPerQuad is 0 */
  unsigned int width, height;     /* in vertices */
  const float* vertices;          /* x, y, z of each vertex, row by row. Triangles with a NaN are left out */
  const float* parameters;        /* u, v of each vertex; NULL if primitivesPerQuad is not 0 */
  const unsigned int* primIDs;    /* row by row, primitivesPerQuad entries per quad; NULL if that is 0 */
  unsigned int primitivesPerQuad; /* 0: cages and grids. 1: meshes of quads. 2: meshes of triangles; the second
                                   * primitive is the first one again if the quad has one triangle */
};

/* Called with a part, which is valid until the function returns. Returning 0 ends the enumeration. */
typedef int (*CbvhPartFunction)(void* userPtr, const struct CbvhPart* part);

/* Calls a function for all parts of a surface at a time, on the calling thread, in unspecified order. Each part is
 * decoded when it is passed: the function needs no memory for the whole surface.
 *
 * surface:  committed.
 * time:     of rays. Ignored for a surface that does not move. Outside of the time range there are no parts.
 * function: not NULL.
 * userPtr:  passed to the function.
 *
 * Returns CBVH_OK also if the function ends the enumeration. Returns CBVH_ERROR_INVALID_OPERATION if the surface is not
 * committed or has no triangles, or if its file has a damaged block. */
CBVH_API enum CbvhError cbvhForEachPart(CbvhSurface surface, float time, CbvhPartFunction function, void* userPtr);

/* --- clusters that GPUs read: docs/formats/clusters.md describes them and names the specifications ---- */

enum CbvhClusterFormat {
  CBVH_CLUSTER_FORMAT_FLOAT3 = 0,      /* x, y, z of each vertex as floats */
  CBVH_CLUSTER_FORMAT_COMPRESSED1 = 1, /* header and vertices of D3D12_VERTEX_FORMAT_COMPRESSED1 (DirectX Raytracing),
                                        * padded to a multiple of 4 bytes */
  CBVH_CLUSTER_FORMAT_DGF1 = 2         /* a block of 128 bytes of AMD's Dense Geometry Format, including the topology */
};

/* Reason why a cluster stores floats instead of the requested format. */
enum CbvhClusterReason {
  CBVH_CLUSTER_REASON_NONE = 0,        /* the cluster has the requested format */
  CBVH_CLUSTER_REASON_FLOATS = 1,      /* the block stores floats, as all of cGRID, or more than 14 bits on an axis,
                                        * and no lattice of the format represents these vertices */
  CBVH_CLUSTER_REASON_MOVING = 2,      /* the vertices are interpolated between two time steps, not on a lattice, or
                                        * belong to a moving mesh block */
  CBVH_CLUSTER_REASON_OUT_OF_RANGE = 3 /* the vertices are over 2^23 spacings from the origin, the cluster is over 2^16
                                        * spacings wide, or the spacing is below 2^-126 */
};

/* A cluster: up to 8 x 8 quads with 81 vertices and 128 triangles; for DGF up to 32 quads with 64 of both. */
struct CbvhCluster {
  enum CbvhClusterFormat format; /* of data: the requested format, or CBVH_CLUSTER_FORMAT_FLOAT3 */
  enum CbvhClusterReason reason;
  unsigned int numVertices, numTriangles;
  const void* data;             /* aligned to 4 bytes */
  size_t bytes;                 /* of data */
  const unsigned char* indices; /* three vertices for each triangle; with DGF in the order in which a decoder emits
                                 * them */
  const unsigned int* triangleNumbers; /* number in the part of each triangle: 2 ((width-1) y + x) for the first
                                        * triangle of quad x, y, and 1 more for its second */
  unsigned int firstTriangle;  /* number of triangles in all clusters before. With DGF the primitive indices of the
                                * block start here */
  unsigned int width, height;  /* in vertices, row by row, if the cluster is a complete grid: all clusters of this
                                * size have the same indices. 0, 0 otherwise and with DGF */
  const struct CbvhPart* part; /* the part that contains the cluster: parameters and primIDs */
};

/* Totals over clusters. */
struct CbvhClusterStatistics {
  size_t structSize CBVH_SIZE_OF(CbvhClusterStatistics);
  size_t numClusters CBVH_ZERO, numTriangles CBVH_ZERO;
  size_t numVertices CBVH_ZERO;             /* shared vertices count once for each cluster */
  size_t bytes CBVH_ZERO;                   /* of data */
  size_t indexBytes CBVH_ZERO;              /* of the indices of clusters that are not complete grids, 3 bytes per
                                             * triangle. 0 for DGF, whose blocks contain indices */
  size_t numClustersByReason[8] CBVH_ZERO;  /* index: a CbvhClusterReason. Other entries are 0 */
  size_t numTrianglesByReason[8] CBVH_ZERO; /* the same */
};

/* Called with a cluster, which is valid until the function returns. Returning 0 ends the enumeration. */
typedef int (*CbvhClusterFunction)(void* userPtr, const struct CbvhCluster* cluster);

/* Calls a function for all clusters of a surface at a time, on the calling thread. The order is the same for each call.
 * Each block is decoded when its clusters are passed.
 *
 * Vertices are not rounded: a decoder of the format returns the floats that rays hit, except that -0 becomes 0. There
 * are no cracks between clusters, with cGRID inside of a face. Triangles with a vertex that is not finite, or with two
 * equal vertices, are left out, because no ray hits them. Clusters that the format cannot represent have floats, and
 * their reason is set.
 *
 * surface:    committed.
 * time:       of rays. Ignored for a surface that does not move. At a time step, vertices are on their lattice.
 * format:     of the clusters.
 * function:   NULL if only the statistics are needed.
 * userPtr:    passed to the function.
 * statistics: totals over the clusters that were passed, or NULL; structSize is read. Written on success, and if an
 *             error ends the enumeration.
 *
 * Returns CBVH_OK also if the function ends the enumeration. Returns CBVH_ERROR_INVALID_ARGUMENT for an unknown format.
 * Returns CBVH_ERROR_INVALID_OPERATION if the surface is not committed or has no triangles, if its file has a damaged
 * block, or if it has more than 2^32 triangles, or more than the 29-bit primitive indices of DGF can count. */
CBVH_API enum CbvhError cbvhForEachCluster(CbvhSurface surface, float time, enum CbvhClusterFormat format,
                                           CbvhClusterFunction function, void* userPtr,
                                           struct CbvhClusterStatistics* statistics);

#if defined(__cplusplus)
}
#endif

#endif
