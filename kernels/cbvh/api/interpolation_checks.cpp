// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The commit marks the first half-edge of faces that Embree cannot evaluate, because the input may be released before
 * the first interpolation. In a face with four corners, (u,v) outside of 0 to 1 extrapolates the surface. In other
 * faces, (u,v) must select an existing sub-patch. */

#include "interpolation_checks.h"
#include "../base/number_text.h"
#include "../surface/patches.h"

namespace embree {
namespace {
const HalfEdge::PatchType unsupportedPatch = HalfEdge::PatchType(4); //!< a value that Embree does not use

/*! Other patch types are always supported: their vertices have at most 4 faces, all quads, or Embree does not read
 *  the rings of faces around them. */
bool mayBeUnsupported(HalfEdge::PatchType type) {
  return type == HalfEdge::COMPLEX_PATCH || type == HalfEdge::IRREGULAR_QUAD_PATCH;
}

/*! Null for a face that does not exist or has no edges, and if the topology was not committed. */
const HalfEdge* firstEdge(const SubdivMesh* mesh, const SubdivMesh::Topology& topology, unsigned face) {
  if (face >= mesh->size() || topology.halfEdges.size() == 0) return nullptr;
  if (mesh->faceVertices && !isa::hasEdges(mesh, face)) return nullptr;
  const HalfEdge* const edge = topology.getHalfEdge(face);
  /* input is released: a face without edges has the same first edge as the next face */
  if (!mesh->faceVertices && face + 1 < mesh->size() && edge == topology.getHalfEdge(face + 1)) return nullptr;
  return edge < topology.halfEdges.end() ? edge : nullptr;
}

void requireFace(const SubdivMesh* mesh, const SubdivMesh::Topology& topology, unsigned face) {
  const HalfEdge* const edge = firstEdge(mesh, topology, face);
  if (likely(edge && edge->patch_type != unsupportedPatch)) return;
  const std::string name = "face " + std::to_string(face) + " cannot be interpolated: ";
  if (face >= mesh->size())
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, name + "the geometry has " + std::to_string(mesh->size()) + " faces");
  if (topology.halfEdges.size() == 0)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION, name + "its topology was not committed");
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                 name + "it, or a face at its vertices, has fewer than 3 or more than " +
                     std::to_string(MAX_PATCH_VALENCE) + " vertices, or a vertex has more than " +
                     std::to_string(MAX_RING_FACE_VALENCE) + " faces (" + std::to_string(MAX_RING_FACE_VALENCE - 1) +
                     " at a border, fewer if these have more than 4 corners)");
}

/*! Throws if (u,v) is in no sub-patch of a face without four corners. Embree selects the sub-patch of corner i + 4
 *  j for u from 2 i to 2 i + 2 and v from 2 j to 2 j + 2; the surface is from 2 i + 0.5 to 2 i + 1.5. */
void requireSubPatch(const SubdivMesh::Topology& topology, unsigned face, float u, float v) {
  const HalfEdge* const edge = topology.getHalfEdge(face);
  if (likely(edge->patch_type != HalfEdge::COMPLEX_PATCH)) return; // the face has four corners
  const unsigned corners = edge->numEdges();
  if (corners == 4) return;
  if (u >= 0.0f && u < 8.0f && v >= 0.0f && v < 8.0f && unsigned(0.5f * u) + 4 * unsigned(0.5f * v) < corners) return;
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "face " + std::to_string(face) + " cannot be interpolated at u " +
                                                 numberText(u) + ", v " + numberText(v) + ": expected one of its " +
                                                 std::to_string(corners) + " sub-patches, as hits number them");
}

template<typename Arguments>
const SubdivMesh::Topology& topologyOf(const SubdivMesh* mesh, const Arguments* args) {
  const bool isAttribute = args->bufferType == RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
  return mesh->topology[isAttribute ? mesh->vertexAttribs[args->bufferSlot].userData : 0];
}
} // namespace

void markUnsupportedFaces(SubdivMesh* mesh) {
  if (!mesh->faceVertices) return; // input is released; faces are already marked
  for (SubdivMesh::Topology& topology : mesh->topology) {
    if (topology.halfEdges.size() == 0) continue;
    parallel_for(size_t(0), mesh->numFaces(), size_t(4096), [&](const range<size_t>& r) {
      for (size_t f = r.begin(); f != r.end(); f++) {
        if (!isa::hasEdges(mesh, f)) continue;
        HalfEdge& first = const_cast<HalfEdge&>(*topology.getHalfEdge(f));
        if (mayBeUnsupported(first.patch_type) && !isa::canBeEvaluated(&first, mesh->faceVertices[f]))
          first.patch_type = unsupportedPatch;
      }
    });
  }
}

void requireSupported(const SubdivMesh* mesh, const RTCInterpolateArguments* args) {
  const SubdivMesh::Topology& topology = topologyOf(mesh, args);
  requireFace(mesh, topology, args->primID);
  requireSubPatch(topology, args->primID, args->u, args->v);
}

void requireSupported(const SubdivMesh* mesh, const RTCInterpolateNArguments* args) {
  const SubdivMesh::Topology& topology = topologyOf(mesh, args);
  const int* const valid = (const int*)args->valid;
  const unsigned* checked = nullptr; // a pointer, because no number can mean none
  for (unsigned i = 0; i < args->N; i++) {
    if (valid && valid[i] != -1) continue;
    if (!checked || args->primIDs[i] != *checked) requireFace(mesh, topology, args->primIDs[i]);
    checked = args->primIDs + i;
    requireSubPatch(topology, *checked, args->u[i], args->v[i]);
  }
}
} // namespace embree
