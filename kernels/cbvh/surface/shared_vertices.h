// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the faces of a geometry share in cVERT, and where some of them are stored so: the vertices on
 * their borders. Faces evaluate
 * the same vertex some ulps apart, far apart where their normals differ or a height map
 * jumps, and each has a lattice of its own. So one face owns each edge of the cage and each
 * corner: its vertices are those of all, on the coarsest lattice of those that have them.
 * Then neighbours hold the same floats, and the surface is closed.
 *
 *           face A             The edge belongs to A if it has fewer vertices there, else to
 *     x----o----o----o----x    the lower half-edge; a corner x to the lowest half-edge that
 *           face B             leaves it, of those around it that are reached over edges.
 *
 * What is shared with a face that GRID traces, for its edge rates, is that face's, and on no
 * lattice: GRID does not know of any.
 *
 * An n-gon is a patch at each corner: its centre and the spokes from there to the middles
 * of its edges are shared by its own patches, and owned by it.
 *
 * A geometry that moves has all of this at each of its time steps; who owns what is the same at all of them.
 *
 * This is made before any patch is encoded, from the borders of all: a twentieth of the
 * vertices is evaluated twice, all of patches that have few, and until the build ends the points of edges take 12 bytes
 * each. Of small surfaces all vertices are evaluated here, and kept for their blocks: a border of few vertices costs no less
 * than the patch. */

#include "../base/exact_vector.h"
#include "../base/tasks.h"
#include "lattice_choice.h"
#include "patch_grid.h"
#include "patches.h"
#include "source.h"
#include <algorithm>
#include <map>
#include <memory>

namespace embree
{
  namespace isa
  {
    class SharedVertices
    {
    public:
      SharedVertices (SubdivMesh* mesh, const CompressionPlan& plan)
        : plan(plan), mesh(mesh), first(mesh->topology[0].halfEdges.data()), edges(mesh->device,0), firstKept(mesh->device,0)
      {
        for (unsigned s=0; s<plan.numTimeSteps; s++) steps.emplace_back(new Step(mesh->device));
      }

      /*! evaluates borders; calls progress() now and then, which may cancel */
      template<typename Progress>
      void build (size_t facesPerTask, const Progress& progress)
      {
        cbvh::resizeExactly(edges,numHalfEdges());
        for (auto& step : steps) cbvh::resizeExactly(step->exponents,mesh->size());
        forFaces(facesPerTask,progress,[&](size_t f, PatchGrid&) { findRates(f); });
        for (unsigned s=0; s<steps.size(); s++) steps[s]->diagonal = findDiagonal(facesPerTask,s);
        forFaces(facesPerTask,progress,[&](size_t f, PatchGrid&) { findOwners(f); });
        joinNonManifold();
        placePoints();
        if (plan.kind() == cbvh::Kind::VERT) placeKept();
        forFaces(facesPerTask,progress,[&](size_t f, PatchGrid& grid) { for (unsigned s=0; s<steps.size(); s++) evaluate(f,s,grid); });
        for (auto& step : steps) findLattices(*step);
      }

      /*! exponent of a face's lattice */
      int exponent (size_t face, unsigned step) const { return steps[step]->exponents[face]; }

      /*! all vertices of a patch, row by row, if they are kept, else null */
      const float (*evaluated (size_t face, int subPatch, unsigned step) const)[3] {
        return firstKept.size() ? (const float(*)[3])steps[step]->kept.data() + firstOf(face,subPatch) : nullptr;
      }

      /*! vertices along a side of a patch; sides are in the order of PatchOfFace::rate */
      SideVertices side (size_t face, int subPatch, int s, unsigned step) const
      {
        const HalfEdge* edge = edgeOfSide(mesh,face,subPatch,s);
        const Step& of = *steps[step];
        if (isQuad(mesh->getHalfEdge(0,face))) return edgeOf(edge,of);
        switch (s) {
        case 0 : return half(edgeOf(edge,of),0);
        case 1 : return spoke(face,edgeOfSide(mesh,face,subPatch,0),false,of);
        case 2 : return spoke(face,edgeOfSide(mesh,face,subPatch,3),true,of);
        default: return half(edgeOf(edge,of),1);
        }
      }

    private:
      static const unsigned noRate = 0;
      static const size_t mostKept = 1 << 15; //!< vertices of a surface, of all time steps
      static const size_t fewVertices = 9*9;  //!< of a patch whose lines cost no less than all of it
      typedef std::pair<uint64_t,uint32_t> KeyedEdge; //!< a half-edge behind its vertices

      /*! of a half-edge */
      struct Edge
      {
        unsigned ownRate;      //!< of its face; noRate where that has no surface
        unsigned rate;         //!< of all faces that have the edge
        uint32_t owner;        //!< half-edge that has the edge's points
        uint32_t cornerOwner;  //!< half-edge that has the point of the start vertex
        uint32_t face;
        size_t points;         //!< of an owner: the corner if it owns that, then the edge, then the spoke, then the centre
        bool isGrids;          //!< GRID traces a patch of the face
      };

      /*! exponents of the lattices of an owner's corner and edge */
      struct SharedLattices { int8_t corner, edge; };

      /*! what differs from one time step to the next */
      struct Step
      {
        explicit Step (Device* device) : exponents(device,0), shared(device,0), points(device,0), kept(device,0) {}

        double diagonal = 0;            //!< of the cage's bounds
        mvector<int> exponents;         //!< by face
        mvector<SharedLattices> shared; //!< by half-edge
        mvector<float> points;
        mvector<float> kept;            //!< vertices of patches of a small surface

        float* point (size_t i) { return points.data() + 3*i; }
        const float* point (size_t i) const { return points.data() + 3*i; }
      };

      template<typename Progress, typename Closure>
      void forFaces (size_t facesPerTask, const Progress& progress, const Closure& closure)
      {
        forRanges(mesh->size(),facesPerTask,[&](const range<size_t>& faces) {
            PatchGrid grid(mesh->device);
            for (size_t f=faces.begin(); f!=faces.end(); f++)
              closure(f,grid);
            progress();
          });
      }

      /*! Of faces, which findRates fills: the index buffer, and with it Embree's half-edges, may be longer. */
      size_t numHalfEdges () const
      {
        for (size_t f=mesh->size(); f-- > 0; )
          if (hasEdges(mesh,f)) return indexOf(mesh->getHalfEdge(0,f)) + mesh->faceVertices[f];
        return 0;
      }

      uint32_t indexOf (const HalfEdge* h) const { return uint32_t(h - first); }
      Edge& at (const HalfEdge* h) { return edges[indexOf(h)]; }
      const Edge& at (const HalfEdge* h) const { return edges[indexOf(h)]; }
      bool takesPart (const HalfEdge* h) const { return at(h).ownRate != noRate; }
      bool takesPart (size_t f) const { return hasEdges(mesh,f) && takesPart(mesh->getHalfEdge(0,f)); }
      static bool isQuad (const HalfEdge* h) { return h->numEdges() == 4; }

      void findRates (size_t f)
      {
        for (auto& step : steps) step->exponents[f] = cbvh::noLattice;
        if (!hasEdges(mesh,f)) return;
        const HalfEdge* h = mesh->getHalfEdge(0,f);
        const unsigned n = h->numEdges();
        for (unsigned i=0; i<n; i++) { at(h+i) = Edge(); at(h+i).ownRate = noRate; at(h+i).face = uint32_t(f); }
        if (!hasSurface(mesh,f)) return;
        bool isGrids = false;
        forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
            isGrids |= plan.storage(patch.rate) == CompressionPlan::GRIDS;
            for (unsigned s=0; s<4; s++)
              if (n == 4) at(h+s).ownRate = unsigned(patch.rate[s]);
              else if (s == 0) at(h+patch.subPatch).ownRate = 2*unsigned(patch.rate[s]);
          });
        for (unsigned i=0; i<n; i++) at(h+i).isGrids = isGrids;
      }

      /*! of the bounds of the cage's faces */
      double findDiagonal (size_t facesPerTask, unsigned step) const
      {
        const BBox3fa bounds = reduceRanges(edges.size(),4*facesPerTask,BBox3fa(empty),[&](const range<size_t>& r) {
            BBox3fa b(empty);
            for (size_t i=r.begin(); i!=r.end(); i++) {
              if (edges[i].ownRate == noRate) continue;
              const Vec3fa p = mesh->getVertexBuffer(step)[first[i].getStartVertexIndex()];
              if (cbvh::isFinite(&p.x)) b.extend(p);
            }
            return b;
          },[](const BBox3fa& a, const BBox3fa& b) { return merge(a,b); });
        return bounds.empty() ? 0.0 : length(bounds.size());
      }

      void findOwners (size_t f)
      {
        if (!takesPart(f)) return;
        const HalfEdge* h = mesh->getHalfEdge(0,f);
        for (unsigned i=0; i<h->numEdges(); i++)
        {
          const HalfEdge* e = h+i;
          Edge& edge = at(e);
          edge.rate = edge.ownRate;
          edge.owner = indexOf(e);
          if (e->hasOpposite() && takesPart(e->opposite()))
          {
            const HalfEdge* o = e->opposite();
            const Edge& other = at(o);
            const bool isOthers = other.isGrids != edge.isGrids ? other.isGrids
              : other.ownRate != edge.ownRate ? other.ownRate < edge.ownRate : indexOf(o) < indexOf(e);
            if (isOthers) edge.owner = indexOf(o);
            edge.rate = min(edge.ownRate,other.ownRate);
          }
          const HalfEdge* owner = e;
          forEachAround(e,[&](const HalfEdge* a) {
              if (at(a).isGrids != at(owner).isGrids ? at(a).isGrids : a < owner) owner = a;
            });
          edge.cornerOwner = indexOf(owner);
        }
      }

      /*! calls closure for the half-edges that leave the same corner, of faces that take part */
      template<typename Closure>
      void forEachAround (const HalfEdge* e, const Closure& closure) const
      {
        const HalfEdge* a = e;
        do {
          if (takesPart(a)) closure(a);
          if (!a->hasOpposite()) break;
          a = a->rotate();
        } while (a != e);
        if (a == e && e->hasOpposite()) return;
        for (a = e; a->prev()->hasOpposite(); ) {
          a = a->prev()->opposite();
          if (takesPart(a)) closure(a);
        }
      }

      /*! Edges of three faces and more have no opposites. Embree keeps their vertices where they
       *  are, so that all faces have the same straight edge: they share it, and its ends. */
      void joinNonManifold ()
      {
        std::vector<KeyedEdge> borders;
        for (uint32_t i=0; i<edges.size(); i++)
          if (edges[i].ownRate != noRate && !first[i].hasOpposite()) borders.push_back({ uint64_t(first[i].getEdge()),i });
        std::sort(borders.begin(),borders.end());
        std::map<unsigned,std::vector<uint32_t>> owners; // of corners, by vertex
        for (size_t begin=0, end=0; begin<borders.size(); begin=end)
        {
          while (end < borders.size() && borders[end].first == borders[begin].first) end++;
          if (end-begin < 3) continue;
          joinEdges(borders.data()+begin,borders.data()+end);
          for (size_t i=begin; i<end; i++)
            for (const HalfEdge* h : { first+borders[i].second, first[borders[i].second].next() })
              owners[h->getStartVertexIndex()].push_back(at(h).cornerOwner);
        }
        if (owners.empty()) return;
        std::map<uint32_t,uint32_t> joined;
        for (const auto& vertex : owners)
          for (uint32_t owner : vertex.second)
            joined[owner] = *std::min_element(vertex.second.begin(),vertex.second.end());
        forEachShare([&](Edge& edge) {
            const auto found = joined.find(edge.cornerOwner);
            if (found != joined.end()) edge.cornerOwner = found->second;
          });
      }

      void joinEdges (const KeyedEdge* begin, const KeyedEdge* end)
      {
        uint32_t owner = begin->second;
        for (const KeyedEdge* i=begin; i<end; i++)
          if (edges[i->second].ownRate < edges[owner].ownRate) owner = i->second;
        for (const KeyedEdge* i=begin; i<end; i++) {
          edges[i->second].owner = owner;
          edges[i->second].rate = edges[owner].ownRate;
        }
      }

      /*! points that a half-edge owns */
      size_t ownsCorner (uint32_t i) const { return edges[i].cornerOwner == i; }
      size_t ownsEdge (uint32_t i) const { return edges[i].owner == i; }
      size_t edgePoints (uint32_t i) const { return ownsEdge(i) ? edges[i].rate-1 : 0; }
      size_t spokePoints (const HalfEdge* h) const { return isQuad(h) ? 0 : at(h).ownRate/2-1; }

      void placePoints ()
      {
        size_t n = 0;
        for (size_t f=0; f<mesh->size(); f++)
        {
          if (!takesPart(f)) continue;
          const HalfEdge* h = mesh->getHalfEdge(0,f);
          for (unsigned i=0; i<h->numEdges(); i++) {
            at(h+i).points = n;
            n += ownsCorner(indexOf(h+i)) + edgePoints(indexOf(h+i)) + spokePoints(h+i);
          }
          if (!isQuad(h)) n++;
        }
        for (auto& step : steps) {
          cbvh::resizeExactly(step->points,3*n);
          if (plan.moves()) std::fill(step->points.begin(),step->points.end(),std::numeric_limits<float>::quiet_NaN()); // what no face evaluates
        }
      }

      /*! of surfaces with few vertices */
      void placeKept ()
      {
        const size_t most = mostKept/steps.size();
        if (mesh->size() > most/4) return;
        mvector<uint32_t> places(mesh->device,edges.size());
        size_t n = 0;
        for (size_t f=0; f<mesh->size() && n <= most; f++)
          if (takesPart(f))
            forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
                const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
                places[indexOf(mesh->getHalfEdge(0,f)) + patch.subPatch] = uint32_t(n);
                n += size_t(size.x)*size_t(size.y);
              });
        if (n > most) return;
        for (auto& step : steps) cbvh::resizeExactly(step->kept,3*n);
        firstKept = std::move(places);
      }

      /*! of the vertices of a patch that are kept */
      size_t firstOf (size_t face, int subPatch) const { return firstKept[indexOf(mesh->getHalfEdge(0,face)) + subPatch]; }
      float (*roomFor (size_t face, int subPatch, Step& step))[3] { return firstKept.size() ? (float(*)[3])step.kept.data() + firstOf(face,subPatch) : nullptr; }

      SideVertices::Vertex corner (const HalfEdge* h, const Step& step) const
      {
        const uint32_t owner = at(h).cornerOwner;
        return { step.point(edges[owner].points), step.shared[owner].corner };
      }
      size_t firstEdgePoint (uint32_t owner) const { return edges[owner].points + ownsCorner(owner); }
      size_t firstSpokePoint (const HalfEdge* h) const { return firstEdgePoint(indexOf(h)) + edgePoints(indexOf(h)); }
      size_t centrePoint (const HalfEdge* last) const { return firstSpokePoint(last) + spokePoints(last); }

      /*! Writes the points that a face owns, and chooses its lattice. */
      void evaluate (size_t f, unsigned s, PatchGrid& grid)
      {
        if (!takesPart(f)) return;
        Step& step = *steps[s];
        const bool isValid = mesh->valid(f,s);
        if (!isValid) return keepNothing(f,step);
        LatticeChoice lattice;
        forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
            const SubdivPatch1Base base = patch.make(mesh,plan.surface,f,s);
            const unsigned quads[2] = { unsigned(base.grid_u_res-1), unsigned(base.grid_v_res-1) };
            lattice.addPatch(quads);
            float few[fewVertices][3];
            float (*const kept)[3] = roomFor(f,patch.subPatch,step);
            LinesOfPatch lines(mesh,base,grid,quads,kept ? kept : (quads[0]+1)*(quads[1]+1) <= fewVertices ? few : nullptr);
            for (unsigned side=0; side<4; side++)
            {
              const bool alongU = side % 2 == 0;
              const unsigned fine = quads[alongU ? 0 : 1], across = quads[alongU ? 1 : 0];
              const unsigned at = side == 1 || side == 2 ? across : 0;
              const Line line = lines(alongU,at);
              lattice.addLine(alongU,line.vertices,line.count,fine != unsigned(patch.rate[side]));
              ownLine(f,patch,side,line,fine,step);
            }
            for (bool alongU : { true, false }) {
              if (quads[alongU ? 1 : 0] < 2) continue;
              const Line line = lines(alongU,quads[alongU ? 1 : 0]/2);
              lattice.addLine(alongU,line.vertices,line.count);
            }
          });
        step.exponents[f] = lattice.exponent(plan,step.diagonal);
      }

      /*! of a face whose vertices of the cage are not finite at that step */
      void keepNothing (size_t f, Step& step)
      {
        step.exponents[f] = cbvh::exactLattice;
        if (firstKept.size())
          forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
              const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
              float* const kept = &roomFor(f,patch.subPatch,step)[0][0];
              std::fill(kept,kept + 3*size_t(size.x)*size_t(size.y),std::numeric_limits<float>::quiet_NaN());
            });
      }

      /*! vertices in a row */
      struct Line { const float (*vertices)[3]; size_t count; };

      /*! Rows and columns of a patch: evaluated one by one, or taken from all its vertices, which are evaluated first. */
      class LinesOfPatch
      {
      public:
        /*! all: room for the vertices of the patch, if they are to be evaluated at once, or null */
        LinesOfPatch (const SubdivMesh* mesh, const SubdivPatch1Base& base, PatchGrid& grid, const unsigned quads[2], float (*all)[3])
          : mesh(mesh), base(base), grid(grid), quads(quads), all(all)
        {
          if (!all) return;
          grid.evalPart(base,mesh,quads[0],quads[1],{ 0,quads[0],0,quads[1] });
          memcpy(all,grid.displaced(),size_t(quads[0]+1)*size_t(quads[1]+1)*sizeof(*all));
        }

        /*! good until the next call */
        Line operator() (bool alongU, unsigned at)
        {
          if (!all) {
            const PatchPart row = { 0,quads[0],at,at }, column = { at,at,0,quads[1] };
            grid.evalPart(base,mesh,quads[0],quads[1],alongU ? row : column);
            return { grid.displaced(),grid.width*grid.height };
          }
          const size_t width = quads[0]+1, height = quads[1]+1;
          if (alongU) return { all+at*width,width };
          float (*column)[3] = grid.undisplaced(); // has room for all, and is not needed
          for (size_t y=0; y<height; y++) memcpy(column[y],all[y*width+at],sizeof(*column));
          return { column,height };
        }

      private:
        const SubdivMesh* mesh;
        const SubdivPatch1Base& base;
        PatchGrid& grid;
        const unsigned* quads;
        float (*all)[3];
      };

      /*! keeps what a face owns of a side of a patch */
      void ownLine (size_t f, const PatchOfFace& patch, unsigned s, const Line& side, unsigned fine, Step& step)
      {
        const float (*line)[3] = side.vertices;
        const unsigned own = unsigned(patch.rate[s]);
        const bool descends = s >= 2;
        /* vertex k of the side's own: the first of those that are stitched to it */
        auto vertex = [&](unsigned k) { return line[min(firstStitched(descends ? own-k : k,fine,own),fine)]; };
        auto keep = [&](size_t i, unsigned k) { const float* p = vertex(k); for (int c=0; c<3; c++) step.point(i)[c] = p[c]; };

        const HalfEdge* h = mesh->getHalfEdge(0,f);
        const unsigned n = h->numEdges();
        if (n == 4)
        {
          const uint32_t e = indexOf(h+s);
          if (ownsCorner(e)) keep(edges[e].points,0);
          if (ownsEdge(e))
            for (unsigned k=1; k<edges[e].rate; k++) keep(firstEdgePoint(e)+k-1,nearest(k,edges[e].rate,own));
          return;
        }
        const HalfEdge* e = s < 2 ? h+patch.subPatch : h+(patch.subPatch+n-1)%n;
        const unsigned rate = at(e).rate, middle = rate/2;
        const size_t edge = firstEdgePoint(indexOf(e));
        switch (s) {
        case 0:
          if (ownsCorner(indexOf(e))) keep(at(e).points,0);
          if (ownsEdge(indexOf(e)))
            for (unsigned k=1; k<=middle; k++) keep(edge+k-1,nearest(k,middle,own));
          break;
        case 1:
          for (unsigned k=1; k<own; k++) keep(firstSpokePoint(e)+k-1,k);
          if (patch.subPatch == 0) keep(centrePoint(h+n-1),own);
          break;
        case 3:
          if (ownsEdge(indexOf(e)))
            for (unsigned k=1; k<middle; k++) keep(edge+middle+k-1,nearest(k,middle,own));
          break;
        default: break;
        }
      }

      /*! vertex k of `rate`, among `own` */
      static unsigned nearest (unsigned k, unsigned rate, unsigned own) { return (2*k*own + rate)/(2*rate); }

      /*! the coarsest of all faces that share, and none where GRID traces one */
      void findLattices (Step& step)
      {
        const SharedLattices none = { int8_t(cbvh::exactLattice),int8_t(cbvh::exactLattice) };
        cbvh::resizeExactly(step.shared,edges.size());
        std::fill(step.shared.begin(),step.shared.end(),none);
        forEachShare([&](Edge& edge) {
            const int8_t own = int8_t(step.exponents[edge.face]);
            int8_t& corner = step.shared[edge.cornerOwner].corner;
            int8_t& interior = step.shared[edge.owner].edge;
            corner = max(corner,own);
            interior = max(interior,own);
          });
        forEachShare([&](Edge& edge) {
            if (!edge.isGrids) return;
            step.shared[edge.cornerOwner].corner = none.corner;
            step.shared[edge.owner].edge = none.edge;
          });
      }

      template<typename Closure>
      void forEachShare (const Closure& closure)
      {
        for (Edge& edge : edges)
          if (edge.ownRate != noRate) closure(edge);
      }

      SideVertices edgeOf (const HalfEdge* h, const Step& step) const
      {
        const Edge& edge = at(h);
        SideVertices side;
        side.begin = corner(h,step);
        side.end = corner(h->next(),step);
        side.interior = (const float(*)[3])step.point(firstEdgePoint(edge.owner));
        side.reversed = edge.owner != indexOf(h) && first[edge.owner].getStartVertexIndex() != h->getStartVertexIndex();
        side.rate = edge.rate;
        side.exponent = step.shared[edge.owner].edge;
        return side;
      }

      /*! First or second half of an edge. Embree gives edges of n-gons an even rate in all faces that it
       *  knows beside them. On an edge of three faces a quad's may be odd: then the vertex before
       *  the middle is the n-gon's, as Embree's stitching has it, and of rate 1 the first half is a point. */
      static SideVertices half (SideVertices edge, int which)
      {
        const unsigned middle = edge.rate/2, rest = edge.rate-middle;
        const SideVertices::Vertex v = edge[middle];
        if (which == 0) edge.end = v; else edge.begin = v;
        /* interior points are counted from the owner's end */
        const bool later = (which == 1) != edge.reversed;
        if (later) edge.interior += which == 1 ? middle : rest;
        edge.rate = which == 1 ? rest : max(middle,1u);
        return edge;
      }

      /*! from the middle of an n-gon's edge to its centre, or back */
      SideVertices spoke (size_t face, const HalfEdge* h, bool fromCentre, const Step& step) const
      {
        const HalfEdge* start = mesh->getHalfEdge(0,face);
        const SideVertices edge = edgeOf(h,step);
        const SideVertices::Vertex middle = edge[edge.rate/2], centre = { step.point(centrePoint(start+start->numEdges()-1)), step.exponents[face] };
        SideVertices side;
        side.begin = fromCentre ? centre : middle;
        side.end = fromCentre ? middle : centre;
        side.interior = (const float(*)[3])step.point(firstSpokePoint(h));
        side.reversed = fromCentre;
        side.exponent = step.exponents[face];
        side.rate = at(h).ownRate/2;
        return side;
      }

      const CompressionPlan& plan;
      SubdivMesh* mesh;
      const HalfEdge* first;
      std::vector<std::unique_ptr<Step>> steps;
      mvector<Edge> edges;         //!< by half-edge
      mvector<uint32_t> firstKept; //!< by the half-edge of a patch's corner; empty if the surface is not small
    };
  }
}
