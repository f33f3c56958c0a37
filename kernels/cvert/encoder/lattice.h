// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lattices to which vertices are snapped: all multiples of 2^exponent on the three world axes. A lattice is a subset of
 * every finer one. A vertex that several faces share is snapped to the coarsest of their lattices, so it is a point of
 * all of them.
 *
 * Snapping floats is exact. Far from the origin, where floats are coarser than the lattice, every float is already a
 * point of the lattice and does not move. */

#include "../basics/lanes.h"
#include "../basics/language.h"
#include "../basics/world.h"
#include <algorithm>
#include <cmath>
#include <vector>

namespace cvert { inline namespace CVERT_ISA
{
  /*! Default spacing as a fraction of the median edge of a face's quads along u or v, whichever is shorter. The default
   *  may be smaller, see below. */
  static constexpr double spacingOfEdge = 1.0/36;

  /*! A face with fewer quads than this gets a proportionally finer spacing: it is as large in a picture as other faces,
   *  and its headers take more memory than its vertices. */
  static constexpr unsigned fullQuads = 16;

  /*! The default spacing is at most this fraction of the diagonal of the geometry, which is not visible in a picture of
   *  the whole geometry. Objects of few quads have large quads and need little memory anyway. */
  static constexpr double spacingOfDiagonal = 1.0/32768;

  /*! The limit by the diagonal does not reduce the spacing below this fraction of the edge, because residuals must fit
   *  into the fields of a cell. */
  static constexpr double finestOfEdge = 1.0/96;

  /*! Default spacing for grids of an application, as a fraction of the median edge. The application may start rays at
   *  its own vertices. If rays start 1/200 of an edge above the surface, they also start above the stored surface, on
   *  slopes of up to 45 degrees. */
  static constexpr double spacingOfGridEdge = 1.0/512;

  /*! The same for quads and triangles. Renderers shade points on their own triangles. If the stored surface is slightly
   *  in front of such a point, it casts a shadow on it. tests/clients counts the pixels of a smooth sheet at grazing
   *  light that become darker by more than 5%. Of 230400 pixels these are 2055 at 1/512 of an edge, 172 at 1/2048, and
   *  51 at 1/4096. */
  static constexpr double spacingOfMeshEdge = 1.0/2048;

  /*! median: length of edges along u or v. quads: number of quads along them. diagonal: of the geometry's bounds. */
  inline double defaultSpacing(double median, unsigned quads, double diagonal)
  {
    if (quads < fullQuads) return median*spacingOfEdge*quads/fullQuads;
    return std::min(median*spacingOfEdge,std::max(diagonal*spacingOfDiagonal,median*finestOfEdge));
  }

  /*! Coordinates of at least 2^floatBits spacings are multiples of the spacing, because floats have no finer bits
   *  there. */
  static constexpr int floatBits = 23;

  /*! Range of the exponents of spacings. Their reciprocals are normal floats. */
  static constexpr int minLatticeExponent = -125, maxLatticeExponent = 100;

  /*! Exponent for no lattice: vertices do not move. It is less than all others because the coarsest lattice of a shared
   *  vertex is used. */
  static constexpr int exactLattice = -126;

  struct WorldLattice
  {
    float spacing;   //!< 0 for exactLattice
    float reciprocal, limit;

    explicit WorldLattice (int exponent)
      : spacing(exponent == exactLattice ? 0.0f : powerOfTwo(exponent)), reciprocal(powerOfTwo(-exponent)),
        limit(exponent == exactLattice ? 0.0f : powerOfTwo(std::min(exponent+floatBits,127))) {}

    /*! The exponent must be the exponent of a normal float. */
    static float powerOfTwo (int exponent) { return floatOfBits(uint32_t(exponent+127) << 23); }

    /*! Nearest multiple of the spacing, halves to even. NaN and infinity do not change. */
    float snap (float x) const
    {
      if (!(std::fabs(x) < limit)) return x;
      return float(rounded(x*reciprocal))*spacing;
    }
    Float4 snap (Float4 x) const
    {
      const Float4 snapped = toFloat(rounded(x*reciprocal))*spacing;
      return select(below(abs(x),limit),snapped,x);
    }
  };

  /*! Exponent of the largest power of two that is at most `spacing`, clamped to the valid range. */
  inline int latticeExponent(double spacing) {
    return spacing > 0 ? std::min(std::max(std::ilogb(spacing),minLatticeExponent),maxLatticeExponent)
                       : minLatticeExponent;
  }

  /*! Median length of the edges along lines of vertices, and bounds of the vertices. */
  class EdgeSample
  {
  public:
    void add(const float (*line)[3], size_t count)
    {
      if (squares.capacity() < squares.size()+count) squares.reserve(3*(squares.size()+count)); // there are three lines
      for (size_t i=0; i<count; i++)
      {
        for (int k=0; k<3; k++)
          if (std::isfinite(line[i][k])) {
            lower[k] = std::min(lower[k],double(line[i][k]));
            upper[k] = std::max(upper[k],double(line[i][k]));
          }
        if (i == 0) continue;
        const Double3 d = { double(line[i][0])-line[i-1][0], double(line[i][1])-line[i-1][1],
                            double(line[i][2])-line[i-1][2] };
        const double square = dot(d,d);
        if (square > 0 && std::isfinite(square)) squares.push_back(square); // stitched vertices coincide
      }
    }

    bool empty() const { return squares.empty(); }

    double median()
    {
      if (squares.empty()) return 0;
      std::nth_element(squares.begin(),squares.begin()+squares.size()/2,squares.end());
      return std::sqrt(squares[squares.size()/2]);
    }

    double lower[3] = { INFINITY,INFINITY,INFINITY }, upper[3] = { -INFINITY,-INFINITY,-INFINITY }; //!< of the vertices

  private:
    std::vector<double> squares; //!< squared lengths
  };
}}
