// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A file of its own, so that the linker leaves it out of cbvh_bench: that program defines the Embree functions that it
 * calls (embree_calls.h), but not these. */

#include "building/built_scene.h"
#include "building/surface_handles.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <cstring>

namespace programs {
namespace {

bool hasTriangles(const Representation& r) { return r.isExact() || r.kind == RepresentationKind::CGrid; }

} // namespace

bool BuiltScene::triangleOf(const SurfaceHit& hit, float time, Vec3f vertices[3]) const {
  if (!hasTriangles(builtAs))
    throw Error("looking up a triangle: " + builtAs.label() + " stores no triangles: expected cVERT or cGRID");
  if (!hit.hit()) return false;
  CbvhTriangle triangle;
  const SurfaceHandle surface = surfaceOf(rtcGetGeometry(scene.get(), unsigned(hit.face / facesPerCopy)));
  const bool found = cbvhFindTriangle(surface.get(), time, unsigned(hit.face % facesPerCopy), hit.u, hit.v,
                                      &hit.normal.x, &triangle) != 0;
  if (found) std::memcpy(vertices, triangle.vertices, sizeof(triangle.vertices));
  else device->check("looking up a triangle");
  return found;
}

StoredMesh BuiltScene::storedMesh(float time) const {
  if (!hasTriangles(builtAs))
    throw Error("reading the surface: " + builtAs.label() + " stores no triangles: expected cVERT or cGRID");
  struct Collector {
    StoredMesh mesh;
    size_t firstFace = 0; // of the geometry whose parts are added

    static int add(void* self, const CbvhPart* part) {
      Collector& collector = *static_cast<Collector*>(self);
      StoredMesh& mesh = collector.mesh;
      const unsigned first = unsigned(mesh.vertices.size()), width = part->width;
      for (unsigned i = 0; i < width * part->height; i++)
        mesh.vertices.push_back({part->vertices[3 * i], part->vertices[3 * i + 1], part->vertices[3 * i + 2]});
      for (unsigned y = 0; y + 1 < part->height; y++)
        for (unsigned x = 0; x + 1 < width; x++) {
          const unsigned i = first + y * width + x;
          mesh.quads.push_back({i, i + 1, i + width + 1, i + width});
          const unsigned quad = (y * (width - 1) + x) * part->primitivesPerQuad;
          mesh.faces.push_back(unsigned(collector.firstFace + (part->primIDs ? part->primIDs[quad] : part->primID)));
        }
      return !cancelRequested();
    }
  } collector;
  for (size_t i = 0; i < numGeometries; i++) {
    collector.firstFace = i * facesPerCopy;
    cbvhForEachPart(surfaceOf(rtcGetGeometry(scene.get(), unsigned(i))).get(), time, Collector::add, &collector);
  }
  device->check("reading the surface");
  throwIfCanceled();
  return std::move(collector.mesh);
}

} // namespace programs
