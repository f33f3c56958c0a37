// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The vertices of grids that an application diced, and what grids share. Each grid has a lattice of its own; a vertex on the borders of several, whether
 * by its index or as the same floats, lies on the coarsest of theirs, so that grids are closed where the application's are.
 *
 * Where grids of different resolution meet, the application may have moved the vertices of the finer one onto the edges of the other:
 *
 *     p-----------------------q      coarse
 *     p-----m-----m-----m-----q      fine
 *
 * They are put onto the edge between p and q as those are stored, and on no lattice. What is stored without loss is left where it is.
 *
 * Grids that move have a lattice for each time step. Who shares what is found at the first step, and holds if it does so at all others. */

#include "../base/atomic_ref.h"
#include "../base/exact_vector.h"
#include "../base/tasks.h"
#include "diced_grids.h"
#include "lattice_choice.h"
#include "position_table.h"
#include <algorithm>
#include <tuple>

namespace embree
{
  namespace isa
  {
    /*! Grids: see diced_grids.h */
    template<typename Grids>
    class GridVertices
    {
    public:
      typedef typename Grids::Grid Grid;

      /*! a vertex as all grids have it */
      struct Shared
      {
        float position[3];
        int exponent;      //!< of the lattice that it lies on
      };

      GridVertices (const typename Grids::Mesh* mesh, const CompressionPlan& plan)
        : grids(mesh), plan(plan), numSteps(plan.numTimeSteps), device(mesh->device), table(mesh->device), exponents(mesh->device,0), later(mesh->device,0) {}

      size_t size () const { return grids.size(); }
      Grid operator[] (size_t i) const { return grids[i]; }
      bool isValid (size_t i) const { return grids.isValid(i); }
      const float* position (size_t vertex, unsigned step = 0) const { return grids.position(vertex,step); }

      /*! whether two vertices that are equal at the first time step are so at all others */
      bool moveAlike (size_t a, size_t b) const
      {
        for (unsigned step=1; step<numSteps; step++) {
          const float* p = position(a,step), * q = position(b,step);
          for (int k=0; k<3; k++)
            if (!(p[k] == q[k] || (std::isnan(p[k]) && std::isnan(q[k])))) return false;
        }
        return true;
      }
      bool number (size_t i, cbvh::QuadNumbers& out) const { return grids.number(i,out); }

      /*! of a grid's lattice */
      int exponent (size_t grid, unsigned step) const { return exponents[step*size() + grid]; }

      /*! calls progress() now and then, which may cancel */
      template<typename Progress>
      void prepare (size_t gridsPerTask, const Progress& progress)
      {
        cbvh::resizeExactly(exponents,numSteps*size());
        for (unsigned step=0; step<numSteps; step++) chooseLattices(step,gridsPerTask,progress);
        if (size() < 2 || plan.isLossless()) return;
        table.reserve(reduceRanges(size(),4*gridsPerTask,size_t(0),[&](const range<size_t>& r) {
              size_t n = 0;
              forEachValid(r,[&](size_t, const Grid& grid) { n += 2*(size_t(grid.quads(0))+grid.quads(1)); });
              return n;
            },std::plus<size_t>()));
        forGrids(gridsPerTask,progress,[&](size_t i, const Grid& grid) {
            forBorder(grid,[&](size_t vertex) { if (cbvh::isFinite(position(vertex))) table.add(*this,vertex,exponent(i,0)); });
          });
        shareLaterLattices(gridsPerTask,progress);
        findStitched(gridsPerTask,progress);
      }

      void release ()
      {
        table.clear();
        exponents.clear();
        later.clear();
        stitched.clear();
      }

      /*! of a vertex on the border of a grid; own: exponent of that grid's lattice */
      Shared shared (size_t vertex, int own, unsigned step) const
      {
        const float* p = position(vertex,step);
        Shared found = { { p[0],p[1],p[2] },own };
        if (table.isEmpty() || !cbvh::isFinite(p) || !cbvh::isFinite(position(vertex))) return found;
        const Entry entry = table.find(*this,vertex);
        if (!table.isMarked(entry)) { found.exponent = exponentOf(entry,step); return found; }
        const cbvh::Double3 onEdge = stored(entry,step);
        found.position[0] = float(onEdge.x); found.position[1] = float(onEdge.y); found.position[2] = float(onEdge.z);
        found.exponent = cbvh::exactLattice;
        return found;
      }

    private:
      typedef PositionTable<GridVertices> Table;
      typedef typename Table::Entry Entry;

      /*! an edge on the border of one grid alone */
      struct Edge
      {
        Entry end, begin;
        operator uint64_t () const { return uint64_t(begin) << 32 | end; } // their order
      };

      /*! a vertex of a finer grid, and the edge of a coarser one that it lies on */
      struct Stitched
      {
        Entry vertex;
        Edge edge;
      };

      template<typename Closure>
      void forEachValid (const range<size_t>& r, const Closure& closure) const
      {
        for (size_t i=r.begin(); i!=r.end(); i++)
          if (isValid(i)) closure(i,(*this)[i]);
      }

      template<typename Progress, typename Closure>
      void forGrids (size_t gridsPerTask, const Progress& progress, const Closure& closure) const
      {
        forRanges(size(),gridsPerTask,[&](const range<size_t>& r) {
            forEachValid(r,closure);
            progress();
          });
      }

      /*! calls closure(vertex), each once */
      template<typename Closure>
      static void forBorder (const Grid& grid, const Closure& closure)
      {
        for (int s=0; s<4; s++)
          for (unsigned k=0; k<grid.quads(s & 1); k++) closure(grid.onSide(s,k));
      }

      /*! Calls closure(alongU, vertices, count) for borders and middles. */
      template<typename Closure>
      void forLines (const Grid& grid, unsigned step, std::vector<float>& memory, const Closure& closure) const
      {
        memory.resize(3*max(grid.width,grid.height));
        float (*line)[3] = (float(*)[3])memory.data();
        for (unsigned y : { 0u,grid.quads(1)/2,grid.quads(1) }) {
          for (unsigned x=0; x<grid.width; x++) memcpy(line[x],position(grid.vertex(x,y),step),sizeof(*line));
          closure(true,line,size_t(grid.width));
        }
        for (unsigned x : { 0u,grid.quads(0)/2,grid.quads(0) }) {
          for (unsigned y=0; y<grid.height; y++) memcpy(line[y],position(grid.vertex(x,y),step),sizeof(*line));
          closure(false,line,size_t(grid.height));
        }
      }

      template<typename Progress>
      void chooseLattices (unsigned step, size_t gridsPerTask, const Progress& progress)
      {
        const BBox3fa bounds = reduceRanges(size(),gridsPerTask,BBox3fa(empty),[&](const range<size_t>& r) {
            BBox3fa b(empty);
            forEachValid(r,[&](size_t, const Grid& grid) {
                forBorder(grid,[&](size_t vertex) {
                    const float* p = position(vertex,step);
                    if (cbvh::isFinite(p)) b.extend(Vec3fa(p[0],p[1],p[2]));
                  });
              });
            return b;
          },[](const BBox3fa& a, const BBox3fa& b) { return merge(a,b); });
        const double diagonal = bounds.empty() ? 0.0 : length(bounds.size());
        forRanges(size(),gridsPerTask,[&](const range<size_t>& r) {
            std::vector<float> memory;
            forEachValid(r,[&](size_t i, const Grid& grid) {
                LatticeChoice lattice(Grids::spacingOfEdge());
                forLines(grid,step,memory,[&](bool alongU, const float (*line)[3], size_t count) { lattice.addLine(alongU,line,count); });
                exponents[step*size() + i] = lattice.exponent(plan,diagonal);
              });
            progress();
          });
      }

      /*! The coarsest lattices at all time steps but the first, which the table has. */
      template<typename Progress>
      void shareLaterLattices (size_t gridsPerTask, const Progress& progress)
      {
        cbvh::resizeExactly(later,(numSteps-1)*table.size());
        std::fill(later.begin(),later.end(),int8_t(cbvh::exactLattice));
        if (numSteps == 1) return;
        forGrids(gridsPerTask,progress,[&](size_t i, const Grid& grid) {
            forBorder(grid,[&](size_t vertex) {
                if (!cbvh::isFinite(position(vertex))) return;
                const Entry entry = table.find(*this,vertex);
                for (unsigned step=1; step<numSteps; step++)
                {
                  const cbvh::AtomicRef<int8_t> of(later[(step-1)*table.size() + entry]);
                  const int8_t own = int8_t(exponent(i,step));
                  for (int8_t found=of.load(std::memory_order_relaxed); found < own && !of.exchangeWeak(found,own,std::memory_order_relaxed); ) {}
                }
              });
          });
      }

      int exponentOf (Entry entry, unsigned step) const { return step == 0 ? table.exponent(entry) : int(later[(step-1)*table.size() + entry]); }

      cbvh::Double3 at (Entry entry, unsigned step = 0) const { const float* p = position(table.vertexOf(entry),step); return { p[0],p[1],p[2] }; }

      /*! As grids store it. Edges that end on other edges may do so again, and where grids overlap in a circle: not for ever. */
      cbvh::Double3 stored (Entry entry, unsigned step, unsigned depth = 0) const
      {
        const cbvh::Double3 p = at(entry,step);
        if (!table.isMarked(entry) || depth == 8) {
          const cbvh::WorldLattice lattice(exponentOf(entry,step));
          return { lattice.snap(float(p.x)),lattice.snap(float(p.y)),lattice.snap(float(p.z)) };
        }
        const Edge edge = std::lower_bound(stitched.begin(),stitched.end(),entry,[](const Stitched& s, Entry e) { return s.vertex < e; })->edge;
        const cbvh::Double3 a = stored(edge.begin,step,depth+1);
        return a + parameterOn(edge,at(entry))*(stored(edge.end,step,depth+1)-a); // the same place on it at all steps
      }

      /*! in an order that is the same whichever thread was first */
      bool isBefore (Entry a, Entry b) const
      {
        const cbvh::Double3 p = at(a), q = at(b);
        return std::tie(p.x,p.y,p.z) < std::tie(q.x,q.y,q.z);
      }

      /*! 0 to 1, of the nearest position to p */
      double parameterOn (const Edge& edge, const cbvh::Double3& p) const
      {
        const cbvh::Double3 a = at(edge.begin), d = at(edge.end)-a;
        return dot(p-a,d)/dot(d,d);
      }

      /*! Vertices that an application put onto edges of coarser grids. Where all vertices on borders are shared, there are none. */
      template<typename Progress>
      void findStitched (size_t gridsPerTask, const Progress& progress)
      {
        if (!table.isAnyAlone()) return;
        const mvector<Edge> open = findOpenEdges(gridsPerTask,progress);
        for (const Edge& edge : open)
          if (isBefore(edge.begin,edge.end) && table.isShared(edge.begin) && table.isShared(edge.end)) followEdge(edge,open);
        std::sort(stitched.begin(),stitched.end(),[&](const Stitched& a, const Stitched& b) {
            if (a.vertex != b.vertex) return a.vertex < b.vertex;
            return a.edge.begin != b.edge.begin ? isBefore(a.edge.begin,b.edge.begin) : a.edge.end != b.edge.end && isBefore(a.edge.end,b.edge.end);
          });
        for (const Stitched& s : stitched) table.mark(s.vertex);
      }

      /*! edges of borders that no other border has, in both directions, in order */
      template<typename Progress>
      mvector<Edge> findOpenEdges (size_t gridsPerTask, const Progress& progress) const
      {
        mvector<Edge> edges(device,0);
        MutexSys mutex;
        forRanges(size(),gridsPerTask,[&](const range<size_t>& r) {
            std::vector<Edge> ofTask;
            forEachValid(r,[&](size_t, const Grid& grid) { forEdges(grid,[&](Entry a, Entry b) { ofTask.push_back(Edge{ max(a,b),min(a,b) }); }); });
            progress();
            Lock<MutexSys> lock(mutex);
            for (const Edge& edge : ofTask) edges.push_back(edge);
          });
        sort(edges);
        size_t n = 0;
        for (size_t i=0, next; i<edges.size(); i=next) {
          for (next=i+1; next<edges.size() && edges[next] == edges[i]; next++);
          if (next == i+1) edges[n++] = edges[i];
        }
        edges.resize(2*n);
        for (size_t i=0; i<n; i++) edges[n+i] = Edge{ edges[i].begin,edges[i].end };
        sort(edges);
        return edges;
      }

      void sort (mvector<Edge>& edges) const
      {
        mvector<Edge> room(device,edges.size());
        radix_sort_u64(edges.data(),room.data(),edges.size());
      }

      /*! Calls closure for the ends of each edge of a border that has a length. */
      template<typename Closure>
      void forEdges (const Grid& grid, const Closure& closure) const
      {
        for (int s=0; s<4; s++) {
          Entry before = Table::none;
          for (unsigned k=0; k<=grid.quads(s & 1); k++) {
            const size_t vertex = grid.onSide(s,k);
            const Entry entry = cbvh::isFinite(position(vertex)) ? table.find(*this,vertex) : Table::none;
            if (before != Table::none && entry != Table::none && before != entry) closure(before,entry);
            before = entry;
          }
        }
      }

      /*! Walks along open edges that lie on this one, from its begin to its end: if it gets there, what is between is stitched. */
      void followEdge (const Edge& edge, const mvector<Edge>& open)
      {
        const size_t before = stitched.size();
        double t = 0;
        for (Entry from=edge.begin; from!=edge.end; )
        {
          Entry nearest = Table::none;
          double tNearest = 2.0;
          for (const Edge* next=std::lower_bound(open.begin(),open.end(),Edge{ 0,from }); next != open.end() && next->begin == from; next++)
          {
            if (from == edge.begin && next->end == edge.end) continue; // itself
            const double s = next->end == edge.end ? 1.0 : parameterOn(edge,at(next->end));
            if (s < tNearest && (next->end == edge.end || isOnEdge(edge,next->end,t,s))) { nearest = next->end; tNearest = s; }
          }
          if (nearest == Table::none) { stitched.resize(before); return; }
          from = nearest;
          t = tNearest;
          if (from != edge.end) stitched.push_back(Stitched{ from,edge });
        }
      }

      /*! Whether a vertex with parameter s is there, behind parameter t, but for what an application may have rounded; at all time steps. */
      bool isOnEdge (const Edge& edge, Entry entry, double t, double s) const
      {
        if (!(t < s && s < 1.0)) return false;
        for (unsigned step=0; step<numSteps; step++)
        {
          const cbvh::Double3 p = at(entry,step), a = at(edge.begin,step), d = at(edge.end,step)-a;
          const double size = max(max(std::fabs(p.x),std::fabs(p.y)),std::fabs(p.z));
          if (!(cbvh::length(a + s*d - p) <= max(1E-5*cbvh::length(d),4E-7*size))) return false;
        }
        return true;
      }

      const Grids grids;
      const CompressionPlan& plan;
      const unsigned numSteps;        //!< in time
      Device* const device;
      Table table;                    //!< of vertices on borders; empty for a single grid
      mvector<int> exponents;         //!< by grid, step by step
      mvector<int8_t> later;          //!< coarsest exponents by entry, for each step but the first
      std::vector<Stitched> stitched; //!< in the order of vertices
    };
  }
}
