// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/texture_charts.h"

#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace programs {
namespace {

/* Beyond the boundary of a cage, a seam continues straight, for as many edges as footprints may be wide. */
constexpr float extension = 8;

bool isSame(Vec2f a, Vec2f b) { return a.x == b.x && a.y == b.y; }

/* The corners at the start and the end of the first side's edge, on another side. */
std::pair<size_t, size_t> endsOnSide(const Cage& cage, const FaceBorders& faces, size_t start,
                                     const FaceBorders::Side& side) {
  const size_t first = faces.corner(side.face, side.edge);
  const size_t last = faces.corner(side.face, (side.edge + 1) % faces.size(side.face));
  return cage.faceIndices[first] == cage.faceIndices[start] ? std::make_pair(first, last) : std::make_pair(last, first);
}

/* The whole numbers by which coordinates differ, or none if they differ otherwise. */
std::optional<Vec2f> wholeDifference(Vec2f a, Vec2f b) {
  constexpr float tolerance = 1e-5f; // files have 6 digits or more
  const Vec2f d = a - b, whole{std::round(d.x), std::round(d.y)};
  if (std::abs(d.x - whole.x) > tolerance || std::abs(d.y - whole.y) > tolerance) return {};
  return whole;
}

} // namespace

TextureCharts::TextureCharts(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs,
                             const UdimTiles& tiles, bool repeats)
  : differingEdges(uvs.size()),
    differingCorners(uvs.size()) {
  for (unsigned face = 0; face < faces.numFaces(); face++) {
    double area = 0;
    for (unsigned i = 0, n = faces.size(face); i < n; i++) {
      const Vec2f a = uvs[faces.corner(face, i)], b = uvs[faces.corner(face, (i + 1) % n)];
      area += double(a.x) * b.y - double(b.x) * a.y;
    }
    mirrored.push_back(area < 0.0);
  }
  findSeams(cage, faces, uvs, tiles);
  joinFaces(faces);
  /* One comparison per corner, as a vertex may have many. */
  for (unsigned face = 0; face < faces.numFaces(); face++)
    for (unsigned i = 0; i < faces.size(face); i++) {
      const size_t c = faces.corner(face, i);
      const std::vector<FaceBorders::Side>& atVertex = faces.cornersAtVertex(face, i);
      const FaceBorders::Side& some = atVertex.front();
      if (!differingCorners[c] &&
          (!isSame(uvs[c], uvs[faces.corner(some.face, some.edge)]) || charts[face] != charts[some.face]))
        for (const FaceBorders::Side& s : atVertex) differingCorners[faces.corner(s.face, s.edge)] = 1;
    }
  findEnds(cage, faces, uvs, tiles, repeats && !tiles.isUdim());
}

void TextureCharts::findSeams(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs,
                              const UdimTiles& tiles) {
  for (unsigned face = 0; face < faces.numFaces(); face++)
    for (unsigned i = 0, n = faces.size(face); i < n; i++) {
      const size_t start = faces.corner(face, i), end = faces.corner(face, (i + 1) % n);
      for (const FaceBorders::Side& s : faces.sidesOfEdge(face, i)) {
        const auto [first, last] = endsOnSide(cage, faces, start, s);
        differingEdges[start] |= !isSame(uvs[start], uvs[first]) || !isSame(uvs[end], uvs[last]) ||
                                 tiles.imageOf(face) != tiles.imageOf(s.face) || mirrored[face] != mirrored[s.face];
      }
    }
}

void TextureCharts::joinFaces(const FaceBorders& faces) {
  std::vector<unsigned> parents(faces.numFaces());
  std::iota(parents.begin(), parents.end(), 0u);
  const auto rootOf = [&](unsigned face) {
    while (parents[face] != face) face = parents[face] = parents[parents[face]];
    return face;
  };
  for (unsigned face = 0; face < faces.numFaces(); face++)
    for (unsigned i = 0; i < faces.size(face); i++)
      if (!differingEdges[faces.corner(face, i)])
        for (const FaceBorders::Side& s : faces.sidesOfEdge(face, i)) {
          const unsigned a = rootOf(face), b = rootOf(s.face);
          parents[std::max(a, b)] = std::min(a, b); // so that roots precede the other faces
        }
  charts.resize(parents.size());
  for (unsigned face = 0; face < parents.size(); face++)
    charts[face] = rootOf(face) == face ? numCharts++ : charts[rootOf(face)];
}

void TextureCharts::findEnds(const Cage& cage, const FaceBorders& faces, const std::vector<Vec2f>& uvs,
                             const UdimTiles& tiles, bool repeats) {
  std::vector<std::vector<End>> endsOfCharts(numCharts);
  std::vector<char> isAtBoundary(cage.positions.size());
  for (unsigned face = 0; face < faces.numFaces(); face++)
    for (unsigned i = 0, n = faces.size(face); i < n; i++)
      if (faces.sidesOfEdge(face, i).size() == 1)
        isAtBoundary[cage.faceIndices[faces.corner(face, i)]] =
            isAtBoundary[cage.faceIndices[faces.corner(face, (i + 1) % n)]] = 1;
  std::set<std::tuple<unsigned, unsigned, float, float>> continued; // chart, its continuation, and how it is moved
  const auto inImage = [&](unsigned face, size_t corner) {
    const Vec2f uv = uvs[corner] - tiles.originOf(face);
    return Vec2f{uv.x, 1.0f - uv.y};
  };
  for (unsigned face = 0; face < faces.numFaces(); face++)
    for (unsigned i = 0, n = faces.size(face); i < n; i++) {
      const size_t start = faces.corner(face, i), end = faces.corner(face, (i + 1) % n);
      if (!differingEdges[start]) continue;
      const FaceBorders::Side other = faces.opposite(face, i);
      if (repeats && other.face != ~0u && mirrored[face] == mirrored[other.face]) {
        const auto [first, last] = endsOnSide(cage, faces, start, other);
        const std::optional<Vec2f> d = wholeDifference(uvs[start], uvs[first]);
        const std::optional<Vec2f> e = wholeDifference(uvs[end], uvs[last]);
        if (d && e && isSame(*d, *e)) {
          continued.insert({charts[face], charts[other.face], d->x, -d->y});
          continue;
        }
      }
      Vec2f a = inImage(face, start), b = inImage(face, end);
      const Vec2f beyond = (b - a) * extension;
      if (isAtBoundary[cage.faceIndices[start]]) a = a - beyond;
      if (isAtBoundary[cage.faceIndices[end]]) b = b + beyond;
      endsOfCharts[charts[face]].push_back(mirrored[face] ? End{a, b} : End{b, a});
    }
  std::vector<std::vector<End>> all = endsOfCharts;
  for (const auto& [chart, next, x, y] : continued)
    for (const End& end : endsOfCharts[next]) all[chart].push_back({end.a + Vec2f{x, y}, end.b + Vec2f{x, y}});
  sortEnds(std::move(all));
}

void TextureCharts::sortEnds(std::vector<std::vector<End>> endsOfCharts) {
  grids.resize(numCharts);
  std::vector<std::vector<End>> cells;
  firstEnd.push_back(0);
  for (unsigned chart = 0; chart < numCharts; chart++) {
    const std::vector<End>& own = endsOfCharts[chart];
    if (own.empty()) continue;
    Grid& grid = grids[chart];
    grid.lower = grid.upper = own[0].a;
    for (const End& end : own)
      for (Vec2f p : {end.a, end.b}) {
        grid.lower = {std::min(grid.lower.x, p.x), std::min(grid.lower.y, p.y)};
        grid.upper = {std::max(grid.upper.x, p.x), std::max(grid.upper.y, p.y)};
      }
    /* About one cell per end, as square as possible. */
    const float n = float(own.size()), width = grid.upper.x - grid.lower.x, height = grid.upper.y - grid.lower.y;
    grid.columns = !(width > 0.0f)    ? 1
                   : !(height > 0.0f) ? int(n)
                                      : int(std::clamp(std::sqrt(n * width / height), 1.0f, n));
    grid.rows = !(height > 0.0f) ? 1 : std::max(1, int(n) / grid.columns);
    grid.firstCell = firstEnd.size() - 1;
    cells.assign(size_t(grid.columns) * size_t(grid.rows), {});
    for (const End& end : own)
      for (int row = grid.row(std::min(end.a.y, end.b.y)); row <= grid.row(std::max(end.a.y, end.b.y)); row++)
        for (int column = grid.column(std::min(end.a.x, end.b.x)); column <= grid.column(std::max(end.a.x, end.b.x));
             column++)
          cells[size_t(row) * size_t(grid.columns) + size_t(column)].push_back(end);
    for (const std::vector<End>& cell : cells) {
      ends.insert(ends.end(), cell.begin(), cell.end());
      firstEnd.push_back(ends.size());
    }
  }
}

} // namespace programs
