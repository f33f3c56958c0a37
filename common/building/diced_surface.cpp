// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/diced_surface.h"
#include "basics/error.h"
#include "basics/hash.h"
#include "surface/topology_refiner.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <numeric>
#include <random>
#include <system_error>
#include <unordered_map>

namespace programs {
namespace {

/* Identifies points that several patches share: vertices, points on edges, and in n-gons points on spokes and
 * centers. */
class BorderPoints {
public:
  explicit BorderPoints(const Cage& cage) {
    size_t first = 0;
    for (unsigned size : cage.faceSizes) {
      faces.push_back({&cage.faceIndices[first], size});
      first += size;
    }
  }

  using Key = std::array<unsigned, 4>;

  /* Vertex (x,y) must be on the patch's border. */
  Key key(const Patch& patch, unsigned face, unsigned x, unsigned y) const {
    const unsigned n = patch.resolution, size = faces[face].size;
    if (size == 4)
      return y == 0   ? onEdge(face, 0, x, n)
             : x == n ? onEdge(face, 1, y, n)
             : y == n ? onEdge(face, 2, n - x, n)
                      : onEdge(face, 3, n - y, n);
    const unsigned corner = patch.subPatch, before = (corner + size - 1) % size;
    if (y == 0) return onEdge(face, corner, x, 2 * n);
    if (x == 0) return onEdge(face, before, 2 * n - y, 2 * n);
    return x == n ? onSpoke(face, corner, y, n) : onSpoke(face, before, x, n);
  }

private:
  enum Kind : unsigned { Vertex, Edge, Spoke, Center };

  struct Face {
    const unsigned* indices;
    unsigned size;
  };

  Key onEdge(unsigned face, unsigned edge, unsigned k, unsigned steps) const {
    const unsigned a = faces[face].indices[edge], b = faces[face].indices[(edge + 1) % faces[face].size];
    if (k == 0 || k == steps) return {Vertex, k == 0 ? a : b, 0, 0};
    return a < b ? Key{Edge, a, b, k} : Key{Edge, b, a, steps - k};
  }

  /* A spoke leads from the middle of an edge to the center. */
  Key onSpoke(unsigned face, unsigned edge, unsigned k, unsigned steps) const {
    if (k == 0) return onEdge(face, edge, steps, 2 * steps);
    return k == steps ? Key{Center, face, 0, 0} : Key{Spoke, face, edge, k};
  }

  std::vector<Face> faces;
};

class RefinedQuads {
public:
  RefinedQuads(const Cage& cage, int level) : refiner(makeTopologyRefiner(cage, false)) {
    refiner->RefineUniform(OpenSubdiv::Far::TopologyRefiner::UniformOptions(level));
    last = &refiner->GetLevel(level);
  }

  size_t numVertices() const { return size_t(last->GetNumVertices()); }
  void rewind() { face = 0; }

  std::array<unsigned, 4> next() {
    while (last->IsFaceHole(face)) face++;
    const auto vertices = last->GetFaceVertices(face++);
    return {unsigned(vertices[0]), unsigned(vertices[1]), unsigned(vertices[2]), unsigned(vertices[3])};
  }

private:
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  const OpenSubdiv::Far::TopologyLevel* last;
  int face = 0;
};

/* Returns (x,y) of the n-th quad after uniform refinement of a patch. The four children of a quad are ordered around
 * it, from corner 0. */
std::array<unsigned, 2> refinedPosition(unsigned n) {
  const unsigned x[] = {0, 1, 1, 0}, y[] = {0, 0, 1, 1};
  std::array<unsigned, 2> at{0, 0};
  for (unsigned bit = 0; n >> (2 * bit); bit++) {
    at[0] |= x[(n >> (2 * bit)) & 3] << bit;
    at[1] |= y[(n >> (2 * bit)) & 3] << bit;
  }
  return at;
}

void copyVertices(EmbreeDevice& device, RTCGeometry geometry, const std::vector<Vec3f>& vertices) {
  std::copy(vertices.begin(), vertices.end(),
            newBuffer<Vec3f>(device, geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, vertices.size(),
                             "allocating vertices"));
}

/* Corner c counts around the quad from (x,y). */
size_t vertexOf(const Patch& patch, unsigned x, unsigned y, unsigned c) {
  return patch.firstVertex + (y + c / 2) * (patch.resolution + 1) + x + (c == 1 || c == 2);
}

} // namespace

DicedInput DicedInput::parse(const std::string& text) {
  DicedInput input;
  input.name = text;
  const size_t colon = text.find(':');
  const std::string word = text.substr(0, colon), rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  const bool isGrids = word == "grids";
  input.shape = isGrids ? Grids : word == "quads" ? Quads : Triangles;
  input.order = rest == "rows" ? Rows : rest == "shuffled" ? Shuffled : Refined;
  bool isKnown = isGrids || word == "quads" || word == "triangles";
  if (colon != std::string::npos && isGrids) {
    const auto end = std::from_chars(rest.data(), rest.data() + rest.size(), input.gridQuads);
    isKnown &= end.ec == std::errc() && end.ptr == rest.data() + rest.size() && input.gridQuads > 0;
  } else if (colon != std::string::npos) isKnown &= input.order != Refined;
  if (!isKnown)
    throw Error("unknown input '" + text +
                "': expected grids, grids:N for N x N quads, quads or triangles, the last two also with :rows or "
                ":shuffled");
  return input;
}

DicedSurface::DicedSurface(const Model& model, const BuildSettings& settings)
  : model(model),
    level(settings.level),
    layout(model.layout(settings.level)),
    positions(tessellate(model, settings)),
    first(positions.size()) {
  std::iota(first.begin(), first.end(), 0u);
  const size_t patches = layout.patches().size() / model.copies.size();
  for (size_t i = 0; i < model.copies.size(); i++) weld(model.cage, i * patches, patches);
}

void DicedSurface::weld(const Cage& cage, size_t firstPatch, size_t numPatches) {
  const BorderPoints points(cage);
  std::unordered_map<BorderPoints::Key, unsigned, ArrayHash> known;
  for (size_t i = firstPatch; i < firstPatch + numPatches; i++) {
    const Patch& patch = layout.patches()[i];
    const unsigned n = patch.resolution, face = unsigned(patch.face % cage.numFaces());
    for (unsigned y = 0; y <= n; y++)
      for (unsigned x = 0; x <= n; x += y == 0 || y == n ? 1 : n) {
        const size_t vertex = patch.firstVertex + y * (n + 1) + x;
        first[vertex] = known.emplace(points.key(patch, face, x, y), unsigned(vertex)).first->second;
        positions[vertex] = positions[first[vertex]];
      }
  }
}

QuadMesh DicedSurface::mesh(DicedInput::Order order) const {
  if (order == DicedInput::Refined) return refinedMesh();
  QuadMesh mesh = meshRowByRow();
  if (order == DicedInput::Shuffled) std::shuffle(mesh.quads.begin(), mesh.quads.end(), std::mt19937(1));
  return mesh;
}

QuadMesh DicedSurface::refinedMesh() const {
  const std::vector<unsigned>& sizes = model.cage.faceSizes;
  if (level == 0 && std::any_of(sizes.begin(), sizes.end(), [](unsigned n) { return n != 4; }))
    throw Error("OpenSubdiv's refinement to level 0 keeps faces that are not quads: expected only quads, or level 1");
  RefinedQuads refined(model.cage, level);
  const size_t patches = layout.patches().size() / model.copies.size();
  QuadMesh mesh;
  mesh.quads.reserve(numQuads());
  mesh.vertices.resize(refined.numVertices() * model.copies.size());
  std::vector<bool> isSet(mesh.vertices.size());
  for (size_t i = 0; i < layout.patches().size(); i++) {
    const Patch& patch = layout.patches()[i];
    const unsigned firstVertex = unsigned(i / patches * refined.numVertices());
    if (i % patches == 0) refined.rewind();
    for (unsigned q = 0; q < patch.resolution * patch.resolution; q++) {
      const std::array<unsigned, 2> at = refinedPosition(q);
      std::array<unsigned, 4> quad = refined.next();
      for (unsigned c = 0; c < 4; c++) {
        const Vec3f& p = positions[vertexOf(patch, at[0], at[1], c)];
        const unsigned v = quad[c] += firstVertex;
        if (isSet[v] && std::memcmp(&mesh.vertices[v], &p, sizeof(p)) != 0)
          throw Error("vertex " + std::to_string(v) + " of OpenSubdiv's refinement has two positions: expected one");
        mesh.vertices[v] = p;
        isSet[v] = true;
      }
      mesh.quads.push_back(quad);
    }
  }
  return mesh;
}

QuadMesh DicedSurface::meshRowByRow() const {
  constexpr unsigned none = ~0u;
  std::vector<unsigned> number(positions.size(), none);
  QuadMesh mesh;
  mesh.quads.reserve(numQuads());
  for (const Patch& patch : layout.patches())
    for (unsigned i = 0; i < patch.resolution * patch.resolution; i++) {
      std::array<unsigned, 4> quad;
      for (unsigned c = 0; c < 4; c++) {
        const unsigned v = first[vertexOf(patch, i % patch.resolution, i / patch.resolution, c)];
        if (number[v] == none) {
          number[v] = unsigned(mesh.vertices.size());
          mesh.vertices.push_back(positions[v]);
        }
        quad[c] = number[v];
      }
      mesh.quads.push_back(quad);
    }
  return mesh;
}

GeometryHandle DicedSurface::makeGrids(EmbreeDevice& device, unsigned gridQuads) const {
  GeometryHandle geometry(rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_GRID));
  copyVertices(device, geometry.get(), positions);
  std::vector<RTCGrid> grids;
  for (const Patch& patch : layout.patches()) {
    const unsigned n = patch.resolution, side = gridQuads ? gridQuads : n;
    const auto vertices = [&](unsigned begin) { return static_cast<unsigned short>(std::min(side, n - begin) + 1); };
    for (unsigned y = 0; y < n; y += side)
      for (unsigned x = 0; x < n; x += side)
        grids.push_back({unsigned(patch.firstVertex + y * (n + 1) + x), n + 1, vertices(x), vertices(y)});
  }
  std::copy(grids.begin(), grids.end(),
            newBuffer<RTCGrid>(device, geometry.get(), RTC_BUFFER_TYPE_GRID, RTC_FORMAT_GRID, grids.size(),
                               "allocating grids"));
  return geometry;
}

GeometryHandle makeIndexedGeometry(EmbreeDevice& device, const QuadMesh& mesh, bool asTriangles) {
  using Triangle = std::array<unsigned, 3>;
  using Quad = std::array<unsigned, 4>;
  const RTCGeometryType type = asTriangles ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD;
  GeometryHandle geometry(rtcNewGeometry(device.handle(), type));
  copyVertices(device, geometry.get(), mesh.vertices);
  if (!asTriangles) {
    std::copy(mesh.quads.begin(), mesh.quads.end(),
              newBuffer<Quad>(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4, mesh.quads.size(),
                              "allocating quads"));
    return geometry;
  }
  Triangle* out = newBuffer<Triangle>(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                      2 * mesh.quads.size(), "allocating triangles");
  for (const Quad& q : mesh.quads) {
    *out++ = {q[0], q[1], q[3]};
    *out++ = {q[1], q[2], q[3]};
  }
  return geometry;
}

} // namespace programs
