// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Triangles and parts of a stored surface, as plain data without headers of Embree. */

#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! A triangle of cVERT or cGRID. */
    struct StoredTriangle
    {
      float vertices[3][3]; //!< x, y, z in the geometry's space
      /*! Parameters of the vertices. Parameters of hits are interpolated between them. */
      float u[3], v[3];
    };

    /*! The quads of one block: up to 16 x 16 of cVERT, up to 256 x 256 of cGRID. Neighboring parts store shared
     *  vertices as the same floats; parts of cGRID do so only within a face. */
    struct StoredPart
    {
      uint32_t primID;           //!< primID of all quads, if primitivesPerQuad is 0
      uint32_t width, height;    //!< number of columns and rows of vertices
      /*! x, y, z of width*height vertices, row by row. Triangles with a vertex that is not finite are left out. */
      const float* vertices;
      const float* parameters;   //!< u, v of each vertex; null unless primitivesPerQuad is 0
      const uint32_t* primIDs;   //!< primitivesPerQuad per quad, row by row
      /*! 0 for cages and grids, 1 for quad meshes, 2 for triangle meshes. With 2, the primitive of the quad's first
       *  triangle is followed by the primitive of its second triangle, or repeated if there is no second triangle. */
      uint32_t primitivesPerQuad;
    };
  }
}
