// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Meshes as renderers' adaptive subdivision writes them: many patches, each with a regular inner grid, or for
 * triangular patches a triangle of triangles. Strips of triangles stitch it to the patch's edges, whose rates (numbers
 * of segments) are shared with neighbors and differ from edge to edge. */

#include "support/diced_mesh.h"

namespace programs::test {

// Faces of a base mesh of columns x rows quads, on a bumpy sheet over [-1,1]^2.
struct StitchedSheet {
  unsigned columns = 1, rows = 1;
  unsigned minRate = 2, maxRate = 8; // of edges, at random
  double triangular = 0;             // part of the faces that consist of two triangular patches
  double collapsed = 0;              // part of the inner vertices of edges that coincide with their predecessor
  double lattice = 0;                // positions are multiples of it, unless it is 0
};

class StitchedMesh {
public:
  StitchedMesh(const StitchedSheet& sheet, Random& random) : sheet(sheet), random(random) {}

  DicedMesh build() {
    const unsigned columns = sheet.columns, rows = sheet.rows;
    for (unsigned y = 0; y <= rows; y++)
      for (unsigned x = 0; x <= columns; x++) vertex({double(x), double(y)});
    const unsigned vertical = columns * (rows + 1), all = vertical + (columns + 1) * rows;
    for (unsigned y = 0; y <= rows; y++)
      for (unsigned x = 0; x < columns; x++) addEdge({double(x), double(y)}, {x + 1.0, double(y)});
    for (unsigned y = 0; y < rows; y++)
      for (unsigned x = 0; x <= columns; x++) addEdge({double(x), double(y)}, {double(x), y + 1.0});
    for (unsigned y = 0; y < rows; y++)
      for (unsigned x = 0; x < columns; x++) {
        const Point a = {double(x), double(y)}, b = {x + 1.0, double(y)}, c = {x + 1.0, y + 1.0},
                    d = {double(x), y + 1.0};
        const Edge bottom = edges[y * columns + x], top = edges[(y + 1) * columns + x];
        const Edge left = edges[vertical + y * (columns + 1) + x], right = edges[vertical + y * (columns + 1) + x + 1];
        if (!random.chance(sheet.triangular)) {
          addQuad({bottom, right, reversed(top), reversed(left)}, {a, b, c, d});
          continue;
        }
        edges.resize(all);
        addEdge(a, c);
        addTriangle({bottom, right, reversed(edges.back())}, {a, b, c});
        addTriangle({edges.back(), reversed(top), reversed(left)}, {a, c, d});
      }
    return std::move(mesh);
  }

private:
  typedef std::array<double, 2> Point; // in the plane of the base mesh
  typedef std::vector<unsigned> Edge;  // vertices, with both ends

  static Point between(const Point& a, const Point& b, double t) {
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
  }

  static Edge reversed(Edge edge) {
    std::reverse(edge.begin(), edge.end());
    return edge;
  }

  unsigned vertex(const Point& at) {
    const double u = 2 * at[0] / sheet.columns - 1, v = 2 * at[1] / sheet.rows - 1;
    mesh.vertices.push_back({roundTo(u + 0.02 * std::sin(9 * v), sheet.lattice), roundTo(v, sheet.lattice),
                             roundTo(0.1 * std::sin(7 * u + 3 * v) * std::cos(5 * v), sheet.lattice)});
    return unsigned(mesh.vertices.size() - 1);
  }

  unsigned cornerAt(const Point& at) const { return unsigned(at[1]) * (sheet.columns + 1) + unsigned(at[0]); }

  void addEdge(const Point& a, const Point& b) {
    const unsigned rate = sheet.minRate + random.below(sheet.maxRate - sheet.minRate + 1);
    Edge edge = {cornerAt(a)};
    for (unsigned i = 1; i < rate; i++) {
      edge.push_back(vertex(between(a, b, double(i) / rate)));
      if (random.chance(sheet.collapsed)) mesh.vertices.back() = mesh.vertices[edge[i - 1]];
    }
    edge.push_back(cornerAt(b));
    edges.push_back(edge);
  }

  static unsigned rateOf(const Edge& edge) { return unsigned(edge.size() - 1); }

  // Edges lead around the patch; so do its corners.
  void addQuad(const std::array<Edge, 4>& sides, const std::array<Point, 4>& corners) {
    const unsigned m = std::max({rateOf(sides[0]), rateOf(sides[2]), 2u}),
                   n = std::max({rateOf(sides[1]), rateOf(sides[3]), 2u});
    const unsigned first = unsigned(mesh.vertices.size()), row = m - 1;
    for (unsigned j = 1; j < n; j++)
      for (unsigned i = 1; i < m; i++)
        vertex(between(between(corners[0], corners[1], double(i) / m), between(corners[3], corners[2], double(i) / m),
                       double(j) / n));
    const auto inner = [&](unsigned i, unsigned j) { return first + j * row + i; };
    for (unsigned j = 0; j + 2 < n; j++)
      for (unsigned i = 0; i + 2 < m; i++) {
        mesh.triangles.push_back({inner(i, j), inner(i + 1, j), inner(i + 1, j + 1)});
        mesh.triangles.push_back({inner(i, j), inner(i + 1, j + 1), inner(i, j + 1)});
      }
    Edge ring[4];
    for (unsigned i = 0; i + 1 < m; i++) {
      ring[0].push_back(inner(i, 0));
      ring[2].push_back(inner(m - 2 - i, n - 2));
    }
    for (unsigned j = 0; j + 1 < n; j++) {
      ring[1].push_back(inner(m - 2, j));
      ring[3].push_back(inner(0, n - 2 - j));
    }
    for (int s = 0; s < 4; s++) stitch(sides[s], ring[s]);
  }

  void addTriangle(const std::array<Edge, 3>& sides, const std::array<Point, 3>& corners) {
    const unsigned m = std::max({rateOf(sides[0]), rateOf(sides[1]), rateOf(sides[2]), 3u}), side = m - 3;
    std::vector<Edge> rows; // row j has side + 1 - j vertices
    for (unsigned j = 0; j <= side; j++) {
      rows.emplace_back();
      for (unsigned i = 0; i <= side - j; i++) {
        const double u = (i + 1.0) / m, v = (j + 1.0) / m, w = 1 - u - v;
        rows[j].push_back(vertex({w * corners[0][0] + u * corners[1][0] + v * corners[2][0],
                                  w * corners[0][1] + u * corners[1][1] + v * corners[2][1]}));
      }
    }
    for (unsigned j = 0; j < side; j++)
      for (unsigned i = 0; i < side - j; i++) {
        mesh.triangles.push_back({rows[j][i], rows[j][i + 1], rows[j + 1][i]});
        if (i + 1 < side - j) mesh.triangles.push_back({rows[j][i + 1], rows[j + 1][i + 1], rows[j + 1][i]});
      }
    Edge ring[3];
    for (unsigned i = 0; i <= side; i++) {
      ring[0].push_back(rows[0][i]);
      ring[1].push_back(rows[i][side - i]);
      ring[2].push_back(rows[side - i][0]);
    }
    for (int s = 0; s < 3; s++) stitch(sides[s], ring[s]);
  }

  double squaredDistance(unsigned a, unsigned b) const {
    double square = 0;
    for (int k = 0; k < 3; k++) square += std::pow(double(mesh.vertices[a][k]) - mesh.vertices[b][k], 2);
    return square;
  }

  // A strip of triangles between an edge and a side of the inner grid. Of two diagonals it chooses the shorter one.
  void stitch(const Edge& outer, const Edge& inner) {
    for (size_t i = 0, j = 0; i + 1 < inner.size() || j + 1 < outer.size();) {
      const bool advancesOuter =
          i + 1 == inner.size() ||
          (j + 1 < outer.size() && squaredDistance(inner[i], outer[j + 1]) < squaredDistance(outer[j], inner[i + 1]));
      const unsigned next = advancesOuter ? outer[j + 1] : inner[i + 1];
      mesh.triangles.push_back({outer[j], next, inner[i]});
      if (advancesOuter) j++;
      else i++;
    }
  }

  const StitchedSheet sheet;
  Random& random;
  std::vector<Edge> edges;
  DicedMesh mesh;
};

inline DicedMesh stitchedMesh(const StitchedSheet& sheet, Random& random) {
  return StitchedMesh(sheet, random).build();
}

// The vertices in random order.
inline DicedMesh withShuffledVertices(DicedMesh mesh, Random& random) {
  std::vector<unsigned> to(mesh.vertices.size());
  std::iota(to.begin(), to.end(), 0u);
  for (size_t i = to.size(); i-- > 1;) std::swap(to[i], to[random.below(unsigned(i + 1))]);
  const std::vector<Vec> before = mesh.vertices;
  for (size_t i = 0; i < to.size(); i++) mesh.vertices[to[i]] = before[i];
  for (auto& t : mesh.triangles)
    for (unsigned& v : t) v = to[v];
  for (auto& q : mesh.quads)
    for (unsigned& v : q) v = to[v];
  return mesh;
}

} // namespace programs::test
