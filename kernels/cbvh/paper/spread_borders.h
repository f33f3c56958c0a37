// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Borders of patches on edges of a lower rate. Embree evaluates such a border at the lower rate, and moves several
 * vertices of the patch to each of its vertices; the quads between them collapse. For blocks with frames, only the
 * nearest one stays there, and the others are distributed over the straight line to the next vertex.
 *
 *     x---x---x---x---x---x      x: vertices of the patch
 *     |   |   |   |   |   |      o: vertices of an edge of rate 2 among them
 *     o---x---x-o-x---x---o
 *
 * Except for an outward shift of 2^-20, the border stays the same polyline. No quad collapses or extends over another
 * block. Parameters along the border differ from the regular patch by at most half a quad. */

#include "../surface/shared_border.h"
#include <cmath>

namespace embree::isa {
/*! Moves a point of a border outward by 2^-20 of its largest coordinate, but at most 1/16 of a quad. Otherwise
 *  rounding could leave a gap to a neighbor without a vertex there. inner: next vertex inside of the patch. */
inline cbvh::Double3 movedOutward(const cbvh::Double3& p, const cbvh::Double3& inner) {
  const cbvh::Double3 outward = p - inner;
  const double distance = cbvh::length(outward);
  const double size = cbvh::maximum(std::fabs(p.x), cbvh::maximum(std::fabs(p.y), std::fabs(p.z)));
  const double shift = cbvh::minimum(size / (1 << 20), distance / 16);
  return distance > 0 ? p + (shift / distance) * outward : p;
}

/*! Spreads one side of a patch. border: its fine+1 vertices, `along` vertices apart in memory, stitched to `coarse`
 *  quads. inward: distance in memory to the next row of vertices, in vertices. */
inline void spreadBorder(float (*border)[3], ssize_t along, ssize_t inward, unsigned fine, unsigned coarse) {
  if (fine == coarse) return;
  auto load = [](const float p[3]) { return cbvh::Double3{p[0], p[1], p[2]}; };
  for (unsigned k = 0; k < coarse; k++) {
    const ssize_t begin = firstStitched(k, fine, coarse), end = firstStitched(k + 1, fine, coarse);
    const cbvh::Double3 a = load(border[begin * along]), b = load(border[end * along]);
    for (ssize_t i = begin + 1; i < end; i++) {
      const double t = double(i - begin) / double(end - begin);
      const cbvh::Double3 p = movedOutward(a + t * (b - a), load(border[i * along + inward]));
      float* const out = border[i * along];
      out[0] = float(p.x);
      out[1] = float(p.y);
      out[2] = float(p.z);
    }
  }
}

/*! Spreads all sides of a patch. vertices: as many as `patch` has, row by row. rate: of the four sides, in the
 *  order of surface/source.h, at most the patch's quads there. */
inline void spreadBorders(const float rate[4], const PatchVertices& patch, float (*vertices)[3]) {
  const unsigned quadsX = unsigned(patch.width) - 1, quadsY = unsigned(patch.height) - 1;
  const ssize_t row = ssize_t(patch.width);
  spreadBorder(vertices, 1, row, quadsX, unsigned(rate[0]));
  spreadBorder(vertices + quadsX, row, -1, quadsY, unsigned(rate[1]));
  spreadBorder(vertices + quadsY * row, 1, -row, quadsX, unsigned(rate[2]));
  spreadBorder(vertices, row, 1, quadsY, unsigned(rate[3]));
}
} // namespace embree::isa
