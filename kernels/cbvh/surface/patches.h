// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The patches of a cage's face: the face itself if it has four corners, otherwise one per corner. Also tests which
 * faces Embree can evaluate. */

#include "../embree/scene.h"
#include <algorithm>
#include <vector>

namespace embree::isa {
/*! Call this before getHalfEdge(), which returns a half-edge of the next face if a face has no edges. */
inline bool hasEdges(const SubdivMesh* mesh, size_t face) { return mesh->faceVertices[face] != 0; }

/*! True if the face has a surface at any time step. */
inline bool hasSurface(const SubdivMesh* mesh, size_t face) {
  if (!hasEdges(mesh, face)) return false;
  for (size_t t = 0; t < mesh->numTimeSteps; t++)
    if (mesh->valid(face, t)) return true;
  return false;
}

/*! True if Embree cannot evaluate the surface where an edge begins: a face there has fewer than 3 or more than 16
 *  corners, or the vertex has more than 1024 faces (1023 at a border) or more neighbors than a ring stores. */
inline bool isUnsupportedAtVertex(const HalfEdge* edge) {
  size_t faceValence = 0, edgeValence = 0;
  const HalfEdge* around = edge; // backwards around the vertex; at a border, continues at the vertex's other border
  do {
    const unsigned corners = around->numEdges();
    if (corners < 3 || corners > MAX_PATCH_VALENCE) return true;
    faceValence++;
    edgeValence += corners - 2;
    around = around->prev();
    if (around->hasOpposite()) {
      around = around->opposite();
      continue;
    }
    faceValence++; // at a border, rings store two more vertices
    edgeValence += 2;
    for (around = edge; around->hasOpposite();) around = around->opposite()->next();
  } while (around != edge);
  return faceValence > MAX_RING_FACE_VALENCE || edgeValence > MAX_RING_EDGE_VALENCE;
}

/*! True if Embree can evaluate a face. corners: number of half-edges from `first`. */
inline bool canBeEvaluated(const HalfEdge* first, unsigned corners) {
  if (corners < 3) return false; // next() of a face's only half-edge is invalid
  const HalfEdge* edge = first;
  while (!isUnsupportedAtVertex(edge))
    if ((edge = edge->next()) == first) return true;
  return false;
}

/*! Returns the holes of a cage in ascending order, for isUnsupported(). */
inline std::vector<unsigned> sortedHoles(const SubdivMesh* mesh) {
  std::vector<unsigned> holes(mesh->holes.size());
  for (size_t i = 0; i < holes.size(); i++) holes[i] = mesh->holes[i];
  std::sort(holes.begin(), holes.end());
  return holes;
}

/*! True if Embree cannot evaluate a face, whatever its vertices are. False for holes and faces without corners.
 *  holes: see sortedHoles(). */
inline bool isUnsupported(const SubdivMesh* mesh, size_t face, const std::vector<unsigned>& holes) {
  if (!hasEdges(mesh, face) || canBeEvaluated(mesh->getHalfEdge(0, face), mesh->faceVertices[face])) return false;
  return !std::binary_search(holes.begin(), holes.end(), unsigned(face));
}

const unsigned noVertex = ~0u;

/*! Returns a vertex that is not finite, or noVertex, among those that a face's surface depends on at a time step:
 *  the vertices of all faces at its corners. Requires canBeEvaluated(). */
inline unsigned findInvalidVertex(const SubdivMesh* mesh, size_t face, size_t timeStep) {
  const BufferView<Vec3fa>& vertices = mesh->vertices[timeStep];
  const HalfEdge* const first = mesh->getHalfEdge(0, face);
  const HalfEdge* corner = first;
  do {
    const HalfEdge* around = corner; // as in isUnsupportedAtVertex()
    do {
      const HalfEdge* edge = around;
      do {
        const unsigned i = edge->getStartVertexIndex();
        if (i >= vertices.size() || !isvalid(Vec3fa(vertices[i]))) return i;
        edge = edge->next();
      } while (edge != around);
      around = around->prev();
      if (around->hasOpposite()) {
        around = around->opposite();
        continue;
      }
      for (around = corner; around->hasOpposite();) around = around->opposite()->next();
    } while (around != corner);
    corner = corner->next();
  } while (corner != first);
  return noVertex;
}

/*! The same at all time steps. timeStep: set if a vertex is found. */
inline unsigned findInvalidVertex(const SubdivMesh* mesh, size_t face, unsigned& timeStep) {
  for (unsigned t = 0; t < mesh->numTimeSteps; t++) {
    const unsigned vertex = findInvalidVertex(mesh, face, size_t(t));
    if (vertex != noVertex) {
      timeStep = t;
      return vertex;
    }
  }
  return noVertex;
}

/*! Arguments of Embree's SubdivPatch1Base, which make() constructs. The pointers are valid while forEachPatch's
 *  closure runs. */
struct PatchOfFace {
  const Vec2f* uv;        //!< face parameters of the 4 corners
  const int* subdiv;      //!< per edge: 1 if the rate must be even, because the adjacent face is not a quad
  const float* edgeLevel; //!< level per edge: the application's, or half of it for patches of n-gons
  int subPatch;           //!< corner of the face; 0 for four-cornered faces
  float rate[4];          //!< of the edges v = 0, u = 1, v = 1, u = 0

  SubdivPatch1Base make(const SubdivMesh* mesh, uint32_t surfaceNumber, size_t face, unsigned timeStep = 0) const {
    return SubdivPatch1Base(surfaceNumber, unsigned(face), unsigned(subPatch), mesh, timeStep, uv, edgeLevel, subdiv,
                            VSIZEX);
  }
};

/*! Calls closure(const PatchOfFace&) for each patch, in the order of corners. Requires canBeEvaluated(), which
 *  hasSurface() implies. */
template<typename Closure>
inline void forEachPatch(const SubdivMesh* mesh, size_t face, const Closure& closure) {
  patch_eval_subdivision(mesh->getHalfEdge(0, face),
                         [&](const Vec2f uv[4], const int subdiv[4], const float edgeLevel[4], int subPatch) {
                           PatchOfFace patch = {uv, subdiv, edgeLevel, subPatch, {}};
                           SubdivPatch1Base::computeEdgeLevels(edgeLevel, subdiv, patch.rate);
                           closure(patch);
                         });
}

/*! Half-edge of side s, in the order of PatchOfFace::rate, or null for an n-gon's spoke. */
inline const HalfEdge* edgeOfSide(const SubdivMesh* mesh, size_t face, int subPatch, int s) {
  const HalfEdge* h = mesh->getHalfEdge(0, face);
  const unsigned n = h->numEdges();
  if (n == 4) return h + s;
  return s == 0 ? h + subPatch : s == 3 ? h + (subPatch + n - 1) % n : nullptr;
}

/*! Returns a bit mask of the sides where the surface ends or is creased, or which have so few quads that it may
 *  bend as sharply. */
inline uint32_t sharpSidesOf(const SubdivMesh* mesh, size_t face, const PatchOfFace& patch) {
  const float smooth = 32.0f; // quads along a side
  uint32_t sharp = 0;
  for (int s = 0; s < 4; s++) {
    const HalfEdge* h = edgeOfSide(mesh, face, patch.subPatch, s);
    const bool isSharp = patch.rate[s] < smooth || (h && (!h->hasOpposite() || h->edge_crease_weight > 0.0f));
    sharp |= uint32_t(isSharp) << s;
  }
  return sharp;
}
} // namespace embree::isa
