// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces diced by an application into indexed quads or triangles. */

#include "support/diced.h"

#include <array>
#include <map>
#include <numeric>

namespace programs::test {

enum class QuadOrder { Rows, Recursive, Shuffled };
const QuadOrder allQuadOrders[] = {QuadOrder::Rows, QuadOrder::Recursive, QuadOrder::Shuffled};
inline const char* nameOf(QuadOrder order) {
  return order == QuadOrder::Rows ? "row by row" : order == QuadOrder::Recursive ? "recursive" : "shuffled";
}

struct DicedMesh {
  std::vector<Vec> vertices;
  DicedMotion motion;
  std::vector<std::array<unsigned, 4>> quads;
  std::vector<std::array<unsigned, 3>> triangles; // replace the quads if not empty

  bool isTriangleForm() const { return !triangles.empty(); }
  size_t size() const { return isTriangleForm() ? triangles.size() : quads.size(); }
};

// Place of the n-th of 4^k quads in the order of recursive subdivision.
inline std::array<unsigned, 2> recursivePlace(unsigned n) {
  const unsigned cornerX[] = {0, 1, 1, 0}, cornerY[] = {0, 0, 1, 1};
  std::array<unsigned, 2> at = {0, 0};
  for (unsigned bit = 0; n >> (2 * bit); bit++) {
    at[0] |= cornerX[(n >> (2 * bit)) & 3] << bit;
    at[1] |= cornerY[(n >> (2 * bit)) & 3] << bit;
  }
  return at;
}

// The quads of grids, equal vertices merged, without motion. QuadOrder::Recursive requires 2^k x 2^k quads per grid;
// QuadOrder::Shuffled mixes the grids.
inline DicedMesh meshOf(const Diced& diced, QuadOrder order, Random& random) {
  DicedMesh mesh;
  std::map<Vec, unsigned> known;
  const auto vertex = [&](const Vec& p) {
    const auto found = known.insert({p, unsigned(mesh.vertices.size())});
    if (found.second) mesh.vertices.push_back(p);
    return found.first->second;
  };
  for (const RTCGrid& grid : diced.grids) {
    const unsigned w = grid.width - 1u, h = grid.height - 1u;
    for (unsigned i = 0; i < w * h; i++) {
      const std::array<unsigned, 2> at =
          order == QuadOrder::Recursive ? recursivePlace(i) : std::array<unsigned, 2>{i % w, i / w};
      const unsigned x = at[0], y = at[1];
      mesh.quads.push_back({vertex(diced.vertex(grid, x, y)), vertex(diced.vertex(grid, x + 1, y)),
                            vertex(diced.vertex(grid, x + 1, y + 1)), vertex(diced.vertex(grid, x, y + 1))});
    }
  }
  if (order == QuadOrder::Shuffled)
    for (size_t i = mesh.quads.size(); i-- > 1;) std::swap(mesh.quads[i], mesh.quads[random.below(unsigned(i + 1))]);
  return mesh;
}

// Two triangles per quad. All first ones begin at the same corner, and so do all second ones.
inline DicedMesh trianglesOf(const DicedMesh& mesh, unsigned turnOfFirst = 0, unsigned turnOfSecond = 0) {
  DicedMesh out;
  out.vertices = mesh.vertices;
  out.motion = mesh.motion;
  for (const auto& q : mesh.quads) {
    const unsigned first[] = {q[0], q[1], q[3]}, second[] = {q[2], q[3], q[1]};
    out.triangles.push_back({first[turnOfFirst], first[(turnOfFirst + 1) % 3], first[(turnOfFirst + 2) % 3]});
    out.triangles.push_back({second[turnOfSecond], second[(turnOfSecond + 1) % 3], second[(turnOfSecond + 2) % 3]});
  }
  return out;
}

// All first halves of quads, then all second halves, as modifiers that split quads write them, or the reverse.
inline DicedMesh halvesApart(const DicedMesh& mesh, bool secondsFirst = false) {
  DicedMesh out = mesh;
  const size_t n = mesh.triangles.size() / 2;
  for (size_t i = 0; i < n; i++)
    for (size_t half = 0; half < 2; half++)
      out.triangles[(half == size_t(secondsFirst) ? 0 : n) + i] = mesh.triangles[2 * i + half];
  return out;
}

// Faces have copies of shared vertices, as after a modifier that splits edges. Zeros of every second copy change signs.
inline DicedMesh unwelded(const DicedMesh& mesh) {
  DicedMesh out = mesh;
  out.vertices.clear();
  const auto own = [&](auto& faces) {
    for (auto& face : faces)
      for (unsigned& v : face) {
        out.vertices.push_back(mesh.vertices[v]);
        v = unsigned(out.vertices.size() - 1);
        if (out.vertices.size() % 2)
          for (float& x : out.vertices.back())
            if (x == 0) x = -x;
      }
  };
  if (mesh.isTriangleForm()) own(out.triangles);
  else own(out.quads);
  return out;
}

inline DicedMesh withShuffledFaces(DicedMesh mesh, Random& random) {
  const auto shuffle = [&](auto& faces) {
    for (size_t i = faces.size(); i-- > 1;) std::swap(faces[i], faces[random.below(unsigned(i + 1))]);
  };
  shuffle(mesh.quads);
  shuffle(mesh.triangles);
  return mesh;
}

// Each triangle begins at a random corner.
inline DicedMesh withTurnedTriangles(DicedMesh mesh, Random& random) {
  for (auto& t : mesh.triangles) std::rotate(t.begin(), t.begin() + random.below(3), t.end());
  return mesh;
}

// Orders that exporters write.
struct OrderedMesh {
  std::string name;
  DicedMesh mesh;
};

inline std::vector<OrderedMesh> trianglesInAnyOrder(const DicedMesh& quads, Random& random) {
  const DicedMesh triangles = trianglesOf(quads, 2, 0), symmetric = trianglesOf(quads, 1, 1);
  std::vector<OrderedMesh> all;
  all.push_back({"first halves, then second ones", halvesApart(triangles)});
  all.push_back({"second halves, then first ones", halvesApart(triangles, true)});
  all.push_back({"first halves, then second ones, cut at the same corner", halvesApart(symmetric)});
  all.push_back({"shuffled", withShuffledFaces(triangles, random)});
  all.push_back({"shuffled, cut at the same corner", withShuffledFaces(symmetric, random)});
  all.push_back({"turned", withTurnedTriangles(triangles, random)});
  all.push_back({"shuffled and turned", withTurnedTriangles(withShuffledFaces(triangles, random), random)});
  for (size_t i = 0, n = all.size(); i < n; i++) all.push_back({all[i].name + ", not welded", unwelded(all[i].mesh)});
  all.push_back({"not welded", unwelded(triangles)});
  return all;
}

// A globe of rows of quads between two poles. The quads at the poles have a degenerate edge.
inline DicedMesh globe(unsigned columns, unsigned rows) {
  DicedMesh mesh;
  const auto vertex = [&](unsigned x, unsigned y) {
    return y == 0 ? 0 : y == rows ? 1 : 2 + (y - 1) * columns + x % columns;
  };
  mesh.vertices = {{0, 0, -1}, {0, 0, 1}};
  for (unsigned y = 1; y < rows; y++)
    for (unsigned x = 0; x < columns; x++) {
      const double a = 2 * M_PI * x / columns, b = M_PI * y / rows,
                   r = 1 + 0.05 * std::sin(5 * a) * std::sin(b) * std::cos(7 * b);
      mesh.vertices.push_back(
          {float(r * std::cos(a) * std::sin(b)), float(r * std::sin(a) * std::sin(b)), float(-r * std::cos(b))});
    }
  for (unsigned y = 0; y < rows; y++)
    for (unsigned x = 0; x < columns; x++)
      mesh.quads.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
  return mesh;
}

// Returns a committed geometry, which the caller releases.
inline RTCGeometry newMesh(RTCDevice device, const DicedMesh& mesh,
                           RTCCompression compression = RTC_COMPRESSION_INHERIT, unsigned flags = 0,
                           unsigned timeSteps = 1) {
  RTCGeometry geometry =
      rtcNewGeometry(device, mesh.isTriangleForm() ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
  rtcSetGeometryTimeStepCount(geometry, timeSteps);
  for (unsigned t = 0; t < timeSteps; t++)
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, movedTo(mesh.vertices, mesh.motion, t));
  if (mesh.isTriangleForm()) setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles);
  else setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, mesh.quads);
  commitAs(geometry, compression, flags);
  return geometry;
}

class MeshScene : public Scene {
public:
  MeshScene(RTCDevice device, const DicedMesh& mesh, RTCCompression compression = RTC_COMPRESSION_CVERT)
    : Scene(device) {
    attach(*this, newMesh(device, mesh, compression));
    rtcCommitScene(*this);
  }
};

// A ray through a point inside a random triangle, at an angle that is not too grazing; on a ball, from outside.
inline RTCRayHit rayAt(Random& random, const DicedMesh& mesh) {
  unsigned v[3];
  do {
    if (mesh.isTriangleForm()) std::copy_n(mesh.triangles[random.below(unsigned(mesh.triangles.size()))].data(), 3, v);
    else {
      const auto& q = mesh.quads[random.below(unsigned(mesh.quads.size()))];
      const bool isSecond = random.chance(0.5);
      v[0] = q[isSecond ? 2 : 0];
      v[1] = q[isSecond ? 3 : 1];
      v[2] = q[isSecond ? 1 : 3];
    }
  } while (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]);
  const double a = random.uniform(0.05, 0.45), b = random.uniform(0.05, 0.45);
  double e[3], f[3], n[3], d[3], nn = 0, dd = 0, outward = 0;
  Vec target, origin, direction;
  for (int k = 0; k < 3; k++) {
    const double p = mesh.vertices[v[0]][k];
    e[k] = mesh.vertices[v[1]][k] - p;
    f[k] = mesh.vertices[v[2]][k] - p;
    target[k] = float(p + a * e[k] + b * f[k]);
    d[k] = random.normal();
    dd += d[k] * d[k];
  }
  for (int k = 0; k < 3; k++) {
    n[k] = e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
    nn += n[k] * n[k];
    outward += n[k] * target[k];
  }
  for (int k = 0; k < 3; k++) {
    const double along = std::copysign(n[k] / std::sqrt(nn), n[k] * outward);
    origin[k] = float(target[k] + 2 * (along + 0.8 * d[k] / std::sqrt(dd)));
    direction[k] = target[k] - origin[k];
  }
  return makeRay(origin, direction);
}

} // namespace programs::test
