// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the neighbors of a mesh's quads, as defined in quad_regions.h: the first step of the search for regions. */

#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include "quad_regions.h"
#include <algorithm>
#include <atomic>
#include <tuple>
#include <vector>

namespace embree {
struct QuadNeighbors {
  enum : unsigned { none = ~0u };
  enum Side { RIGHT, ABOVE, LEFT, BELOW, NUM_SIDES };

  cbvh::UnmonitoredVector<unsigned> at[NUM_SIDES]; //!< quad, or `none`
  cbvh::UnmonitoredVector<uint8_t> isValid;        //!< all corners are vertices
  size_t numInvalid = 0;
  bool firstCornersDiffer = false; //!< see cvert/format/prim_ids.h and looksRegular()

  size_t size() const { return isValid.size(); }
};

/*! Quads: QuadsOfMesh or PairsOfMesh. A quad "begins" at its corner v0, by which a table finds it. */
template<typename Quads>
class NeighborFinder {
public:
  NeighborFinder(const Quads& quads, size_t numVertices, QuadNeighbors& out)
    : quads(quads),
      numVertices(numVertices),
      out(out) {}

  /*! Finds the neighbors of all quads. Returns false, without neighbors, if findCorners() or looksRegular() does. */
  bool run() {
    if (!findCorners()) return false;
    buildTable();
    if (!looksRegular()) return false;
    findNeighbors();
    return true;
  }

private:
  enum : unsigned { none = QuadNeighbors::none };
  static const size_t perTask = 1 << 14;

  struct Corners {
    unsigned v[4];
  };

  struct Quad : public Corners {
    unsigned index;
    unsigned numbering;
  };

  /*! A quad that is not in the table, because a quad with a lower number begins at the same vertex. first: that
   *  vertex. second: another vertex that it shares with a neighbor. */
  struct ExtraQuad {
    unsigned first, second, quad;
    bool operator<(const ExtraQuad& other) const {
      return std::tie(first, second, quad) < std::tie(other.first, other.second, other.quad);
    }
  };

  Quad quad(unsigned index) const {
    Quad q;
    static_cast<Corners&>(q) = corners[index];
    q.index = index;
    q.numbering = numberings[index];
    return q;
  }

  static bool isRight(const Quad& q, const Quad& other) { return other.v[0] == q.v[1] && other.v[3] == q.v[2]; }

  bool isValid(const Corners& q) const { return max(max(q.v[0], q.v[1]), max(q.v[2], q.v[3])) < numVertices; }

  /*! True if two quads can be neighbors: they differ, and have the same numbering or, with firstCornersDiffer, the
   *  same number of triangles. */
  bool areCompatible(const Quad& q, const Quad& other) const {
    const unsigned different = q.numbering ^ other.numbering;
    if (q.index == other.index) return false;
    return out.firstCornersDiffer ? (different & cbvh::primIDsOfOneTriangle) == 0 : different == 0;
  }

  /*! Copies all corners, because later steps read them repeatedly and in the order of neighbors. Returns false if no
   *  quad is valid, or if the table would have more than 16 entries per quad. */
  bool findCorners() {
    cbvh::resizeToFit(corners, quads.size());
    cbvh::resizeToFit(numberings, quads.size());
    cbvh::resizeToFit(out.isValid, quads.size());
    std::atomic<size_t> numInvalid(0);
    typedef std::pair<unsigned, unsigned> Range; // lowest and highest vertex
    const Range empty(unsigned(none), 0u);
    const Range range = parallel_reduce(
        size_t(0), quads.size(), perTask, empty,
        [&](const embree::range<size_t>& r) {
          Range span = empty;
          size_t n = 0;
          for (size_t i = r.begin(); i != r.end(); i++) {
            Corners& q = corners[i];
            numberings[i] = uint8_t(quads.cornersAndNumbering(i, q.v));
            out.isValid[i] = isValid(q);
            if (out.isValid[i]) span = Range(min(span.first, q.v[0]), max(span.second, q.v[0]));
            else n++;
          }
          if (n) numInvalid += n;
          return span;
        },
        [](const Range& a, const Range& b) { return Range(min(a.first, b.first), max(a.second, b.second)); });
    out.numInvalid = numInvalid;
    if (range.first > range.second) return false;
    lowestVertex = range.first;
    const size_t size = size_t(range.second - range.first) + 1;
    if (size / 16 > quads.size()) return false;
    fill(lowestQuadAt, size);
    return true;
  }

  static void fill(mvector<unsigned>& table, size_t size) {
    cbvh::resizeToFit(table, size);
    parallel_for(size_t(0), size, size_t(1) << 16, [&](const range<size_t>& r) {
      std::fill(table.begin() + r.begin(), table.begin() + r.end(), unsigned(none));
    });
  }

  static void atomicMin(unsigned& value, unsigned to) {
    const cbvh::AtomicRef<unsigned> slot(value);
    unsigned found = slot.load(std::memory_order_relaxed);
    while (to < found && !slot.compareExchangeWeak(found, to, std::memory_order_relaxed)) {}
  }

  void buildTable() {
    parallel_for(size_t(0), quads.size(), perTask, [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++)
        if (out.isValid[i]) atomicMin(lowestQuadAt[corners[i].v[0] - lowestVertex], unsigned(i));
    });
    MutexSys mutex;
    parallel_for(size_t(0), quads.size(), perTask, [&](const range<size_t>& r) {
      std::vector<ExtraQuad> right, above;
      for (size_t i = r.begin(); i != r.end(); i++) {
        const Corners& q = corners[i];
        if (!out.isValid[i] || lowestQuadAt[q.v[0] - lowestVertex] == i) continue;
        right.push_back(ExtraQuad{q.v[0], q.v[3], unsigned(i)});
        above.push_back(ExtraQuad{q.v[0], q.v[1], unsigned(i)});
      }
      if (right.empty()) return;
      Lock<MutexSys> lock(mutex);
      extraRight.insert(extraRight.end(), right.begin(), right.end());
      extraAbove.insert(extraAbove.end(), above.begin(), above.end());
    });
    std::sort(extraRight.begin(), extraRight.end());
    std::sort(extraAbove.begin(), extraAbove.end());
  }

  /*! Finds the lowest quad that begins at vertex `first` and has `second` as corner c. Returns false if there is
   *  none, or if it is not compatible with q. */
  bool find(const Quad& q, unsigned first, unsigned second, int c, const std::vector<ExtraQuad>& extraQuads,
            Quad& found) const {
    if (first < lowestVertex || first - lowestVertex >= lowestQuadAt.size()) return false;
    const unsigned index = lowestQuadAt[first - lowestVertex];
    if (index == none) return false;
    found = quad(index);
    if (found.v[c] == second) return areCompatible(q, found);
    if (extraQuads.empty()) return false;
    const auto other = std::lower_bound(extraQuads.begin(), extraQuads.end(), ExtraQuad{first, second, 0});
    if (other == extraQuads.end() || other->first != first || other->second != second) return false;
    found = quad(other->quad);
    return areCompatible(q, found);
  }

  bool rightOf(const Quad& q, Quad& found) const { return find(q, q.v[1], q.v[2], 3, extraRight, found); }
  bool above(const Quad& q, Quad& found) const { return find(q, q.v[3], q.v[2], 1, extraAbove, found); }

  /*! True if at least a quarter of a sample of quads is regular: their right and upper neighbors share a neighbor.
   *  Sets firstCornersDiffer if more than twice as many are regular with neighbors of different numberings; triangle
   *  numbers must then fit into 30 bits, next to 2 bits for a first corner. */
  bool looksRegular() {
    const size_t step = max(quads.size() / 4096, size_t(1));
    size_t numSampled = 0;
    auto countRegular = [&](bool firstCornersDiffer) {
      out.firstCornersDiffer = firstCornersDiffer;
      numSampled = 0;
      size_t regular = 0;
      for (size_t i = 0; i < quads.size(); i += step) {
        const Quad q = quad(unsigned(i));
        Quad right, up, corner;
        numSampled++;
        regular += isValid(q) && rightOf(q, right) && above(q, up) && above(right, corner) && isRight(up, corner);
      }
      return regular;
    };
    const size_t withOwnCorners = countRegular(true), withEqualCorners = countRegular(false);
    out.firstCornersDiffer = withOwnCorners > 2 * withEqualCorners && quads.size() < size_t(1) << 29;
    return 4 * (out.firstCornersDiffer ? withOwnCorners : withEqualCorners) >= numSampled;
  }

  void findNeighbors() {
    for (auto& side : out.at) fill(side, quads.size());
    parallel_for(size_t(0), quads.size(), perTask, [&](const range<size_t>& r) {
      for (size_t i = r.begin(); i != r.end(); i++) {
        if (!out.isValid[i]) continue;
        const Quad q = quad(unsigned(i));
        Quad next;
        if (rightOf(q, next)) setNeighbor(q, next, QuadNeighbors::RIGHT, QuadNeighbors::LEFT);
        if (above(q, next)) setNeighbor(q, next, QuadNeighbors::ABOVE, QuadNeighbors::BELOW);
      }
    });
  }

  /*! Stores `next` as a neighbor of q. The neighbor of `next` on the opposite side is the lowest such q. */
  void setNeighbor(const Quad& q, const Quad& next, int side, int opposite) {
    out.at[side][q.index] = next.index;
    atomicMin(out.at[opposite][next.index], q.index);
  }

  const Quads quads;
  const size_t numVertices;
  QuadNeighbors& out;
  cbvh::UnmonitoredVector<Corners> corners;
  cbvh::UnmonitoredVector<uint8_t> numberings;
  unsigned lowestVertex = 0;                      //!< at which a quad begins
  cbvh::UnmonitoredVector<unsigned> lowestQuadAt; //!< lowest quad that begins at a vertex, by vertex - lowestVertex
  std::vector<ExtraQuad> extraRight, extraAbove;  //!< sorted by the vertices that neighbors must share
};
} // namespace embree
