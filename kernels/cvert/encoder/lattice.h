// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Lattices that vertices are moved to: all multiples of 2^exponent on the world's three axes. A lattice is part
 * of every finer one, so a vertex that faces share lies on the coarsest of theirs and is a
 * point of all of them.
 *
 * Snapping works on floats and is exact. Far from the origin, where floats are coarser than the lattice, every float lies on it already, and
 * does not move. */

#include "../basics/lanes.h"
#include "../basics/language.h"
#include "../basics/world.h"
#include <algorithm>
#include <cmath>
#include <vector>

namespace cvert { inline namespace CVERT_ISA
{
  /*! default spacing: this part of the median edge of a face's quads along u or v, whichever is
   *  shorter, or less */
  static constexpr double spacingOfEdge = 1.0/36;

  /*! A face of fewer quads than this gets a spacing that much finer: it is as large in a picture, and
   *  its headers outweigh its bits. */
  static constexpr unsigned fullQuads = 16;

  /*! Nor is the default more than this part of the diagonal of the geometry, which a picture of all of it
   *  does not show: objects of few quads have large ones, and bytes to spare. */
  static constexpr double spacingOfDiagonal = 1.0/32768;

  /*! But for the diagonal alone it is not less than this part of that edge: residuals have to fit into
   *  a cell's fields. */
  static constexpr double finestOfEdge = 1.0/96;

  /*! Default spacing for grids of an application, as a part of that edge. The application may start rays at its own vertices. If they start
   *  1/200 of an edge above the surface, they start above the stored surface, too, on slopes of up to 45 degrees. */
  static constexpr double spacingOfGridEdge = 1.0/512;

  /*! The same for quads and triangles. Renderers shade points on their own triangles; the stored surface, if it lies a little in front of such a
   *  point, puts it into shadow. tests/clients counts the pixels of a grazingly lit, smooth sheet that become darker by more than 5%: of 230400
   *  pixels 2055 at 1/512 of an edge, 172 at 1/2048, and 51 at 1/4096. */
  static constexpr double spacingOfMeshEdge = 1.0/2048;

  /*! median: of edges along u or v, of that many quads; diagonal: of the geometry's bounds */
  inline double defaultSpacing(double median, unsigned quads, double diagonal)
  {
    if (quads < fullQuads) return median*spacingOfEdge*quads/fullQuads;
    return std::min(median*spacingOfEdge,std::max(diagonal*spacingOfDiagonal,median*finestOfEdge));
  }

  /*! A coordinate of 2^this spacings or more is a multiple of the spacing: floats have no finer bits there. */
  static constexpr int floatBits = 23;

  /*! spacings whose reciprocal is a normal float */
  static constexpr int minLatticeExponent = -125, maxLatticeExponent = 100;

  /*! Stands for no lattice: vertices stay where they are. It is less than all others, because the coarsest lattice of a shared vertex counts. */
  static constexpr int exactLattice = -126;

  struct WorldLattice
  {
    float spacing;   //!< 0 of exactLattice
    float reciprocal, limit;

    explicit WorldLattice (int exponent)
      : spacing(exponent == exactLattice ? 0.0f : powerOfTwo(exponent)), reciprocal(powerOfTwo(-exponent)),
        limit(exponent == exactLattice ? 0.0f : powerOfTwo(std::min(exponent+floatBits,127))) {}

    /*! of exponents of normal floats */
    static float powerOfTwo (int exponent) { return floatOfBits(uint32_t(exponent+127) << 23); }

    /*! nearest multiple of the spacing, of two the even one; NaN and infinity stay */
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

  /*! largest power of two that is not above a spacing */
  inline int latticeExponent(double spacing) {
    return spacing > 0 ? std::min(std::max(std::ilogb(spacing),minLatticeExponent),maxLatticeExponent) : minLatticeExponent;
  }

  /*! median of the edges along lines of vertices, and their bounds */
  class EdgeSample
  {
  public:
    void add(const float (*line)[3], size_t count)
    {
      if (squares.capacity() < squares.size()+count) squares.reserve(3*(squares.size()+count)); // lines come by threes
      for (size_t i=0; i<count; i++)
      {
        for (int k=0; k<3; k++)
          if (std::isfinite(line[i][k])) {
            lower[k] = std::min(lower[k],double(line[i][k]));
            upper[k] = std::max(upper[k],double(line[i][k]));
          }
        if (i == 0) continue;
        const Double3 d = { double(line[i][0])-line[i-1][0], double(line[i][1])-line[i-1][1], double(line[i][2])-line[i-1][2] };
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
    std::vector<double> squares; //!< of lengths
  };
}}
