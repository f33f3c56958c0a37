// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "quad_regions.h"
#include "../base/atomic_ref.h"
#include "../base/resize_to_fit.h"
#include <algorithm>
#include <atomic>
#include <tuple>
#include <vector>

namespace embree
{
  namespace
  {
    /*! Of quads in the order of their numbers, those are seeds first that have no quad on their left and none below: they are corners
     *  of regions. From a seed a region grows to the right and up, a column or a row at a time, as square as it can. Large
     *  regions are taken before small ones, so that a row of quads at a pole does not cut the columns out of what is above it. */
    template<typename Quads>
    class RegionFinder
    {
    public:
      RegionFinder (const Quads& quads, size_t numVertices, Device* device, QuadRegions& out)
        : quads(quads), numVertices(numVertices), out(out), begins(device,0), flags(device,0) {}

      /*! false if it is not regular */
      bool run ()
      {
        if (!findRange()) return false;
        link();
        if (!looksRegular()) return false;
        findNeighbours();
        for (Seeds seeds : { CORNERS,EDGES,ALL })
          for (unsigned side : { 16u,4u }) take(seeds,side);
        take(CORNERS,1);
        take(ALL,1);
        return true;
      }

    private:
      enum : unsigned { none = ~0u };
      static const size_t perTask = 1 << 14;

      enum Flags : uint8_t { TAKEN = 1, HAS_LEFT = 2, HAS_BELOW = 4 };
      enum Seeds { CORNERS, EDGES, ALL };

      struct Quad
      {
        unsigned index;
        unsigned v[4];
        unsigned form;
      };

      /*! A quad that begins at a vertex where one of a lower number begins, and one of its neighbours on that side */
      struct Other
      {
        unsigned first, second, quad;
        bool operator< (const Other& other) const { return std::tie(first,second,quad) < std::tie(other.first,other.second,other.quad); }
      };

      Quad quad (unsigned index) const
      {
        Quad q;
        q.index = index;
        quads.corners(index,q.v);
        q.form = quads.form(index);
        return q;
      }

      /*! whether a quad lies on the right of another, or above it */
      static bool isRight (const Quad& q, const Quad& other) { return other.v[0] == q.v[1] && other.v[3] == q.v[2]; }
      static bool isAbove (const Quad& q, const Quad& other) { return other.v[0] == q.v[3] && other.v[1] == q.v[2]; }

      bool isValid (const Quad& q) const { return max(max(q.v[0],q.v[1]),max(q.v[2],q.v[3])) < numVertices; }

      /*! Vertices that the quads have; false if a table of them would be much larger than the mesh. */
      bool findRange ()
      {
        typedef std::pair<unsigned,unsigned> Range; // lowest, highest
        const Range range = parallel_reduce(size_t(0),quads.size(),perTask,Range(unsigned(none),0u),[&](const embree::range<size_t>& r) {
            Range of(unsigned(none),0u);
            for (size_t i=r.begin(); i!=r.end(); i++) {
              const Quad q = quad(unsigned(i));
              if (isValid(q)) of = Range(min(of.first,q.v[0]),max(of.second,q.v[0]));
            }
            return of;
          },[](const Range& a, const Range& b) { return Range(min(a.first,b.first),max(a.second,b.second)); });
        if (range.first > range.second) return false;
        lowest = range.first;
        const size_t size = size_t(range.second-range.first) + 1;
        if (size/16 > quads.size()) return false;
        cbvh::resizeToFit(begins,size);
        std::fill(begins.begin(),begins.end(),unsigned(none));
        return true;
      }

      /*! quads by the vertex at which they begin */
      void link ()
      {
        std::atomic<size_t> numLeftOut(0);
        parallel_for(size_t(0),quads.size(),perTask,[&](const range<size_t>& r) {
            size_t n = 0;
            for (size_t i=r.begin(); i!=r.end(); i++)
            {
              const Quad q = quad(unsigned(i));
              if (!isValid(q)) { n++; continue; }
              const cbvh::AtomicRef<unsigned> slot(begins[q.v[0]-lowest]);
              unsigned found = slot.load(std::memory_order_relaxed);
              while (q.index < found && !slot.exchangeWeak(found,q.index,std::memory_order_relaxed));
            }
            if (n) numLeftOut += n;
          });
        out.numLeftOut = numLeftOut;
        MutexSys mutex;
        parallel_for(size_t(0),quads.size(),perTask,[&](const range<size_t>& r) {
            std::vector<Other> right, above;
            for (size_t i=r.begin(); i!=r.end(); i++) {
              const Quad q = quad(unsigned(i));
              if (!isValid(q) || begins[q.v[0]-lowest] == q.index) continue;
              right.push_back(Other{ q.v[0],q.v[3],q.index });
              above.push_back(Other{ q.v[0],q.v[1],q.index });
            }
            if (right.empty()) return;
            Lock<MutexSys> lock(mutex);
            othersRight.insert(othersRight.end(),right.begin(),right.end());
            othersAbove.insert(othersAbove.end(),above.begin(),above.end());
          });
        std::sort(othersRight.begin(),othersRight.end());
        std::sort(othersAbove.begin(),othersAbove.end());
      }

      /*! A quad that begins at vertex `first` and has `second` as corner `c`, and the form of q; or none. */
      bool find (const Quad& q, unsigned first, unsigned second, int c, const std::vector<Other>& others, Quad& found) const
      {
        if (first < lowest || first-lowest >= begins.size()) return false;
        const unsigned index = begins[first-lowest];
        if (index == none) return false;
        found = quad(index);
        if (found.v[c] == second) return found.form == q.form && index != q.index;
        if (others.empty()) return false;
        const auto other = std::lower_bound(others.begin(),others.end(),Other{ first,second,0 });
        if (other == others.end() || other->first != first || other->second != second) return false;
        found = quad(other->quad);
        return found.form == q.form && found.index != q.index;
      }

      bool rightOf (const Quad& q, Quad& found) const { return find(q,q.v[1],q.v[2],3,othersRight,found); }
      bool above (const Quad& q, Quad& found) const { return find(q,q.v[3],q.v[2],1,othersAbove,found); }

      /*! whether of some quads a quarter has a quad on its right and one above that have the same quad between them */
      bool looksRegular () const
      {
        const size_t step = max(quads.size()/4096,size_t(1));
        size_t looked = 0, regular = 0;
        for (size_t i=0; i<quads.size(); i+=step) {
          const Quad q = quad(unsigned(i));
          Quad right, up, corner;
          looked++;
          regular += isValid(q) && rightOf(q,right) && above(q,up) && above(right,corner) && isRight(up,corner);
        }
        return 4*regular >= looked;
      }

      void findNeighbours ()
      {
        cbvh::resizeToFit(flags,quads.size());
        std::fill(flags.begin(),flags.end(),uint8_t(0));
        out.quads.reserve(quads.size());
        parallel_for(size_t(0),quads.size(),perTask,[&](const range<size_t>& r) {
            for (size_t i=r.begin(); i!=r.end(); i++) {
              const Quad q = quad(unsigned(i));
              Quad next;
              if (!isValid(q)) { mark(q.index,TAKEN); continue; }
              if (rightOf(q,next)) mark(next.index,HAS_LEFT);
              if (above(q,next)) mark(next.index,HAS_BELOW);
            }
          });
      }

      void mark (unsigned index, Flags flag) { cbvh::AtomicRef<uint8_t>(flags[index]).fetchOr(flag,std::memory_order_relaxed); }

      bool isSeed (unsigned index, Seeds seeds) const
      {
        const unsigned f = flags[index];
        if (f & TAKEN) return false;
        return seeds == ALL || (seeds == CORNERS ? (f & (HAS_LEFT | HAS_BELOW)) == 0 : (f & (HAS_LEFT | HAS_BELOW)) != (HAS_LEFT | HAS_BELOW));
      }

      /*! regions of that many quads along each side, or more */
      void take (Seeds seeds, unsigned side)
      {
        for (size_t i=0; i<quads.size(); i++)
        {
          if (!isSeed(unsigned(i),seeds)) continue;
          grow(unsigned(i),side);
          while (!corners.empty()) {
            const unsigned corner = corners.back();
            corners.pop_back();
            if (isSeed(corner,CORNERS)) grow(corner,side);
          }
        }
      }

      void grow (unsigned seed, unsigned side)
      {
        rows.assign(1,std::vector<Quad>(1,quad(seed)));
        flags[seed] |= TAKEN;
        for (bool isWideOpen = true, isHighOpen = true; isWideOpen || isHighOpen; )
        {
          const size_t width = rows[0].size(), height = rows.size();
          if (isWideOpen && (!isHighOpen || width <= height)) isWideOpen = width < QuadRegions::maxSide && growRight();
          else isHighOpen = height < QuadRegions::maxSide && growUp();
          if ((!isWideOpen && rows[0].size() < side) || (!isHighOpen && rows.size() < side)) {
            for (const auto& row : rows) letGo(row);
            return;
          }
        }
        out.regions.push_back(QuadRegions::Region{ out.quads.size(),unsigned(rows[0].size()),unsigned(rows.size()) });
        for (const auto& row : rows)
          for (const Quad& q : row) out.quads.push_back(q.index);
        Quad next;
        for (const auto& row : rows)
          if (rightOf(row.back(),next)) open(next.index,HAS_LEFT);
        for (const Quad& q : rows.back())
          if (above(q,next)) open(next.index,HAS_BELOW);
      }

      /*! a quad that has lost a neighbour, and may be a corner now */
      void open (unsigned index, Flags lost)
      {
        flags[index] &= ~lost;
        if (isSeed(index,CORNERS)) corners.push_back(index);
      }

      void letGo (const std::vector<Quad>& of) { for (const Quad& q : of) flags[q.index] &= ~TAKEN; }

      /*! Takes a quad next to a side of the region, the first of a line or behind its last. */
      bool takeNext (const Quad& q, bool isUp)
      {
        Quad next;
        if (!(isUp ? above(q,next) : rightOf(q,next)) || (flags[next.index] & TAKEN)) return false;
        if (!line.empty() && !(isUp ? isRight(line.back(),next) : isAbove(line.back(),next))) return false;
        flags[next.index] |= TAKEN;
        line.push_back(next);
        return true;
      }

      bool growRight ()
      {
        line.clear();
        for (const auto& row : rows)
          if (!takeNext(row.back(),false)) { letGo(line); return false; }
        for (size_t y=0; y<rows.size(); y++) rows[y].push_back(line[y]);
        return true;
      }

      bool growUp ()
      {
        line.clear();
        for (const Quad& q : rows.back())
          if (!takeNext(q,true)) { letGo(line); return false; }
        rows.push_back(line);
        return true;
      }

      const Quads quads;
      const size_t numVertices;
      QuadRegions& out;
      unsigned lowest = 0;
      mvector<unsigned> begins;                    //!< lowest quad that begins at a vertex
      std::vector<Other> othersRight, othersAbove; //!< the other quads there, by what they have to share
      mvector<uint8_t> flags;
      std::vector<unsigned> corners;               //!< that came up while regions were taken
      std::vector<std::vector<Quad>> rows;         //!< of the region that grows
      std::vector<Quad> line;
    };

    template<typename Quads>
    std::shared_ptr<const QuadRegions> findRegions (const Quads& quads, size_t numVertices, Device* device, const std::shared_ptr<QuadRegions>& out)
    {
      if (quads.size() == 0 || !RegionFinder<Quads>(quads,numVertices,device,*out).run()) return nullptr;
      return out;
    }

    /*! Collects the first triangle of each pair, unless all are of triangles 2i and 2i+1. False where a look at some triangles says that few have a
     *  partner. */
    bool findPairs (const TriangleMesh* mesh, mvector<unsigned>& firsts)
    {
      const size_t n = mesh->triangles.size();
      auto isPair = [&](size_t i) {
        unsigned v[4], turns;
        if (i+1 >= n || !PairsOfMesh::join(mesh->triangles[i].v,mesh->triangles[i+1].v,v,turns)) return false;
        return *std::max_element(v,v+4) < mesh->numVertices(); // else only one of them is left out
      };
      const size_t step = max(n/4096,size_t(1));
      size_t looked = 0, paired = 0;
      for (size_t i=0; i<n; i+=step, looked++) paired += isPair(i) || (i > 0 && isPair(i-1));
      if (2*paired < looked) return false;
      const bool isRegular = n % 2 == 0 && parallel_reduce(size_t(0),n/2,size_t(1) << 14,true,[&](const range<size_t>& r) {
          for (size_t i=r.begin(); i!=r.end(); i++)
            if (!isPair(2*i)) return false;
          return true;
        },std::logical_and<bool>());
      if (isRegular) return true;
      for (size_t i=0; i<n; i+=isPair(i) ? 2 : 1) firsts.push_back(unsigned(i));
      return true;
    }
  }

  std::shared_ptr<const QuadRegions> QuadRegions::find (const QuadMesh* mesh) {
    return findRegions(QuadsOfMesh{ mesh },mesh->numVertices(),mesh->device,std::make_shared<QuadRegions>(mesh->device));
  }

  std::shared_ptr<const QuadRegions> QuadRegions::find (const TriangleMesh* mesh)
  {
    const std::shared_ptr<QuadRegions> out = std::make_shared<QuadRegions>(mesh->device);
    if (!findPairs(mesh,out->firsts)) return nullptr;
    return findRegions(out->pairs(mesh),mesh->numVertices(),mesh->device,out);
  }
}
