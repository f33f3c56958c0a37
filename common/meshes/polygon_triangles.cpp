// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Ear clipping: a corner is an ear if it is convex and its triangle contains no other vertex. Every polygon without
 * self-intersections has one (Meisters: Polygons have ears, 1975). */

#include "meshes/polygon_triangles.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <algorithm>
#include <string>
#include <utility>

namespace programs {
namespace {

/* Twice the area vector of a polygon (Newell). Its direction is the normal. */
Vec3d areaVector(const PolygonMesh& mesh, const unsigned* corners, unsigned count) {
  const Vec3d origin = mesh.positions[corners[0]];
  Vec3d sum, last = mesh.positions[corners[count - 1]] - origin;
  for (unsigned i = 0; i < count; i++) {
    const Vec3d next = mesh.positions[corners[i]] - origin;
    sum += cross(last, next);
    last = next;
  }
  return sum;
}

class EarClipper {
public:
  /* Passes count - 2 triangles, as positions in `corners`, to emit(a, b, c). */
  template<typename Emit>
  void split(const PolygonMesh& mesh, const unsigned* corners, unsigned count, const Emit& emit) {
    project(mesh, corners, count);
    std::vector<unsigned> bends; // corners that may lie in the triangle of another one
    for (unsigned i = 0; i < count; i++)
      if (!(turn(previous[i], i, next[i]) > 0.0)) bends.push_back(i);
    unsigned left = count, at = 0, tried = 0;
    for (; left > 3; tried++) {
      /* After a round without ears, only corners on a line, or a polygon that intersects itself, are left. */
      if (tried <= left ? isEar(at, bends) : tried <= 2 * left ? isOnLine(at) : true) {
        emit(previous[at], at, next[at]);
        next[previous[at]] = next[at];
        previous[next[at]] = previous[at];
        removed[at] = true;
        left--;
        tried = 0;
        if (left % 256 == 0) tidy(bends);
      }
      at = next[at];
    }
    emit(previous[at], at, next[at]);
  }

private:
  /* To the plane of the two axes along which the polygon is largest, seen from its front. */
  void project(const PolygonMesh& mesh, const unsigned* corners, unsigned count) {
    const Vec3d n = areaVector(mesh, corners, count), origin = mesh.positions[corners[0]];
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    points.resize(count);
    previous.resize(count);
    next.resize(count);
    removed.assign(count, false);
    for (unsigned i = 0; i < count; i++) {
      const Vec3d p = mesh.positions[corners[i]] - origin;
      if (z >= x && z >= y) points[i] = {n.z < 0 ? -p.x : p.x, p.y};
      else if (y >= x) points[i] = {n.y < 0 ? -p.z : p.z, p.x};
      else points[i] = {n.x < 0 ? -p.y : p.y, p.z};
      previous[i] = i == 0 ? count - 1 : i - 1;
      next[i] = i + 1 == count ? 0 : i + 1;
    }
  }

  /* Positive if a, b, c turn to the left. */
  double turn(unsigned a, unsigned b, unsigned c) const {
    return (points[b].first - points[a].first) * (points[c].second - points[a].second) -
           (points[b].second - points[a].second) * (points[c].first - points[a].first);
  }

  bool isEar(unsigned i, const std::vector<unsigned>& bends) const {
    const unsigned a = previous[i], c = next[i];
    if (!(turn(a, i, c) > 0.0)) return false;
    return std::none_of(bends.begin(), bends.end(), [&](unsigned p) {
      if (removed[p] || points[p] == points[a] || points[p] == points[i] || points[p] == points[c]) return false;
      return turn(a, i, p) >= 0.0 && turn(i, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    });
  }

  bool isOnLine(unsigned i) const { return turn(previous[i], i, next[i]) == 0.0; }

  /* Clipping ears makes bends convex. */
  void tidy(std::vector<unsigned>& bends) const {
    throwIfCanceled();
    const auto isNone = [&](unsigned i) { return removed[i] || turn(previous[i], i, next[i]) > 0.0; };
    bends.erase(std::remove_if(bends.begin(), bends.end(), isNone), bends.end());
  }

  std::vector<std::pair<double, double>> points;
  std::vector<unsigned> previous, next;
  std::vector<bool> removed;
};

/* True if the diagonal between corners 2 and 4 of a quad is outside, and the other one inside. Quads that are folded
 * less than flatly are no polygons of a plane. */
bool needsOtherDiagonal(const PolygonMesh& mesh, const unsigned* corners) {
  constexpr double flat = 0.7; // cosine
  Vec3d p[4];
  for (int i = 0; i < 4; i++) p[i] = mesh.positions[corners[i]] - mesh.positions[corners[0]];
  const auto cosine = [](const Vec3d& a, const Vec3d& b) { return dot(normalize(a), normalize(b)); };
  const Vec3d a = cross(p[1] - p[0], p[3] - p[0]), b = cross(p[3] - p[2], p[1] - p[2]);
  if (!(dot(a, b) < 0.0) || cosine(a, b) > -flat) return false;
  return cosine(cross(p[1] - p[0], p[2] - p[0]), cross(p[2] - p[0], p[3] - p[0])) > flat;
}

class PolygonSplitter {
public:
  explicit PolygonSplitter(const PolygonMesh& mesh) : mesh(mesh) {}

  MeshPrimitives run() {
    reserve();
    const unsigned* corners = mesh.faceIndices.data();
    for (size_t face = 0; face < mesh.numFaces(); corners += mesh.faceSizes[face++]) addFace(face, corners);
    if (result.indices.size() / result.corners > mostMeshElements)
      throw Error("the mesh has " + std::to_string(result.size()) + " triangles and quads: expected at most " +
                  std::to_string(mostMeshElements));
    return std::move(result);
  }

private:
  void reserve() {
    const auto [least, most] = std::minmax_element(mesh.faceSizes.begin(), mesh.faceSizes.end());
    isSplit = !mesh.faceSizes.empty() && *most > 4;
    const bool hasQuads = std::find(mesh.faceSizes.begin(), mesh.faceSizes.end(), 4u) != mesh.faceSizes.end();
    result.corners = hasQuads ? 4 : 3;
    size_t primitives = mesh.numFaces();
    if (isSplit)
      for (const unsigned size : mesh.faceSizes) primitives += size > 4 ? size - 3 : 0;
    result.indices.reserve(result.corners * primitives);
    if (isSplit) result.faces.reserve(primitives);
  }

  void addTriangle(unsigned a, unsigned b, unsigned c) {
    result.indices.insert(result.indices.end(), {a, b, c});
    if (result.corners == 4) result.indices.push_back(c);
  }

  void addFace(size_t face, const unsigned* v) {
    const unsigned size = mesh.faceSizes[face];
    if (size == 3) addTriangle(v[0], v[1], v[2]);
    else if (size == 4) {
      const bool other = !mesh.splitsAreExplicit && needsOtherDiagonal(mesh, v);
      if (other) result.indices.insert(result.indices.end(), {v[1], v[2], v[3], v[0]});
      else result.indices.insert(result.indices.end(), {v[0], v[1], v[2], v[3]});
    } else clipper.split(mesh, v, size, [&](unsigned a, unsigned b, unsigned c) { addTriangle(v[a], v[b], v[c]); });
    if (isSplit) result.faces.resize(result.size(), unsigned(face));
  }

  const PolygonMesh& mesh;
  MeshPrimitives result;
  EarClipper clipper;
  bool isSplit = false;
};

} // namespace

MeshPrimitives splitPolygons(PolygonMesh& mesh) {
  const bool areTriangles =
      std::all_of(mesh.faceSizes.begin(), mesh.faceSizes.end(), [](unsigned size) { return size == 3; });
  MeshPrimitives result;
  if (areTriangles) result.indices = std::move(mesh.faceIndices);
  else result = PolygonSplitter(mesh).run();
  mesh.faceSizes = {};
  mesh.faceIndices = {};
  return result;
}

} // namespace programs
