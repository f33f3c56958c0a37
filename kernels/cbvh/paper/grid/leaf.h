// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cGRID: 2 x 2 quads of full-precision vertices, loaded as in Embree's GRID, so that the triangles and their
 * tests are the same. */

#include "../block.h"
#include "../../embree/traversal.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! Maps barycentric coordinates of triangles to face parameters, for Embree's triangle tests. Lanes are in the
 *  order of GridSOA's loaders. */
template<typename Loader>
struct GridMapUV {
  typedef typename Loader::vfloat vfloat;
  const Block* block;
  vfloat x0, y0, x1, y1, x2, y2; //!< positions of the triangles' vertices, in quads from the block's corner

  __forceinline GridMapUV(const Block* block, float x, float y) : block(block) {
    static const float X0[8] = {0, 0, 1, 1, 0, 0, 1, 1}, Y0[8] = {0, 1, 0, 1, 1, 2, 1, 2};
    static const float X1[8] = {1, 1, 2, 2, 1, 1, 2, 2}, Y1[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    static const float X2[8] = {0, 1, 1, 2, 0, 1, 1, 2}, Y2[8] = {1, 1, 1, 1, 2, 2, 2, 2};
    x0 = vfloat::loadu(X0) + x;
    x1 = vfloat::loadu(X1) + x;
    x2 = vfloat::loadu(X2) + x;
    y0 = vfloat::loadu(Y0) + y;
    y1 = vfloat::loadu(Y1) + y;
    y2 = vfloat::loadu(Y2) + y;
  }

  __forceinline void operator()(vfloat& u, vfloat& v, Vec3<vfloat>& Ng) const {
    const vfloat w = vfloat(1.0f) - u - v;
    const vfloat x = u * x1 + v * x2 + w * x0;
    const vfloat y = u * y1 + v * y2 + w * y0;
    u = block->faceU(x);
    v = block->faceV(y);
  }
};

/*! A leaf of cGRID. test.intersectTriangles<M>(v0,v1,v2,mapUV) must test M triangles. It returns true if a
 *  hit was accepted. */
template<typename Test>
class GridLeaf {
public:
  __forceinline GridLeaf(const Block* block, uint32_t leaf, const Test& test)
    : block(block),
      test(test),
      width((size_t(1) << block->height()) + 1),
      x(2 * mortonX(leaf)),
      y(2 * mortonY(leaf)) {}

  /*! Returns true if a hit was accepted. endsWithHit: may end at the first accepted hit. */
  __forceinline bool run(bool endsWithHit) const {
    // rows of vertices: a block of one quad has only 2
    const size_t rows = min(width, size_t(3));
#if defined(__AVX__)
    return intersectRows<GridSOA::Gather3x3>(y, rows);
#else
    bool found = intersectRows<GridSOA::Gather2x3>(y, rows);
    if (endsWithHit && found) return true;
    if (rows > 2) found |= intersectRows<GridSOA::Gather2x3>(y + 1, rows);
    return found;
#endif
  }

private:
  template<typename Loader>
  __forceinline bool intersectRows(size_t row, size_t rows) const {
    typedef typename Loader::vfloat vfloat;
    const size_t plane = width * width;
    const float* p = (const float*)block->leaves() + row * width + x;
    Vec3<vfloat> v0, v1, v2;
    Loader::gather(p, p + plane, p + 2 * plane, width, rows, v0, v1, v2);
    return test.template intersectTriangles<Loader::M>(v0, v1, v2, GridMapUV<Loader>(block, float(x), float(row)));
  }

  const Block* block;
  const Test& test;
  const size_t width, x, y;
};

template<typename Test>
__forceinline bool testGridLeaf(const Block* block, uint32_t leaf, bool endsWithHit, const Test& test) {
  return GridLeaf<Test>(block, leaf, test).run(endsWithHit);
}
} // namespace embree::isa::cbvh
