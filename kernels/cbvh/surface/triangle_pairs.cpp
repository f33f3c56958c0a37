// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. A half-edge is 3 t + e: edge e of triangle t, from its corner e to the
 * next one. */

#include "triangle_pairs.h"
#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include <algorithm>
#include <vector>

namespace embree
{
  namespace
  {
    class PairFinder
    {
    public:
      PairFinder (const TriangleMesh* mesh, const WeldedVertices* welded)
        : mesh(mesh), welded(welded), size(mesh->triangles.size()), numVertices(mesh->numVertices()),
          ends(mesh->device,0), halves(mesh->device,0), opposite(mesh->device,0), mates(mesh->device,0) {}

      void run (mvector<unsigned>& firsts, mvector<unsigned>& seconds)
      {
        findEdges();
        cbvh::resizeToFit(mates,size);
        parallel_for(size_t(0),size,perTask,[&](const range<size_t>& r) {
            std::fill(mates.begin()+r.begin(),mates.begin()+r.end(),unsigned(none));
          });
        const Edges edges = chooseEdges();
        if (edges.isNone() || edges.first == edges.second || !pairBy(edges)) spread(edges);
        size_t numPairs = 0;
        for (size_t t=0; t<size; t++) numPairs += mates[t] != second;
        cbvh::resizeToFit(firsts,numPairs);
        cbvh::resizeToFit(seconds,numPairs);
        for (size_t t=0, i=0; t<size; t++)
          if (mates[t] != second) {
            firsts[i] = unsigned(t);
            seconds[i++] = mates[t] == none ? unsigned(t) : mates[t];
          }
      }

    private:
      enum : unsigned { none = ~0u, second = ~1u };
      static const size_t perTask = size_t(1) << 14;
      static const size_t samples = 4096;

      /*! a half-edge at its lower vertex */
      struct Half
      {
        unsigned other; //!< twice the higher vertex, and 1 if it begins there
        unsigned half;
        bool operator< (const Half& h) const { return other < h.other; }
      };

      /*! the edge that the first triangles of pairs share with the second ones, and which of theirs it is */
      struct Edges
      {
        unsigned first, second;
        bool isNone () const { return first == none; }
      };

      static unsigned next (unsigned half) { return half % 3 == 2 ? half-2 : half+1; }
      static unsigned before (unsigned half) { return half % 3 == 0 ? half+2 : half-1; }

      bool corners (size_t triangle, unsigned v[3]) const
      {
        memcpy(v,mesh->triangles.getPtr(triangle),3*sizeof(unsigned));
        if (max(max(v[0],v[1]),v[2]) >= numVertices) return false;
        if (welded)
          for (int i=0; i<3; i++) v[i] = (*welded)[v[i]];
        return true;
      }

      /*! Calls closure(lower vertex, Half) for the edges of a triangle that have two ends. */
      template<typename Closure>
      void forEachHalf (size_t triangle, const Closure& closure) const
      {
        unsigned v[3];
        if (!corners(triangle,v)) return;
        for (unsigned e=0; e<3; e++) {
          const unsigned a = v[e], b = v[e == 2 ? 0 : e+1];
          if (a != b) closure(min(a,b),Half{ 2*max(a,b) + (a > b),unsigned(3*triangle) + e });
        }
      }

      /*! Sets opposite, for each half-edge the one of the other triangle. */
      void findEdges ()
      {
        cbvh::resizeToFit(ends,numVertices+1);
        std::fill(ends.begin(),ends.end(),0u);
        parallel_for(size_t(0),size,perTask,[&](const range<size_t>& r) {
            for (size_t t=r.begin(); t!=r.end(); t++)
              forEachHalf(t,[&](unsigned v, const Half&) {
                  cbvh::AtomicRef<unsigned>(ends[v]).fetchAdd(1u,std::memory_order_relaxed);
                });
          });
        unsigned sum = 0;
        for (unsigned& end : ends) end = sum += end;
        cbvh::resizeToFit(halves,sum);
        parallel_for(size_t(0),size,perTask,[&](const range<size_t>& r) {
            for (size_t t=r.begin(); t!=r.end(); t++)
              forEachHalf(t,[&](unsigned v, const Half& half) {
                  halves[cbvh::AtomicRef<unsigned>(ends[v]).fetchAdd(~0u,std::memory_order_relaxed)-1] = half;
                });
          });
        cbvh::resizeToFit(opposite,3*size);
        parallel_for(size_t(0),3*size,3*perTask,[&](const range<size_t>& r) {
            std::fill(opposite.begin()+r.begin(),opposite.begin()+r.end(),unsigned(none));
          });
        parallel_for(size_t(0),numVertices,perTask,[&](const range<size_t>& r) {
            for (size_t v=r.begin(); v!=r.end(); v++) join(halves.data()+ends[v],halves.data()+ends[v+1]);
          });
      }

      /*! Joins the half-edges of a vertex. */
      void join (Half* begin, Half* end)
      {
        std::sort(begin,end);
        for (Half* i=begin, * j; i!=end; i=j) {
          for (j=i+1; j!=end && j->other/2 == i->other/2; j++) {}
          if (j != i+2 || i[0].other == i[1].other) continue;
          opposite[i[0].half] = i[1].half;
          opposite[i[1].half] = i[0].half;
        }
      }

      /*! square of the length of a half-edge at the first time step; 0 if it is not finite */
      double lengthOf (unsigned half) const
      {
        unsigned v[3];
        memcpy(v,mesh->triangles.getPtr(half/3),sizeof(v));
        const float* const p = (const float*)mesh->vertices[0].getPtr(v[half % 3]);
        const float* const q = (const float*)mesh->vertices[0].getPtr(v[next(half) % 3]);
        double square = 0;
        for (int k=0; k<3; k++) square += (double(p[k])-q[k])*(double(p[k])-q[k]);
        return square < std::numeric_limits<double>::infinity() ? square : 0;
      }

      /*! Of which edges most triangles have a partner at; none if there are none. */
      Edges chooseEdges () const
      {
        struct Sums
        {
          size_t count[3][3];
          double length[3][3];
          size_t isLower[3][3];
        } sums = Sums();
        size_t looked = 0;
        const size_t step = max(size/samples,size_t(1));
        for (size_t t=0; t<size; t+=step, looked++)
          for (unsigned e=0; e<3; e++) {
            const unsigned half = unsigned(3*t) + e, other = opposite[half];
            if (other == none) continue;
            const unsigned f = other % 3;
            sums.count[e][f]++;
            sums.length[e][f] += lengthOf(half);
            sums.isLower[e][f] += half < other;
          }
        size_t most = 0;
        auto countOf = [&](unsigned e, unsigned f) {
          return e == f ? sums.count[e][f] : sums.count[e][f] + sums.count[f][e];
        };
        for (unsigned e=0; e<3; e++)
          for (unsigned f=e; f<3; f++) most = max(most,countOf(e,f));
        Edges best = { none,none };
        if (4*most < 3*looked) return best;
        double bestLength = 0;
        for (unsigned e=0; e<3; e++)
          for (unsigned f=e; f<3; f++)
          {
            if (countOf(e,f) + most/256 < most) continue; // others end at borders, where quads have diagonals
            const double length = e == f ? sums.length[e][f] : sums.length[e][f] + sums.length[f][e];
            if (!best.isNone() && length <= bestLength) continue;
            bestLength = length;
            const bool isFirst = 2*sums.isLower[e][f] + sums.count[f][e] >= sums.count[e][f] + 2*sums.isLower[f][e];
            best = isFirst ? Edges{ e,f } : Edges{ f,e };
          }
        return best;
      }

      /*! Pairs all triangles that have these two edges in common, and are not in two such pairs. Returns false, and
       *  pairs none, if many are. */
      bool pairBy (const Edges& edges)
      {
        auto isJoined = [&](unsigned triangle, unsigned e, unsigned f) {
          const unsigned other = opposite[3*triangle+e];
          return other != none && other % 3 == f;
        };
        const size_t numPaired = parallel_reduce(size_t(0),size,perTask,size_t(0),[&](const range<size_t>& r) {
            size_t n = 0;
            for (size_t i=r.begin(); i!=r.end(); i++) {
              const unsigned t = unsigned(i);
              const bool isFirst = isJoined(t,edges.first,edges.second), isSecond = isJoined(t,edges.second,edges.first);
              if (isFirst == isSecond) continue;
              const unsigned s = opposite[3*t + (isFirst ? edges.first : edges.second)]/3;
              if (isFirst ? isJoined(s,edges.first,edges.second) : isJoined(s,edges.second,edges.first)) continue;
              mates[t] = isFirst ? s : unsigned(second);
              n++;
            }
            return n;
          },std::plus<size_t>());
        if (4*numPaired >= 3*size) return true;
        std::fill(mates.begin(),mates.end(),unsigned(none));
        return false;
      }

      /*! Pairs triangles along the rows and columns of quads, from a first pair on. Only across these edges, if there
       *  are any. */
      void spread (const Edges& edges)
      {
        auto isFree = [&](unsigned half) {
          if (half == none || opposite[half] == none) return false;
          const unsigned other = opposite[half];
          if (!edges.isNone() && (half % 3 != edges.first || other % 3 != edges.second)
              && (half % 3 != edges.second || other % 3 != edges.first)) return false;
          return mates[half/3] == none && mates[other/3] == none && half/3 != other/3;
        };
        std::vector<unsigned> found; // of first triangles, the half-edges that pairs share
        auto take = [&](unsigned half) {
          mates[half/3] = opposite[half]/3;
          mates[opposite[half]/3] = second;
          found.push_back(half);
        };
        for (size_t t=0, done=0; t<size; t++)
        {
          if (mates[t] != none) continue;
          unsigned longest = none;
          for (unsigned half=unsigned(3*t); half<unsigned(3*t)+3; half++)
            if (isFree(half) && (longest == none || lengthOf(half) > lengthOf(longest))) longest = half;
          if (longest == none) continue;
          take(longest);
          for (; done<found.size(); done++)
          {
            /* corners 00, 10, 01 and 11, 01, 10; `half` leads from 10 to 01 in the first triangle */
            const unsigned half = found[done], back = opposite[half];
            const unsigned right = opposite[next(back)], up = opposite[before(back)];
            const unsigned left = opposite[next(half)], down = opposite[before(half)];
            if (right != none && isFree(before(right))) take(before(right));
            if (up != none && isFree(next(up))) take(next(up));
            if (left != none && isFree(before(left))) take(opposite[before(left)]);
            if (down != none && isFree(next(down))) take(opposite[next(down)]);
          }
          found.clear();
          done = 0;
        }
      }

      const TriangleMesh* const mesh;
      const WeldedVertices* const welded;
      const size_t size, numVertices;
      mvector<unsigned> ends;     //!< where the half-edges of a vertex begin, at last
      mvector<Half> halves;       //!< by their lower vertex
      mvector<unsigned> opposite; //!< of each half-edge, or none
      mvector<unsigned> mates;    //!< the second triangle of a first one, `second` for second ones, or none
    };
  }

  bool pairTriangles (const TriangleMesh* mesh, const WeldedVertices* welded, mvector<unsigned>& firsts,
                      mvector<unsigned>& seconds)
  {
    if (mesh->triangles.size() >= size_t(1) << 30 || mesh->numVertices() >= size_t(1) << 31) return false;
    PairFinder(mesh,welded).run(firsts,seconds);
    return true;
  }
}
