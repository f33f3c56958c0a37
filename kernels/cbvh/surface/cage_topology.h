// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the owners and rates of a cage's edges and corners, for cage_borders.h. shared_border.h defines owner, rate and
 * claim, and has the rule. A face participates if it has a surface at any time step.
 *
 *          face A             A and B claim the edge. A corner x is claimed by all faces around it
 *    x----o----o----o----x    that can be reached from A or B by crossing edges. The number of a
 *          face B             claim is the index of a half-edge.
 *
 * The half-edges of a non-manifold edge, with three or more faces, have no opposite. Faces that do not participate
 * also count. Embree keeps the edge's vertices in place, so before displacement it is straight and equal in all faces.
 * All share it and its two corners.
 * If two faces have opposite winding, the half-edges of their edge have no opposite either: Embree treats them as
 * borders. They are shared if both faces evaluate the same border. */

#include "../base/resize_to_fit.h"
#include "../base/tasks.h"
#include "patches.h"
#include "shared_border.h"
#include <algorithm>
#include <map>
#include <set>

namespace embree::isa {
class CageTopology {
public:
  /*! Rates and owners of a half-edge. Its corner is the vertex where it begins. */
  struct HalfEdgeData {
    unsigned ownRate;     //!< rate that the half-edge's face evaluates; noRate if the face does not participate
    unsigned rate;        //!< rate of the stored edge, the lowest of its faces
    uint32_t owner;       //!< index of the half-edge whose face owns the edge
    uint32_t cornerOwner; //!< index of the half-edge, at the same vertex, whose face owns the corner
  };

  explicit CageTopology(const SubdivMesh* mesh)
    : mesh(mesh),
      first(mesh->topology[0].halfEdges.data()),
      halfEdges(mesh->device, 0) {}

  template<typename Progress>
  void find(size_t facesPerTask, const Progress& progress) {
    cbvh::resizeToFit(halfEdges, countHalfEdges());
    forFaces(facesPerTask, progress, [&](size_t f) { findRates(f); });
    forFaces(facesPerTask, progress, [&](size_t f) { findOwners(f); });
    joinWithoutOpposite();
  }

  size_t numHalfEdges() const { return halfEdges.size(); }
  uint32_t indexOf(const HalfEdge* h) const { return uint32_t(h - first); }
  const HalfEdge* halfEdge(uint32_t i) const { return first + i; }
  const HalfEdgeData& at(const HalfEdge* h) const { return halfEdges[indexOf(h)]; }
  const HalfEdgeData& at(uint32_t i) const { return halfEdges[i]; }
  bool participates(size_t f) const { return hasEdges(mesh, f) && participates(mesh->getHalfEdge(0, f)); }
  bool ownsCorner(uint32_t i) const { return halfEdges[i].cornerOwner == i; }
  bool ownsEdge(uint32_t i) const { return halfEdges[i].owner == i; }

  /*! Calls closure for each half-edge of a participating face. */
  template<typename Closure>
  void forEachEdge(size_t f, const Closure& closure) const {
    if (!participates(f)) return;
    const HalfEdge* h = mesh->getHalfEdge(0, f);
    for (unsigned i = 0; i < h->numEdges(); i++) closure(h + i);
  }

private:
  static const unsigned noRate = 0;
  typedef std::pair<uint64_t, uint32_t> KeyedEdge; //!< both vertices of an edge, and the index of a half-edge

  template<typename Progress, typename Closure>
  void forFaces(size_t facesPerTask, const Progress& progress, const Closure& closure) const {
    forRanges(mesh->size(), facesPerTask, [&](const range<size_t>& faces) {
      for (size_t f = faces.begin(); f != faces.end(); f++) closure(f);
      progress();
    });
  }

  /*! Index of the last face's last half-edge, plus 1. Embree's array of half-edges can have more entries. */
  size_t countHalfEdges() const {
    for (size_t f = mesh->size(); f-- > 0;)
      if (hasEdges(mesh, f)) return indexOf(mesh->getHalfEdge(0, f)) + mesh->faceVertices[f];
    return 0;
  }

  HalfEdgeData& dataOf(const HalfEdge* h) { return halfEdges[indexOf(h)]; }
  bool participates(const HalfEdge* h) const { return at(h).ownRate != noRate; }

  void findRates(size_t f) {
    if (!hasEdges(mesh, f)) return;
    const HalfEdge* h = mesh->getHalfEdge(0, f);
    const unsigned n = mesh->faceVertices[f];
    for (unsigned i = 0; i < n; i++) dataOf(h + i) = HalfEdgeData();
    if (!hasSurface(mesh, f)) return;
    forEachPatch(mesh, f, [&](const PatchOfFace& patch) {
      for (unsigned s = 0; s < 4; s++)
        if (n == 4) dataOf(h + s).ownRate = unsigned(patch.rate[s]);
        else if (s == 0) dataOf(h + patch.subPatch).ownRate = 2 * unsigned(patch.rate[s]);
    });
  }

  uint64_t edgeClaim(const HalfEdge* h) const { return claimOf(at(h).ownRate, indexOf(h)); }
  uint64_t cornerClaim(const HalfEdge* h) const { return claimOf(0, indexOf(h)); }
  static uint32_t ownerOf(uint64_t claim) { return uint32_t(claim); }

  void findOwners(size_t f) {
    forEachEdge(f, [&](const HalfEdge* e) {
      HalfEdgeData& own = dataOf(e);
      uint64_t claim = edgeClaim(e);
      own.rate = own.ownRate;
      if (e->hasOpposite() && participates(e->opposite())) {
        claim = min(claim, edgeClaim(e->opposite()));
        own.rate = min(own.ownRate, at(e->opposite()).ownRate);
      }
      own.owner = ownerOf(claim);
      claim = cornerClaim(e);
      forEachAtVertex(e, [&](const HalfEdge* a) { claim = min(claim, cornerClaim(a)); });
      own.cornerOwner = ownerOf(claim);
    });
  }

  /*! Calls closure for all half-edges, e included, that begin at e's vertex, belong to participating faces and are
   *  reached by crossing edges. */
  template<typename Closure>
  void forEachAtVertex(const HalfEdge* e, const Closure& closure) const {
    const HalfEdge* a = e;
    do {
      if (participates(a)) closure(a);
      if (!a->hasOpposite()) break;
      a = a->rotate();
    } while (a != e);
    if (a == e && e->hasOpposite()) return;
    for (a = e; a->prev()->hasOpposite();) {
      a = a->prev()->opposite();
      if (participates(a)) closure(a);
    }
  }

  /*! True if two half-edges, the only ones at their edge and without an opposite, are borders of equal shape. */
  bool haveSameShape(const HalfEdge* a, const HalfEdge* b) const {
    if (mesh->displFunc) return false;
    return BorderEnd(a, false) == BorderEnd(b, false) && BorderEnd(a, true) == BorderEnd(b, true);
  }

  /*! The next vertex at one end of a border, and the creases there in the faces that are reached by crossing edges.
   *  With the border's vertices, they determine its shape. */
  struct BorderEnd {
    unsigned nextVertex;
    float vertexCrease;
    bool hasEdgeCreases;

    BorderEnd(const HalfEdge* border, bool atEnd)
      : vertexCrease((atEnd ? border->next() : border)->vertex_crease_weight),
        hasEdgeCreases(false) {
      const HalfEdge* e = atEnd ? border->next() : border->prev();
      for (; e->hasOpposite(); e = atEnd ? e->opposite()->next() : e->opposite()->prev())
        hasEdgeCreases |= e->edge_crease_weight > 0.0f;
      nextVertex = (atEnd ? e->next() : e)->getStartVertexIndex();
    }

    bool operator==(const BorderEnd& other) const {
      return nextVertex == other.nextVertex && vertexCrease == other.vertexCrease && !hasEdgeCreases &&
             !other.hasEdgeCreases;
    }
  };

  /*! Also returns half-edges of faces that do not participate, for example with vertices that are not finite.
   *  Embree counts them, but not holes, to find non-manifold edges. */
  std::vector<KeyedEdge> halfEdgesWithoutOpposite() const {
    const std::vector<unsigned> holes = sortedHoles(mesh);
    std::vector<KeyedEdge> found;
    for (size_t f = 0; f < mesh->size(); f++) {
      if (mesh->faceVertices[f] < 2 || std::binary_search(holes.begin(), holes.end(), unsigned(f))) continue;
      const HalfEdge* h = mesh->getHalfEdge(0, f);
      for (unsigned i = 0; i < mesh->faceVertices[f]; i++)
        if (!h[i].hasOpposite()) found.push_back({uint64_t(h[i].getEdge()), indexOf(h + i)});
    }
    return found;
  }

  /*! Sets one owner and rate for the half-edges of an edge of three or more faces, or of two borders of equal
   *  shape, and one corner owner for each of its ends. */
  void joinWithoutOpposite() {
    std::vector<KeyedEdge> borders = halfEdgesWithoutOpposite();
    std::sort(borders.begin(), borders.end());
    std::map<unsigned, std::set<uint32_t>> owners; // owners of corners, by vertex
    for (size_t begin = 0, end = 0; begin < borders.size(); begin = end) {
      while (end < borders.size() && borders[end].first == borders[begin].first) end++;
      const auto isLeftOut = [&](const KeyedEdge& edge) { return halfEdges[edge.second].ownRate == noRate; };
      const size_t joinedEnd =
          std::remove_if(borders.begin() + begin, borders.begin() + end, isLeftOut) - borders.begin();
      if (joinedEnd - begin < 2) continue;
      if (end - begin == 2 && !haveSameShape(first + borders[begin].second, first + borders[begin + 1].second))
        continue;
      joinEdges(borders.data() + begin, borders.data() + joinedEnd);
      for (size_t i = begin; i < joinedEnd; i++)
        for (const HalfEdge* h : {first + borders[i].second, first[borders[i].second].next()})
          owners[h->getStartVertexIndex()].insert(at(h).cornerOwner);
    }
    if (owners.empty()) return;
    for (uint32_t i = 0; i < halfEdges.size(); i++) {
      const auto found = owners.find(first[i].getStartVertexIndex());
      if (halfEdges[i].ownRate == noRate || found == owners.end()) continue;
      uint32_t& owner = halfEdges[i].cornerOwner;
      if (found->second.count(owner)) owner = *found->second.begin();
    }
  }

  void joinEdges(const KeyedEdge* begin, const KeyedEdge* end) {
    uint64_t claim = ~uint64_t(0);
    for (const KeyedEdge* i = begin; i < end; i++) claim = min(claim, claimOf(halfEdges[i->second].ownRate, i->second));
    for (const KeyedEdge* i = begin; i < end; i++) {
      halfEdges[i->second].owner = ownerOf(claim);
      halfEdges[i->second].rate = halfEdges[ownerOf(claim)].ownRate;
    }
  }

  const SubdivMesh* const mesh;
  const HalfEdge* const first;
  mvector<HalfEdgeData> halfEdges; //!< by half-edge
};
} // namespace embree::isa
