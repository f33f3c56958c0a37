// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Pairs of triangles that share an edge, wherever they are in the index buffer. In a regular mesh each inner triangle
 * has three neighbors, and any of the three directions makes quads that lie like those of a grid, if all pairs agree:
 *
 *   - Programs that cut quads into triangles begin all first halves at the same corner, and all second halves. The
 *     shared edge is the same of its triangle everywhere. Of the directions for which that is so, the longest edge is
 *     taken: it is the diagonal of a quad.
 *   - Where triangles begin at any corner, pairs spread from a first one, as quads do in a grid.
 *
 * Edges that more or less than two triangles have, or two in the same direction, separate. */

#include "../embree/scene.h"
#include "welded_vertices.h"

namespace embree
{
  /*! Finds pairs, in any order. A triangle without a partner is its own second. All triangles are in exactly one pair.
   *  welded: null if all vertices differ. The result is the same for any number of threads. Returns false if most
   *  vertices do not have six triangles, or if the mesh has so many triangles or vertices that numbers of edges do not
   *  fit into 32 bits. */
  bool pairTriangles (const TriangleMesh* mesh, const WeldedVertices* welded, mvector<unsigned>& firsts,
                      mvector<unsigned>& seconds);
}
