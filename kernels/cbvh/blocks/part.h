// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Triangles and parts of a surface as stored, the results of stored_triangles.h, as plain data without Embree. */

#include <cstdint>

namespace embree::cbvh {
/*! A triangle of cVERT, cGRID or a mesh block. */
struct StoredTriangle {
  float vertices[3][3]; //!< in the geometry's space
  /*! Parameters at the vertices. The parameters of a hit are interpolated between them. */
  float u[3], v[3];
};

/*! The quads of a block: up to 16 x 16 of cVERT, up to 256 x 256 of cGRID. Of a mesh block, one quad or triangle; a
 *  quad of one triangle repeats a vertex. Neighboring parts, in cGRID only parts of one patch, store shared
 *  vertices as the same floats. */
struct StoredPart {
  uint32_t primID;        //!< of all quads, if primitivesPerQuad is 0
  uint32_t width, height; //!< in vertices
  /*! width*height vertices, row by row. Rays miss triangles with a vertex that is not finite. */
  const float* vertices;
  const float* parameters; //!< u, v per vertex; null unless primitivesPerQuad is 0
  const uint32_t* primIDs; //!< primitivesPerQuad per quad, row by row
  /*! 0 for cages and grids, 1 for quad meshes, 2 for triangle meshes: the primitives of a quad's first triangle, at
   *  00, 10 and 01, and of its second triangle, or the first repeated if there is no second. */
  uint32_t primitivesPerQuad;
};
} // namespace embree::cbvh
