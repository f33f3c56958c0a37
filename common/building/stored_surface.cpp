// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A file of its own, so that the linker leaves it out of cbvh_bench: that program defines the Embree functions that it
 * calls (embree_calls.h), but not these. */

#include "building/stored_surface.h"
#include "building/built_scene.h"
#include "building/surface_handles.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <cstring>

namespace programs {

bool storedTriangle(const TracedScene& scene, const FaceNumbers& faces, const SurfaceHit& hit, float time,
                    Vec3f vertices[3]) {
  if (!hit.hit()) return false;
  const unsigned geomID = faces.geomID(hit.face);
  CbvhTriangle triangle;
  const SurfaceHandle surface = surfaceOf(rtcGetGeometry(scene.handle(), geomID));
  const bool found =
      cbvhFindTriangle(surface.get(), time, faces.primID(hit.face), hit.u, hit.v, &hit.normal.x, &triangle) != 0;
  if (found) std::memcpy(vertices, triangle.vertices, sizeof(triangle.vertices));
  else scene.check();
  return found;
}

StoredMesh storedMesh(const TracedScene& scene, const FaceNumbers& faces, float time) {
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
  for (unsigned i = 0; i < faces.numGeometries(); i++) {
    collector.firstFace = faces.number(i, 0);
    cbvhForEachPart(surfaceOf(rtcGetGeometry(scene.handle(), i)).get(), time, Collector::add, &collector);
  }
  scene.check();
  throwIfCanceled();
  return std::move(collector.mesh);
}

void BuiltScene::requireTriangles(const char* operation) const {
  if (!builtAs.isExact() && builtAs.kind != RepresentationKind::CGrid)
    throw Error(std::string(operation) + ": " + builtAs.label() + " stores no triangles: expected cVERT or cGRID");
}

StoredMesh BuiltScene::storedMesh(float time) const {
  requireTriangles("reading the surface");
  return programs::storedMesh(*this, faces(), time);
}

} // namespace programs
