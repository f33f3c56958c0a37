// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices that an application put onto edges of coarser grids, so that there are no gaps between adjacent grids of
 * different resolutions: part 4 of the rule in shared_border.h. Rounding such vertices to a lattice would open gaps.
 *
 *     p-----------------------q      coarse
 *     p-----m-----m-----m-----q      fine
 *
 * An open edge occurs only once on the borders of all grids. If other open edges lie on an open edge from p to q with
 * shared ends, and lead from p to q, the vertices between are stored on the edge between the stored p and q. They must
 * lie on it at all time steps, except for the application's rounding. If storing a vertex there would move it farther
 * than max_error, it is rounded to its lattice instead, and the gap remains. */

#include "border_lattices.h"
#include "position_table.h"
#include <algorithm>
#include <functional>
#include <tuple>

namespace embree::isa {
/*! Positions: has the members that PositionTable requires, size() (number of grids), position(vertex,step) and
 *  forEachBorderEdge(grid,closure(a,b)) with entries a and b. */
template<typename Positions>
class StitchedVertices {
  typedef PositionTable<Positions> Table;

public:
  typedef typename Table::Entry Entry;

  /*! maxError: bound on how far a vertex may move; infinity if there is none. */
  StitchedVertices(Device* device, const Positions& positions, Table& table, const BorderLattices& lattices,
                   unsigned numSteps, double maxError)
    : device(device),
      positions(positions),
      table(table),
      lattices(lattices),
      numSteps(numSteps),
      maxError(maxError) {}

  /*! Finds stitched vertices, and marks their entries in the table. */
  template<typename Progress>
  void find(size_t gridsPerTask, const Progress& progress) {
    if (!table.hasUnshared() && !mayHaveOpenEdges(gridsPerTask, progress)) return;
    const mvector<Edge> open = findOpenEdges(gridsPerTask, progress);
    for (const Edge& edge : open)
      if (isBefore(edge.begin, edge.end) && table.isShared(edge.begin) && table.isShared(edge.end))
        followEdge(edge, open);
    std::sort(stitched.begin(), stitched.end(), [&](const Stitched& a, const Stitched& b) {
      if (a.vertex != b.vertex) return a.vertex < b.vertex;
      if (a.edge.begin != b.edge.begin) return isBefore(a.edge.begin, b.edge.begin);
      return a.edge.end != b.edge.end && isBefore(a.edge.end, b.edge.end);
    });
    for (const Stitched& s : stitched) table.mark(s.vertex);
  }

  void clear() { stitched.clear(); }

  /*! Returns where grids store a vertex. Recursive, as ends of an edge can lie on other edges; depth is limited, as
   *  overlapping grids can form a cycle. */
  cbvh::Double3 stored(Entry entry, unsigned step, unsigned depth = 0) const {
    const cbvh::Double3 p = at(entry, step);
    if (table.isMarked(entry) && depth < 8) {
      auto vertexBefore = [](const Stitched& s, Entry e) { return s.vertex < e; };
      const Edge edge = std::lower_bound(stitched.begin(), stitched.end(), entry, vertexBefore)->edge;
      const cbvh::Double3 a = stored(edge.begin, step, depth + 1);
      const cbvh::Double3 q = // same parameter at all steps
          a + parameterOn(edge, at(entry)) * (stored(edge.end, step, depth + 1) - a);
      const cbvh::Double3 rounded = {float(q.x), float(q.y), float(q.z)};
      if (cbvh::length(rounded - p) <= maxError) return q;
    }
    const cbvh::WorldLattice lattice(lattices.ofShared(entry, step));
    return {lattice.snap(float(p.x)), lattice.snap(float(p.y)), lattice.snap(float(p.z))};
  }

private:
  struct Edge {
    Entry end, begin;
    operator uint64_t() const { return uint64_t(begin) << 32 | end; } // sort key
  };

  struct Stitched {
    Entry vertex;
    Edge edge;
  };

  cbvh::Double3 at(Entry entry, unsigned step = 0) const {
    const float* p = positions.position(table.vertexOf(entry), step);
    return {p[0], p[1], p[2]};
  }

  /*! Order by the positions at all time steps: independent of threads, unlike the order of entries. A strict
   *  weak order of entries without NaN. */
  bool isBefore(Entry a, Entry b) const {
    for (unsigned step = 0; step < numSteps; step++) {
      const cbvh::Double3 p = at(a, step), q = at(b, step);
      if (std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z)) return true;
      if (std::tie(q.x, q.y, q.z) < std::tie(p.x, p.y, p.z)) return false;
    }
    return false;
  }

  /*! Parameter of the edge's point that is nearest to p, at the first time step. */
  double parameterOn(const Edge& edge, const cbvh::Double3& p) const {
    const cbvh::Double3 a = at(edge.begin), d = at(edge.end) - a;
    return dot(p - a, d) / dot(d, d);
  }

  /*! Returns false if there are no open edges, without the memory of findOpenEdges(). Combines the hashes of all
   *  border edges: two of the same edge cancel each other out. A vertex on an edge may be shared by two grids, so
   *  that hasUnshared() is not sufficient. */
  template<typename Progress>
  bool mayHaveOpenEdges(size_t gridsPerTask, const Progress& progress) const {
    return reduceRanges(
               positions.size(), gridsPerTask, uint64_t(0),
               [&](const range<size_t>& r) {
                 uint64_t hashes = 0;
                 for (size_t i = r.begin(); i != r.end(); i++)
                   positions.forEachBorderEdge(i,
                                               [&](Entry a, Entry b) { hashes ^= hashOf(Edge{max(a, b), min(a, b)}); });
                 progress();
                 return hashes;
               },
               std::bit_xor<uint64_t>()) != 0;
  }

  /*! A bijective hash (based on: Sebastiano Vigna, "SplitMix64", 2015). */
  static uint64_t hashOf(uint64_t edge) {
    edge += 0x9E3779B97F4A7C15ull;
    edge = (edge ^ edge >> 30) * 0xBF58476D1CE4E5B9ull;
    edge = (edge ^ edge >> 27) * 0x94D049BB133111EBull;
    return edge ^ edge >> 31;
  }

  /*! Returns the open edges, each in both directions, sorted by their begin. */
  template<typename Progress>
  mvector<Edge> findOpenEdges(size_t gridsPerTask, const Progress& progress) const {
    mvector<Edge> edges(device, 0);
    MutexSys mutex;
    forRanges(positions.size(), gridsPerTask, [&](const range<size_t>& r) {
      std::vector<Edge> ofTask;
      for (size_t i = r.begin(); i != r.end(); i++)
        positions.forEachBorderEdge(i, [&](Entry a, Entry b) { ofTask.push_back(Edge{max(a, b), min(a, b)}); });
      progress();
      Lock<MutexSys> lock(mutex);
      for (const Edge& edge : ofTask) edges.push_back(edge);
    });
    sort(edges);
    size_t n = 0;
    for (size_t i = 0, next; i < edges.size(); i = next) {
      for (next = i + 1; next < edges.size() && edges[next] == edges[i]; next++);
      if (next == i + 1) edges[n++] = edges[i];
    }
    edges.resize(2 * n);
    for (size_t i = 0; i < n; i++) edges[n + i] = Edge{edges[i].begin, edges[i].end};
    sort(edges);
    return edges;
  }

  void sort(mvector<Edge>& edges) const {
    mvector<Edge> temporary(device, edges.size());
    radix_sort_u64(edges.data(), temporary.data(), edges.size());
  }

  /*! Follows open edges on `edge`, from its begin. If they lead to its end, adds the vertices between to
   *  `stitched`. */
  void followEdge(const Edge& edge, const mvector<Edge>& open) {
    const size_t before = stitched.size();
    double t = 0;
    for (Entry from = edge.begin; from != edge.end;) {
      Entry nearest = Table::none;
      double tNearest = 2.0;
      const Edge* next = std::lower_bound(open.begin(), open.end(), Edge{0, from});
      for (; next != open.end() && next->begin == from; next++) {
        const bool isLast = next->end == edge.end;
        if (from == edge.begin && isLast) continue; // skips `edge` itself
        const double s = isLast ? 1.0 : parameterOn(edge, at(next->end));
        const bool isNearer = s < tNearest || (nearest != Table::none && s == tNearest && isBefore(next->end, nearest));
        if (isNearer && (isLast || isOnEdge(edge, next->end, t, s))) {
          nearest = next->end;
          tNearest = s;
        }
      }
      if (nearest == Table::none) {
        stitched.resize(before);
        return;
      }
      from = nearest;
      t = tNearest;
      if (from != edge.end) stitched.push_back(Stitched{from, edge});
    }
  }

  /*! True if a vertex at parameter s lies on the edge after parameter t, at all time steps. The application's
   *  rounding may move it by 1e-5 of the edge, or by about 3 ulps (4e-7) of its largest coordinate. */
  bool isOnEdge(const Edge& edge, Entry entry, double t, double s) const {
    if (!(t < s && s < 1.0)) return false;
    for (unsigned step = 0; step < numSteps; step++) {
      const cbvh::Double3 p = at(entry, step), a = at(edge.begin, step), d = at(edge.end, step) - a;
      const double size = max(max(std::fabs(p.x), std::fabs(p.y)), std::fabs(p.z));
      if (!(cbvh::length(a + s * d - p) <= max(1E-5 * cbvh::length(d), 4E-7 * size))) return false;
    }
    return true;
  }

  Device* const device;
  const Positions& positions;
  Table& table;
  const BorderLattices& lattices;
  const unsigned numSteps;
  const double maxError;
  std::vector<Stitched> stitched; //!< sorted by vertex
};
} // namespace embree::isa
