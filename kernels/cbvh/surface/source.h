// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Source and Patch: the interface between an application's input (a cage, grids or a mesh) and the builder of blocks. A
 * source enumerates the primitives of a geometry: its faces or grids, or regions of a mesh that form grids. A patch is
 * a rectangle of quads of a primitive. A source is a template parameter of SourceBuilder (building/surface_builder.h),
 * a patch of VertWriter::write() (exact/writer.h). paper/writer.h writes only patches of cages. isSource<S>() checks a
 * source at compile time. CageSource and GridSource (building/) are sources; tests/library/sphere_source.h is a short
 * example.
 *
 * UNITS. Positions are floats in object space. Quads and rates are counts. A lattice is the exponent of its spacing
 * (cvert/encoder/lattice.h). Time steps are numbered from 0 to plan.numTimeSteps-1.
 *
 * SIDES are numbered around the patch: v = 0, u = 1, v = 1, u = 0. Vertices of a side are counted in that direction.
 *
 * THREADS. The builder constructs a source, and calls prepare() and release(), on one thread at a time. prepare() may
 * use all threads. Between prepare() and release(), threads call const members concurrently. Scratch and Writer, and
 * the patches made with them, belong to one task.
 *
 * ERRORS. Members may throw rtcore_error, std::bad_alloc, or what progress() throws. The build then ends, and the
 * geometry remains without blocks. Vertices that are not finite are no error: writers omit and count their quads.
 *
 * PATCH. A class derived from SurfacePatch, below. Its constructor sets the members of SurfacePatch. It also has:
 *
 *   Patch (const Patch& other, Scratch& scratch)
 *       The same patch for another task. `other` outlives it. Several tasks may copy `other` at the same time.
 *   PatchVertices& evaluate (unsigned quadsX, unsigned quadsY, const PatchPart& part, unsigned step)
 *       Evaluates a part of the patch at a time step. quadsX, quadsY: size of the whole patch. Writers of blocks with
 *       frames may pass more than `quads`; the builder and VertWriter pass `quads`. Returns the displaced vertices, row
 *       by row, and the undisplaced vertices if a writer of blocks with frames reads the patch. Edges of a lower rate
 *       are stitched as in Embree. The result is valid until the next call with the same scratch, and the caller may
 *       overwrite it.
 *   Side side (int s, unsigned step) const
 *       The vertices along a side, the same for all primitives that share it, by the rule in shared_border.h. A Side
 *       has `unsigned rate`, at most the patch's quads there, and `SharedVertex operator[] (unsigned k) const` for k of
 *       0 to rate.
 *   int latticeExponent (unsigned step) const
 *       Exponent of the lattice of the vertices that the patch does not share, or losslessExponent if they are not
 *       rounded.
 *
 * SOURCE. A class with
 *
 *   typedef Patch, Scratch; class Writer
 *       Scratch is the memory of a task, constructed from a Device*. It may be a PatchVertices.
 *   static const bool isDeterministic
 *       True if evaluating a vertex again returns the same floats. Otherwise the builder evaluates rows that two tasks
 *       share once for both.
 *   Source (Mesh* mesh, const CompressionPlan& plan)
 *       Both outlive the source. Mesh is the type that SourceBuilder is constructed with, a CompressibleGeometry.
 *   size_t size () const
 *       Number of primitives, at most 2^32, because blocks store their numbers in 32 bits. May be called before
 *       prepare().
 *   size_t estimateBlocks () const
 *       Rough number of blocks, by which the builder divides work and reserves memory. May be called before prepare().
 *   size_t perTask (bool isSmall) const
 *       Primitives per task, at least 1. isSmall: one task should write all of the few blocks. May be called before
 *       prepare().
 *   void prepare (size_t perTask, const Progress& progress)
 *       Computes what is needed of all primitives before any of them is written: lattices and shared vertices.
 *       Calls progress(0.0), which may throw to cancel, from time to time, also from several threads at once.
 *   void release ()
 *       Frees what prepare() allocated. No patch is used afterwards.
 *   void forEachPatch (size_t primitive, Scratch& scratch, const Closure& closure) const
 *       Calls closure(Patch&) for the patches of a primitive, always in the same order; for none if it cannot be
 *       evaluated. A patch is valid during its call.
 *   bool isInvalid (size_t primitive, bool hasInvalidQuads) const
 *       True if the commit should report the primitive as invalid. hasInvalidQuads: a writer left out quads of it.
 *   size_t quadsWithoutSurface (size_t primitive) const
 *       Quads of a primitive that has no patches because its input is not finite. 0 for other primitives.
 *   cbvh::InvalidVertex invalidVertex (size_t primitive) const
 *       A vertex of the input that is not finite, the reason why a primitive is invalid, if there is one.
 *   bool isUnsupported (size_t primitive) const
 *       True if the primitive has no patches because Embree cannot evaluate it. It is counted; this is not an error.
 *   size_t bytesInEmbree (const SurfacePatch& patch) const
 *       Estimated bytes that Embree's own representation of the patch needs, with all time steps, for the line that
 *       reports a commit.
 *   Writer (const Source& source, BlockStore& store, cbvh::BuildStatistics& statistics)
 *       Writes the patches of a task in order, appends blocks to the store and counts them. The arguments outlive it.
 *   bool Writer::write (size_t primitive, Patch& patch)
 *       Writes the blocks of a patch. Returns false, and writes nothing, if the patch has so many rows that the builder
 *       should divide it into strips, which tasks write as cVERT.
 *   const StoredBorders& storedBorders () const
 *       Optional: vertices that primitives in mesh blocks share with the source's patches (irregular_triangles.h).
 *       Valid from prepare() to release(). */

#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../../cvert/encoder/prim_id_encoder.h"
#include "plan.h"
#include "shared_border.h"
#include <functional>
#include <utility>

namespace embree::isa {
/*! Quads per side from which a mesh's grid is regular. Statistics count quads of narrower grids as irregular,
 *  whether they are stored in grids or mesh blocks. */
static const unsigned minGridSide = 4;

struct SurfacePatch {
  uint32_t surfaceNumber; //!< see base/surface_ids.h
  unsigned primID;        //!< number of the primitive in its source; not stored if the patch has `numbers`
  unsigned corner[2];     //!< primitive's parameters at the patch's corner, times 2
  unsigned quads[2];      //!< along u and v: higher rate of the two edges
  const float* rate;      //!< integer rates of the four sides; must outlive the patch
  const cbvh::QuadNumbers* numbers = nullptr; //!< primitive numbers of the quads; null if all have primID
};

/*! True if S is a source. Otherwise the compiler reports the line of isSource() whose member is missing. Does not check
 *  the constructor from (Mesh*, const CompressionPlan&), because Mesh is unknown. */
template<typename S>
constexpr bool isSource() {
  using Patch = typename S::Patch;
  // uses all members as builder and writers do; never called
  [[maybe_unused]] const auto use = [](S& source, Device* device, Patch& patch, BlockStore& store,
                                       cbvh::BuildStatistics& statistics, const std::function<void(double)>& progress) {
    typename S::Scratch scratch(device);
    const Patch copy(std::as_const(patch), scratch);
    const SurfacePatch& surfacePatch = copy;
    PatchVertices& vertices = patch.evaluate(1u, 1u, PatchPart(), 0u);
    const unsigned rate = copy.side(0, 0u).rate;
    const SharedVertex vertex = copy.side(0, 0u)[0u];
    const int lattice = copy.latticeExponent(0u);

    const S& prepared = source;
    source.prepare(size_t(1), progress);
    prepared.forEachPatch(size_t(0), scratch, [](Patch&) {});
    source.release();
    const size_t counts[] = {prepared.size(), prepared.estimateBlocks(), prepared.perTask(true),
                             prepared.quadsWithoutSurface(size_t(0)), prepared.bytesInEmbree(surfacePatch)};
    const cbvh::InvalidVertex invalid = prepared.invalidVertex(size_t(0));
    typename S::Writer writer(prepared, store, statistics);
    const bool flags[] = {S::isDeterministic, prepared.isInvalid(size_t(0), true), prepared.isUnsupported(size_t(0)),
                          writer.write(size_t(0), patch)};
    (void)vertices, (void)rate, (void)vertex, (void)lattice, (void)counts, (void)invalid, (void)flags;
  };
  return true;
}
} // namespace embree::isa
