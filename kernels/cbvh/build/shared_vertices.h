// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the faces of a geometry share in cVERT: the vertices on their borders. Faces evaluate
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
 * lattice: GRID does not know of any. (Blocks there are raw.)
 *
 * An n-gon is a patch at each corner: its centre and the spokes from there to the middles
 * of its edges are shared by its own patches, and owned by it.
 *
 * This is made before any patch is encoded, from the borders of all: a twentieth of the
 * vertices is evaluated twice, and until the build ends the points of edges take 12 bytes each. */

#include "compression_plan.h"
#include "patch_grid.h"
#include "patches.h"
#include "vertex_lattice.h"

namespace embree
{
  namespace isa
  {
    /*! Vertices along one side of a patch, in its direction around the patch. */
    struct SideVertices
    {
      struct Vertex
      {
        const float* position;
        int exponent;          //!< of the lattice that it lies on
      };
      Vertex begin, end;
      const float (*interior)[3]; //!< of rate-1
      bool reversed;
      int exponent;            //!< of the interior's
      unsigned rate;

      Vertex operator[] (unsigned k) const
      {
        if (k == 0) return begin;
        if (k == rate) return end;
        return { interior[(reversed ? rate-k : k) - 1], exponent };
      }
    };

    class SharedVertices
    {
    public:
      SharedVertices (Scene* scene, const CompressionPlan& plan)
        : plan(plan), scene(scene), mesh(plan.mesh), first(mesh->topology[0].halfEdges.data()), exponents(scene->device,0), edges(scene->device,0), points(scene->device,0) {}

      /*! evaluates borders; shows progress to the scene's monitor, which may cancel */
      void build (size_t facesPerTask)
      {
        edges.resize(mesh->topology[0].halfEdges.size());
        exponents.resize(mesh->size());
        forFaces(facesPerTask,[&](size_t f, PatchGrid&) { findRates(f); });
        forFaces(facesPerTask,[&](size_t f, PatchGrid&) { findOwners(f); });
        placePoints();
        forFaces(facesPerTask,[&](size_t f, PatchGrid& grid) { evaluate(f,grid); });
        forFaces(facesPerTask,[&](size_t f, PatchGrid&) { findCornerLattices(f); });
      }

      /*! exponent of a face's lattice */
      int exponent (size_t face) const { return exponents[face]; }

      /*! vertices along a side of a patch; sides are in the order of PatchOfFace::rate */
      SideVertices side (size_t face, int subPatch, int s) const
      {
        const HalfEdge* h = mesh->getHalfEdge(0,face);
        const unsigned n = h->numEdges();
        if (n == 4) return edgeOf(h+s);
        const HalfEdge* own = h+subPatch;
        const HalfEdge* previous = h+(subPatch+n-1)%n;
        switch (s) {
        case 0 : return half(edgeOf(own),0);
        case 1 : return spoke(face,own,false);
        case 2 : return spoke(face,previous,true);
        default: return half(edgeOf(previous),1);
        }
      }

    private:
      static const unsigned noRate = 0;

      /*! of a half-edge */
      struct Edge
      {
        unsigned ownRate;      //!< of its face; noRate where that has no surface
        unsigned rate;         //!< of all faces that have the edge
        uint32_t owner;        //!< half-edge that has the edge's points
        uint32_t cornerOwner;  //!< half-edge that has the point of the start vertex
        uint32_t face;
        size_t points;         //!< of an owner: the corner if it owns that, then the edge, then the spoke, then the centre
        int cornerExponent;
        bool isGrids;          //!< GRID traces a patch of the face
      };

      template<typename Closure>
      void forFaces (size_t facesPerTask, const Closure& closure)
      {
        parallel_for(size_t(0),mesh->size(),facesPerTask,[&](const range<size_t>& faces) {
            PatchGrid grid(scene->device);
            for (size_t f=faces.begin(); f!=faces.end(); f++)
              closure(f,grid);
            scene->progressMonitor(0.0);
          });
      }

      uint32_t indexOf (const HalfEdge* h) const { return uint32_t(h - first); }
      Edge& at (const HalfEdge* h) { return edges[indexOf(h)]; }
      const Edge& at (const HalfEdge* h) const { return edges[indexOf(h)]; }
      bool takesPart (const HalfEdge* h) const { return at(h).ownRate != noRate; }
      bool takesPart (size_t f) const { return takesPart(mesh->getHalfEdge(0,f)); }
      static bool isQuad (const HalfEdge* h) { return h->numEdges() == 4; }

      void findRates (size_t f)
      {
        const HalfEdge* h = mesh->getHalfEdge(0,f);
        const unsigned n = h->numEdges();
        for (unsigned i=0; i<n; i++) { at(h+i) = Edge(); at(h+i).ownRate = noRate; at(h+i).face = uint32_t(f); }
        exponents[f] = cbvh::noLattice;
        if (!mesh->valid(f)) return;
        bool isGrids = false;
        forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
            isGrids |= plan.level(patch.rate) > cbvh::maxLevel;
            for (unsigned s=0; s<4; s++)
              if (n == 4) at(h+s).ownRate = unsigned(patch.rate[s]);
              else if (s == 0) at(h+patch.subPatch).ownRate = 2*unsigned(patch.rate[s]);
          });
        for (unsigned i=0; i<n; i++) at(h+i).isGrids = isGrids;
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
            if (!isQuad(e) || !isQuad(o)) edge.rate &= ~1u; // has a middle
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
        points.resize(3*n);
      }

      float* point (size_t i) { return points.data() + 3*i; }
      const float* point (size_t i) const { return points.data() + 3*i; }
      size_t cornerPoint (const HalfEdge* h) const { return edges[at(h).cornerOwner].points; }
      size_t firstEdgePoint (uint32_t owner) const { return edges[owner].points + ownsCorner(owner); }
      size_t firstSpokePoint (const HalfEdge* h) const { return firstEdgePoint(indexOf(h)) + edgePoints(indexOf(h)); }
      size_t centrePoint (const HalfEdge* last) const { return firstSpokePoint(last) + spokePoints(last); }

      /*! Writes the points that a face owns, and chooses its lattice. */
      void evaluate (size_t f, PatchGrid& grid)
      {
        if (!takesPart(f)) return;
        cbvh::EdgeSample sample, all;
        forEachPatch(mesh,f,[&](const PatchOfFace& patch) {
            const SubdivPatch1Base base = patch.make(mesh,plan.geomID,f);
            const unsigned quads[2] = { unsigned(base.grid_u_res-1), unsigned(base.grid_v_res-1) };
            for (unsigned s=0; s<4; s++)
            {
              const bool alongU = s % 2 == 0;
              const unsigned fine = quads[alongU ? 0 : 1], across = quads[alongU ? 1 : 0];
              const unsigned at = s == 1 || s == 2 ? across : 0;
              evaluateLine(base,grid,quads,alongU,at);
              takeLine(grid,fine == unsigned(patch.rate[s]) ? sample : all);
              ownLine(f,patch,s,grid,fine);
            }
            for (bool alongU : { true, false }) {
              if (quads[alongU ? 1 : 0] < 2) continue;
              evaluateLine(base,grid,quads,alongU,quads[alongU ? 1 : 0]/2);
              takeLine(grid,sample);
            }
          });
        cbvh::EdgeSample& edges = sample.empty() ? all : sample;
        const double spacing = plan.settings.maxError > 0 ? double(plan.settings.maxError) : edges.median()*cbvh::spacingOfEdge;
        exponents[f] = cbvh::latticeExponent(spacing,max(sample.maxCoordinate,all.maxCoordinate));
      }

      void evaluateLine (const SubdivPatch1Base& base, PatchGrid& grid, const unsigned quads[2], bool alongU, unsigned at) const
      {
        if (alongU) grid.evalPart(base,mesh,quads[0],quads[1],{ 0,quads[0],at,at });
        else        grid.evalPart(base,mesh,quads[0],quads[1],{ at,at,0,quads[1] });
      }

      static void takeLine (PatchGrid& grid, cbvh::EdgeSample& sample)
      {
        const float (*p)[3] = grid.displaced();
        const size_t n = grid.width*grid.height;
        for (size_t i=0; i+1<n; i++) sample.add(p[i],p[i+1]);
      }

      /*! keeps what a face owns of a side of a patch, which the grid holds */
      void ownLine (size_t f, const PatchOfFace& patch, unsigned s, PatchGrid& grid, unsigned fine)
      {
        const float (*line)[3] = grid.displaced();
        const unsigned own = unsigned(patch.rate[s]);
        const bool descends = s >= 2;
        /* vertex k of the side's own: the first of those that are stitched to it */
        auto vertex = [&](unsigned k) { return line[min(firstStitched(descends ? own-k : k,fine,own),fine)]; };
        auto keep = [&](size_t i, unsigned k) { const float* p = vertex(k); for (int c=0; c<3; c++) point(i)[c] = p[c]; };

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

      /*! first vertex of the grid that Embree's stitch() gives to k */
      static unsigned firstStitched (unsigned k, unsigned fine, unsigned coarse) { return (2*k*fine + coarse-1)/(2*coarse); }

      /*! vertex k of `rate`, among `own` */
      static unsigned nearest (unsigned k, unsigned rate, unsigned own) { return (2*k*own + rate)/(2*rate); }

      void findCornerLattices (size_t f)
      {
        if (!takesPart(f)) return;
        const HalfEdge* h = mesh->getHalfEdge(0,f);
        for (unsigned i=0; i<h->numEdges(); i++) {
          int exponent = exponents[f];
          bool isGrids = false;
          forEachAround(h+i,[&](const HalfEdge* a) { exponent = max(exponent,exponents[faceOf(a)]); isGrids |= at(a).isGrids; });
          at(h+i).cornerExponent = isGrids ? cbvh::minLatticeExponent : exponent;
        }
      }

      size_t faceOf (const HalfEdge* h) const { return at(h).face; }

      SideVertices edgeOf (const HalfEdge* h) const
      {
        const Edge& edge = at(h);
        SideVertices side;
        side.begin = { point(cornerPoint(h)), edge.cornerExponent };
        side.end = { point(cornerPoint(h->next())), at(h->next()).cornerExponent };
        side.interior = (const float(*)[3])point(firstEdgePoint(edge.owner));
        side.reversed = edge.owner != indexOf(h);
        side.rate = edge.rate;
        side.exponent = edge.isGrids ? cbvh::minLatticeExponent : exponents[faceOf(h)];
        if (h->hasOpposite() && takesPart(h->opposite()))
          side.exponent = at(h->opposite()).isGrids ? cbvh::minLatticeExponent : max(side.exponent,exponents[faceOf(h->opposite())]);
        return side;
      }

      /*! first or second half of an edge */
      static SideVertices half (SideVertices edge, int which)
      {
        const unsigned middle = edge.rate/2;
        const SideVertices::Vertex v = edge[middle];
        if (which == 0) edge.end = v; else edge.begin = v;
        /* interior points are counted from the owner's end */
        const bool later = (which == 1) != edge.reversed;
        if (later) edge.interior += middle;
        edge.rate = middle;
        return edge;
      }

      /*! from the middle of an n-gon's edge to its centre, or back */
      SideVertices spoke (size_t face, const HalfEdge* h, bool fromCentre) const
      {
        const HalfEdge* start = mesh->getHalfEdge(0,face);
        const SideVertices edge = edgeOf(h);
        const SideVertices::Vertex middle = edge[edge.rate/2], centre = { point(centrePoint(start+start->numEdges()-1)), exponents[face] };
        SideVertices side;
        side.begin = fromCentre ? centre : middle;
        side.end = fromCentre ? middle : centre;
        side.interior = (const float(*)[3])point(firstSpokePoint(h));
        side.reversed = fromCentre;
        side.exponent = exponents[face];
        side.rate = at(h).ownRate/2;
        return side;
      }

      const CompressionPlan& plan;
      Scene* scene;
      SubdivMesh* mesh;
      const HalfEdge* first;
      mvector<int> exponents;   //!< by face
      mvector<Edge> edges;      //!< by half-edge
      mvector<float> points;
    };
  }
}
