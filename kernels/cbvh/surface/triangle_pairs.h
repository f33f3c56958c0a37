// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds pairs of triangles that share an edge, anywhere in the index buffer, for quad_regions.cpp. In a regular mesh,
 * an inner triangle has three neighbors. Pairs form a grid of quads if their shared edges are parallel:
 *
 * - Programs that split quads begin all first triangles at one corner, and all second triangles at one corner. The
 *   shared edge is then edge e of all first triangles, and edge f of all second ones. If several e and f are possible,
 *   the longest edge is chosen, as the quads' diagonal.
 * - If triangles begin at any corner, pairs spread from a first pair along rows and columns of a grid. Triangles that
 *   the first search left alone are paired in the same way, but only across edges e and f.
 *
 * Both searches cross only edges that exactly two triangles, with consistent winding, share. If triangle t of the first
 * half of the index buffer and triangle t of the second half share an edge, for nearly all t, then these are paired
 * without a search. */

#include "../embree/scene.h"
#include "welded_vertices.h"

namespace embree {
/*! Returns false if a sample of the triangles shows that grids are small or rare, so that a search would not reduce
 *  memory. Takes less time than a search. */
bool mayHaveLargeGrids(const TriangleMesh* mesh);

/*! Sets firsts and seconds to the triangles of each pair, in any order, independently of the number of threads. Each
 *  triangle is in exactly one pair; one without a partner is also its own second triangle. welded: null to match
 *  vertices by index. inGrids: triangles for which other pairs form grids. Returns false if most vertices do not have
 *  six triangles, if regular parts are narrow strips, if no more triangles than inGrids are inside of regular parts,
 *  or if edges cannot be numbered in 32 bits. */
bool pairTriangles(const TriangleMesh* mesh, const WeldedVertices* welded, size_t inGrids, mvector<unsigned>& firsts,
                   mvector<unsigned>& seconds);
} // namespace embree
