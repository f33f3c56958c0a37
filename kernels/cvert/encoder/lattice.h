// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lattices to which vertices are snapped before they are encoded: all multiples of 2^exponent on the world axes. A
 * lattice contains every coarser one, so a shared vertex on the coarsest lattice of its faces is a point of all of
 * them. Where floats are coarser than the lattice, every float is a point of it. */

#include "../portable/lanes.h"
#include "../portable/language.h"
#include "../portable/world.h"
#include <algorithm>
#include <cmath>
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
/*! Default spacing as a fraction of a face's median quad edge along u or v, whichever results in the finer spacing.
 *  spacingPerDiagonal may reduce it. */
static constexpr double spacingPerEdge = 1.0 / 36;

/*! Faces with fewer quads along an edge have a proportionally finer spacing: their quads are larger in a picture, and
 *  their bytes mostly headers. */
static constexpr unsigned fullSpacingQuads = 16;

/*! Upper bound of the default spacing of other faces, as a fraction of the geometry's diagonal, invisible in a
 *  picture of the whole geometry. For objects of few, large quads. */
static constexpr double spacingPerDiagonal = 1.0 / 32768;

/*! Least value of this bound, as a fraction of the edge: residuals must fit into their fields. */
static constexpr double minSpacingPerEdge = 1.0 / 96;

/*! Spacing for an application's grids. On slopes of up to 45 degrees, rays that start 1/200 of an edge above the
 *  application's vertices also start above the stored surface. */
static constexpr double spacingPerGridEdge = 1.0 / 512;

/*! Spacing for quads and triangles. Renderers shade points on their own triangles, on which a stored surface slightly
 *  in front casts a shadow. tests/clients counts the pixels of a bumpy sheet at grazing light that become darker by
 *  more than 5%: of 230400, 2055 at 1/512 of an edge, 172 at 1/2048, and 51 at 1/4096. */
static constexpr double spacingPerMeshEdge = 1.0 / 2048;

/*! Default spacing of a face of a cage. median: edge length along u or v. quads: in this direction. diagonal: of the
 *  geometry's bounds. */
inline double defaultSpacing(double median, unsigned quads, double diagonal) {
  if (quads < fullSpacingQuads) return median * spacingPerEdge * quads / fullSpacingQuads;
  return std::min(median * spacingPerEdge, std::max(diagonal * spacingPerDiagonal, median * minSpacingPerEdge));
}

/*! Stored mantissa bits of a float. Floats of at least 2^floatMantissaBits spacings are multiples of the spacing. */
static constexpr int floatMantissaBits = 23;

/*! Exponents of lattices. The reciprocals of these spacings are normal floats. */
static constexpr int minLatticeExponent = -125, maxLatticeExponent = 100;

/*! Denotes that vertices are not rounded. Less than the exponents of all lattices, because shared vertices use the
 *  coarsest lattice of their faces. */
static constexpr int losslessExponent = -126;

struct WorldLattice {
  float spacing;           //!< 0 for losslessExponent
  float reciprocal, limit; //!< 1/spacing; magnitude from which on all floats are lattice points

  /*! exponent: minLatticeExponent to maxLatticeExponent, or losslessExponent. */
  explicit WorldLattice(int exponent)
    : spacing(exponent == losslessExponent ? 0.0f : powerOfTwo(exponent)),
      reciprocal(powerOfTwo(-exponent)),
      limit(exponent == losslessExponent ? 0.0f : powerOfTwo(std::min(exponent + floatMantissaBits, 127))) {}

  /*! exponent: -126 to 127. */
  static float powerOfTwo(int exponent) { return floatOfBits(uint32_t(exponent + 127) << 23); }

  /*! Rounds to the nearest multiple, halves to even. Keeps NaN and infinity. */
  float snap(float x) const {
    if (!(std::fabs(x) < limit)) return x;
    return float(roundToInt(x * reciprocal)) * spacing;
  }
  Float4 snap(Float4 x) const {
    const Float4 snapped = toFloat(roundToInt(x * reciprocal)) * spacing;
    return select(lessThan(abs(x), limit), snapped, x);
  }
};

/*! Exponent of a spacing, rounded down and clamped to valid exponents. */
inline int latticeExponent(double spacing) {
  return spacing > 0 ? std::min(std::max(std::ilogb(spacing), minLatticeExponent), maxLatticeExponent)
                     : minLatticeExponent;
}

/*! Edge lengths along lines of vertices, and bounds of the vertices, to choose a spacing. */
class EdgeSample {
public:
  void add(const float (*line)[3], size_t count) {
    if (squares.capacity() < squares.size() + count) squares.reserve(3 * (squares.size() + count)); // for three lines
    for (size_t i = 0; i < count; i++) {
      for (int k = 0; k < 3; k++)
        if (std::isfinite(line[i][k])) {
          lower[k] = std::min(lower[k], double(line[i][k]));
          upper[k] = std::max(upper[k], double(line[i][k]));
        }
      if (i == 0) continue;
      const Double3 d = {double(line[i][0]) - line[i - 1][0], double(line[i][1]) - line[i - 1][1],
                         double(line[i][2]) - line[i - 1][2]};
      const double square = dot(d, d);
      if (square > 0 && std::isfinite(square)) squares.push_back(square); // stitched vertices coincide
    }
  }

  bool empty() const { return squares.empty(); }

  double median() {
    if (squares.empty()) return 0;
    std::nth_element(squares.begin(), squares.begin() + squares.size() / 2, squares.end());
    return std::sqrt(squares[squares.size() / 2]);
  }

  double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};

private:
  std::vector<double> squares; //!< squared edge lengths, without 0
};
}} // namespace cvert::CVERT_ISA
