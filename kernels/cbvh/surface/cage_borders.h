// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices on the borders of a cage's faces, by the rule in shared_border.h. Without it, two faces evaluate a shared
 * vertex some ulps (units in the last place) apart, and far apart where normals differ or a height map jumps.
 * cage_topology.h finds the owners.
 *
 * An n-gon (a face without four corners) has a patch at each corner. Only these patches share its center and the spokes
 * from there to the middles of its edges.
 *
 * Borders and middle lines of patches (all vertices for maxPixelError) are evaluated before any patch is encoded, and
 * again with their patch: 9% of all vertices at 64 x 64 quads. Owned vertices, 3%, take 12 bytes each until all patches
 * are encoded. Evaluating the border of a small patch costs as much as the whole patch, so small surfaces cache all
 * vertices for their blocks. */

#include "border_lattices.h"
#include "cage_side.h"
#include "cage_topology.h"
#include "patch_evaluator.h"

namespace embree::isa {
class CageBorders {
public:
  typedef PatchEvaluator Scratch;

  CageBorders(const SubdivMesh* mesh, const CompressionPlan& plan)
    : plan(plan),
      mesh(mesh),
      topology(mesh),
      lattices(mesh->device, plan),
      firstPoints(mesh->device, 0),
      points(mesh->device, 0),
      firstCached(mesh->device, 0),
      cached(mesh->device, 0) {}

  template<typename Progress>
  void build(size_t facesPerTask, const Progress& progress) {
    topology.find(facesPerTask, progress);
    allocatePoints();
    if (plan.kind() == cbvh::Kind::CVERT) allocateCache();
    lattices.chooseForPrimitives(*this, facesPerTask, progress);
    lattices.chooseForShared(*this, 2 * topology.numHalfEdges(), facesPerTask, progress);
  }

  /*! Exponent of the spacing of a face's lattice. */
  int exponent(size_t face, unsigned step) const { return lattices.ofPrimitive(face, step); }

  /*! Returns a patch's vertices as build() evaluated them, before borders are shared, row by row. Null unless the
   *  surface is small, and stored as cVERT. */
  const float (*cachedVertices(size_t face, int subPatch, unsigned step) const)[3] {
    return firstCached.size() ? (const float(*)[3])cached.data() + step * numCached + firstOf(face, subPatch) : nullptr;
  }

  /*! Returns the shared vertices along a side of a patch. s: side, in the order of PatchOfFace::rate. */
  CageSide side(size_t face, int subPatch, int s, unsigned step) const {
    const HalfEdge* edge = edgeOfSide(mesh, face, subPatch, s);
    if (isQuad(mesh->getHalfEdge(0, face))) return edgeOf(edge, step);
    switch (s) {
    case 0: return edgeOf(edge, step).half(0);
    case 1: return spoke(face, edgeOfSide(mesh, face, subPatch, 0), false, step);
    case 2: return spoke(face, edgeOfSide(mesh, face, subPatch, 3), true, step);
    default: return edgeOf(edge, step).half(1);
    }
  }

  /* Topology of border_lattices.h. Elements are corners and interiors of owned edges. */

  size_t size() const { return mesh->size(); }
  double spacingPerEdge() const { return 0; }

  void extendBounds(size_t f, unsigned step, BBox3fa& bounds) const {
    topology.forEachEdge(f, [&](const HalfEdge* h) {
      const Vec3fa p = mesh->getVertexBuffer(step)[h->getStartVertexIndex()];
      if (cbvh::isFinite(&p.x)) bounds.extend(p);
    });
  }

  /*! Also stores the points that the face owns, and its cached vertices. */
  bool addLines(size_t f, unsigned step, PatchEvaluator& evaluator, LatticeChoice& choice) {
    if (!topology.participates(f)) return false;
    if (!mesh->valid(f, step)) {
      invalidateCached(f, step);
      return false;
    }
    forEachPatch(mesh, f, [&](const PatchOfFace& patch) {
      const SubdivPatch1Base base = patch.make(mesh, plan.surfaceNumber, f, step);
      const unsigned quads[2] = {unsigned(base.grid_u_res - 1), unsigned(base.grid_v_res - 1)};
      choice.addPatch(quads);
      float local[maxLocalVertices][3];
      float(*all)[3] = cachedVertices(f, patch.subPatch, step);
      if (!all && (quads[0] + 1) * (quads[1] + 1) <= maxLocalVertices) all = local;
      PatchLines lines(mesh, base, evaluator, quads, all);
      for (unsigned s = 0; s < 4; s++) {
        const bool alongU = s % 2 == 0;
        const unsigned fine = quads[alongU ? 0 : 1], across = quads[alongU ? 1 : 0];
        const PatchLines::Line line = lines(alongU, s == 1 || s == 2 ? across : 0);
        choice.addLine(alongU, line.vertices, line.count, fine != unsigned(patch.rate[s]));
        storeOwnedPoints(f, patch, s, line.vertices, fine, step);
      }
      for (bool alongU : {true, false}) {
        if (quads[alongU ? 1 : 0] < 2) continue;
        const PatchLines::Line line = lines(alongU, quads[alongU ? 1 : 0] / 2);
        choice.addLine(alongU, line.vertices, line.count);
      }
      if (plan.settings.maxPixelError > 0) addVertices(base, quads, evaluator, choice);
    });
    return true;
  }

  template<typename Closure>
  void forEachShared(size_t f, const Closure& closure) const {
    topology.forEachEdge(f, [&](const HalfEdge* h) {
      const CageTopology::HalfEdgeData& edge = topology.at(h);
      for (size_t element : {cornerElement(edge), edgeElement(edge)}) closure(element);
    });
  }

private:
  static const size_t maxCached = 1 << 15; //!< vertices of all time steps together; 12 bytes each
  /*! Evaluating the lines of so small a patch costs as much as all of it. */
  static const size_t maxLocalVertices = 9 * 9;

  static bool isQuad(const HalfEdge* h) { return h->numEdges() == 4; }
  static size_t cornerElement(const CageTopology::HalfEdgeData& edge) { return 2 * size_t(edge.cornerOwner); }
  static size_t edgeElement(const CageTopology::HalfEdgeData& edge) { return 2 * size_t(edge.owner) + 1; }

  /* `points` lists, for each half-edge in order: its corner and the interior of its edge if it owns them, then its
   * spoke; then, after the last half-edge of an n-gon, the center. For other half-edges, centerPoint() is the end
   * of their points. */
  size_t edgePoints(uint32_t i) const { return topology.ownsEdge(i) ? topology.at(i).rate - 1 : 0; }
  size_t spokePoints(const HalfEdge* h) const { return isQuad(h) ? 0 : topology.at(h).ownRate / 2 - 1; }
  size_t cornerPoint(uint32_t owner) const { return firstPoints[owner]; }
  size_t firstEdgePoint(uint32_t owner) const { return firstPoints[owner] + topology.ownsCorner(owner); }
  size_t firstSpokePoint(uint32_t i) const { return firstEdgePoint(i) + edgePoints(i); }
  size_t centerPoint(const HalfEdge* last) const { return firstSpokePoint(topology.indexOf(last)) + spokePoints(last); }
  float* point(size_t i, unsigned step) { return points.data() + 3 * (step * numPoints + i); }
  const float* point(size_t i, unsigned step) const { return points.data() + 3 * (step * numPoints + i); }

  void allocatePoints() {
    cbvh::resizeToFit(firstPoints, topology.numHalfEdges());
    for (size_t f = 0; f < mesh->size(); f++)
      topology.forEachEdge(f, [&](const HalfEdge* h) {
        firstPoints[topology.indexOf(h)] = numPoints;
        numPoints = centerPoint(h) + (!isQuad(h) && h->next() == mesh->getHalfEdge(0, f));
      });
    cbvh::resizeToFit(points, 3 * numPoints * plan.numTimeSteps);
    if (plan.moves()) // a face without a surface at a step does not set its points
      std::fill(points.begin(), points.end(), std::numeric_limits<float>::quiet_NaN());
  }

  /*! Allocates memory for all vertices if the surface has few. */
  void allocateCache() {
    const size_t limit = maxCached / plan.numTimeSteps;
    if (mesh->size() > limit / 4) return;
    mvector<uint32_t> firsts(mesh->device, topology.numHalfEdges());
    size_t n = 0;
    for (size_t f = 0; f < mesh->size() && n <= limit; f++)
      if (topology.participates(f))
        forEachPatch(mesh, f, [&](const PatchOfFace& patch) {
          firsts[topology.indexOf(mesh->getHalfEdge(0, f)) + patch.subPatch] = uint32_t(n);
          n += verticesOf(patch);
        });
    if (n > limit) return;
    numCached = n;
    cbvh::resizeToFit(cached, 3 * n * plan.numTimeSteps);
    firstCached = std::move(firsts);
  }

  static size_t verticesOf(const PatchOfFace& patch) {
    const Vec2i size = SubdivPatch1Base::computeGridSize(patch.rate);
    return size_t(size.x) * size_t(size.y);
  }

  /*! Index of a patch's first vertex among the cached vertices of a time step. */
  size_t firstOf(size_t face, int subPatch) const {
    return firstCached[topology.indexOf(mesh->getHalfEdge(0, face)) + subPatch];
  }
  float (*cachedVertices(size_t face, int subPatch, unsigned step))[3] {
    return (float(*)[3])((const CageBorders*)this)->cachedVertices(face, subPatch, step);
  }

  /*! Sets cached vertices of a face to NaN, because a vertex of the cage is not finite at that step. */
  void invalidateCached(size_t f, unsigned step) {
    if (firstCached.size())
      forEachPatch(mesh, f, [&](const PatchOfFace& patch) {
        float* const all = cachedVertices(f, patch.subPatch, step)[0];
        std::fill(all, all + 3 * verticesOf(patch), std::numeric_limits<float>::quiet_NaN());
      });
  }

  /*! Extends the bounds for maxPixelError by all vertices of a patch. */
  void addVertices(const SubdivPatch1Base& base, const unsigned quads[2], PatchEvaluator& evaluator,
                   LatticeChoice& choice) const {
    const unsigned rows = 16; // per part, to limit the memory
    for (unsigned y = 0; y <= quads[1]; y += rows) {
      evaluator.evalPart(base, mesh, quads[0], quads[1], {0, quads[0], y, min(y + rows - 1, quads[1])});
      for (size_t i = 0; i < evaluator.width * evaluator.height; i++) choice.extendBounds(evaluator.displaced()[i]);
    }
  }

  /*! Stores the points of side s that the face owns. line: fine+1 vertices along u or v. */
  void storeOwnedPoints(size_t f, const PatchOfFace& patch, unsigned s, const float (*line)[3], unsigned fine,
                        unsigned step) {
    const unsigned own = unsigned(patch.rate[s]);
    const bool descends = s >= 2;
    /* Stores vertex k of the side, counted around the patch, as point i. It is the line's first vertex that is
     * stitched to k. */
    auto store = [&](size_t i, unsigned k) {
      memcpy(point(i, step), line[min(firstStitched(descends ? own - k : k, fine, own), fine)], sizeof(*line));
    };

    const HalfEdge* h = mesh->getHalfEdge(0, f);
    const unsigned n = h->numEdges();
    const HalfEdge* const edge = n == 4 ? h + s : s < 2 ? h + patch.subPatch : h + (patch.subPatch + n - 1) % n;
    const uint32_t e = topology.indexOf(edge);
    if (n != 4 && s == 1) {
      for (unsigned k = 1; k < own; k++) store(firstSpokePoint(e) + k - 1, k);
      if (patch.subPatch == 0) store(centerPoint(h + n - 1), own);
    }
    if (n != 4 && (s == 1 || s == 2)) return;
    if ((n == 4 || s == 0) && topology.ownsCorner(e)) store(cornerPoint(e), 0);
    if (!topology.ownsEdge(e)) return;
    /* A patch of an n-gon has half of the edge; the first half includes the middle. */
    const unsigned rate = n == 4 ? topology.at(e).rate : topology.at(e).rate / 2;
    const unsigned end = n != 4 && s == 0 ? rate + 1 : rate;
    const size_t first = firstEdgePoint(e) + (n != 4 && s == 3 ? rate : 0);
    for (unsigned k = 1; k < end; k++) store(first + k - 1, nearestVertex(k, rate, own));
  }

  SharedVertex corner(const HalfEdge* h, unsigned step) const {
    const CageTopology::HalfEdgeData& edge = topology.at(h);
    return SharedVertex(point(cornerPoint(edge.cornerOwner), step), lattices.ofShared(cornerElement(edge), step));
  }

  CageSide edgeOf(const HalfEdge* h, unsigned step) const {
    const CageTopology::HalfEdgeData& edge = topology.at(h);
    CageSide side;
    side.begin = corner(h, step);
    side.end = corner(h->next(), step);
    side.interior = (const float(*)[3])point(firstEdgePoint(edge.owner), step);
    side.isReversed = edge.owner != topology.indexOf(h) &&
                      topology.halfEdge(edge.owner)->getStartVertexIndex() != h->getStartVertexIndex();
    side.exponent = lattices.ofShared(edgeElement(edge), step);
    side.rate = edge.rate;
    return side;
  }

  /*! Returns the side of an n-gon's patch between the middle of edge h and the center of the face. */
  CageSide spoke(size_t face, const HalfEdge* h, bool fromCenter, unsigned step) const {
    const HalfEdge* start = mesh->getHalfEdge(0, face);
    const CageSide edge = edgeOf(h, step);
    CageSide side;
    side.exponent = exponent(face, step);
    const SharedVertex middle = edge[edge.rate / 2];
    const SharedVertex center(point(centerPoint(start + start->numEdges() - 1), step), side.exponent);
    side.begin = fromCenter ? center : middle;
    side.end = fromCenter ? middle : center;
    side.interior = (const float(*)[3])point(firstSpokePoint(topology.indexOf(h)), step);
    side.isReversed = fromCenter;
    side.rate = topology.at(h).ownRate / 2;
    return side;
  }

  const CompressionPlan& plan;
  const SubdivMesh* const mesh;
  CageTopology topology;
  BorderLattices lattices;
  size_t numPoints = 0, numCached = 0; //!< counts per time step
  mvector<size_t> firstPoints;         //!< index of the first point, by half-edge
  mvector<float> points;               //!< points, step by step
  mvector<uint32_t> firstCached;       //!< by the half-edge of a patch's corner; empty unless the surface is small
  mvector<float> cached;               //!< all vertices of a small surface, step by step
};
} // namespace embree::isa
