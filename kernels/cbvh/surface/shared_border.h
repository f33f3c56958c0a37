// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The rule of shared borders, which makes cVERT surfaces and fallback faces watertight.
 *
 * The primitives of a geometry, faces or grids, share edges and corners. Each evaluates its own vertices there, on its
 * own lattice, so rays would pass between them. Therefore all primitives store the same floats there:
 *
 * 1. Owner. Each primitive at a shared edge or corner has a claim (claimOf): its rate along the edge, 0 at a corner,
 *    then a unique number. The primitive with the smallest claim is the owner. All primitives use its positions.
 * 2. Rate. An edge has the lowest rate of its primitives. A primitive with more vertices is stitched to it: each of its
 *    vertices moves to a vertex of the edge.
 * 3. Lattice. A shared vertex is on the coarsest lattice of its primitives (border_lattices.h). It is a point of all of
 *    these lattices, because they are nested.
 * 4. Vertices on an edge. If an application moved vertices of a fine grid onto the edges of a coarse one, they are
 *    stored on the stored edges, and on no lattice, unless that moves them farther than max_error
 *    (stitched_vertices.h).
 * 5. Values that are not finite. A primitive uses its own vertex if its own or the owner's position is not finite. So
 *    such a value only removes quads of the primitive that evaluates it.
 * 6. Time. Owners, rates and the choice of shared vertices are the same at all time steps. Positions and lattices are
 *    not.
 *
 * Grids need no owner and no common rate, because shared vertices are equal floats (grid_borders.h). For cages,
 * cage_topology.h finds owners and rates, and cage_borders.h evaluates the owned vertices. */

#include "../base/build_statistics.h"
#include "../base/codec_names.h"
#include "../../cvert/encoder/lattice.h"
#include "../../cvert/format/block.h"
#include "patch_vertices.h"

namespace embree::isa {
struct SharedVertex {
  float position[3]; //!< the owner's position; for grids the common position
  float stored[3];   //!< where all primitives store it
  int exponent;      //!< exponent of its lattice, or losslessExponent

  SharedVertex() {}

  /*! Rounds p to a lattice. */
  SharedVertex(const float p[3], int exponent) : position{p[0], p[1], p[2]}, exponent(exponent) {
    const cbvh::WorldLattice lattice(exponent);
    for (int k = 0; k < 3; k++) stored[k] = lattice.snap(p[k]);
  }

  /*! A vertex that is stored at a point of a stored edge. */
  SharedVertex(const float p[3], const cbvh::Double3& point)
    : position{p[0], p[1], p[2]},
      stored{float(point.x), float(point.y), float(point.z)},
      exponent(cbvh::losslessExponent) {}
};

/*! Encodes a claim (part 1 of the rule) as an integer. rate: the claiming primitive's own rate along the edge;
 *  0 for a corner, whose owner is independent of rates. number: unique among the claims. */
inline uint64_t claimOf(unsigned rate, uint32_t number) { return uint64_t(rate) << 32 | number; }

/*! Returns the first vertex of a border of `fine` quads that cvert::stitchedVertex, like Embree's stitch(), moves
 *  to vertex k of an edge of rate `coarse`. It is also the vertex nearest to k. */
inline unsigned firstStitched(unsigned k, unsigned fine, unsigned coarse) {
  return (2 * k * fine + coarse - 1) / (2 * coarse);
}

/*! Returns the vertex of an edge at rate `own` that is nearest to vertex k of the same edge at a lower or equal
 *  rate. */
inline unsigned nearestVertex(unsigned k, unsigned rate, unsigned own) { return (2 * k * own + rate) / (2 * rate); }

/*! Writes the border vertices of a part, in a patch of quadsX x quadsY quads, to `stored`. Adds to the statistics
 *  how far shared vertices were moved, and how far they were from `own`, the vertices as the primitive evaluates
 *  them. `stored` must be another array than `own`, because corners are read twice; its other vertices are
 *  unchanged. Both contain the part row by row. Patch: see source.h. */
template<typename Patch>
inline void shareBorder(const Patch& patch, unsigned step, unsigned quadsX, unsigned quadsY, const PatchPart& part,
                        const float (*own)[3], float (*stored)[3], cbvh::BuildStatistics& statistics) {
  const size_t width = part.x1 - part.x0 + 1;
  for (int s = 0; s < 4; s++) {
    const bool alongU = s % 2 == 0;
    const unsigned at = s == 1 ? quadsX : s == 2 ? quadsY : 0; // row or column of side s
    if (alongU ? at < part.y0 || at > part.y1 : at < part.x0 || at > part.x1) continue;
    const auto side = patch.side(s, step);
    const unsigned fine = alongU ? quadsX : quadsY;
    const unsigned begin = alongU ? part.x0 : part.y0, end = alongU ? part.x1 : part.y1;
    for (unsigned i = begin; i <= end; i++) {
      const unsigned c = i == fine ? side.rate : cbvh::stitchedVertex(i, fine, side.rate);
      SharedVertex v = side[s < 2 ? c : side.rate - c];
      const size_t vertex = alongU ? (at - part.y0) * width + (i - part.x0) : (i - part.y0) * width + (at - part.x0);
      const float* evaluated = own[vertex];
      if (!cbvh::isFinite(v.position) || !cbvh::isFinite(evaluated)) v = SharedVertex(evaluated, v.exponent);
      statistics.addBorderVertex(evaluated, v.position, v.stored);
      memcpy(stored[vertex], v.stored, sizeof(v.stored));
    }
  }
}
} // namespace embree::isa
