// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/uv_charts.h"
#include "surface/face_borders.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace programs {
namespace {

constexpr int largestChart = 24; // faces per side

struct Chart {
  std::vector<unsigned> faces;
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0; // cells; x1 and y1 are inclusive
  int width() const { return x1 - x0 + 1; }
  int height() const { return y1 - y0 + 1; }
};

/* Grows charts breadth first. A face is added if its cell is free, and each corner of the cell is unused or already the
 * same vertex. So charts do not overlap, and adjacent texels are adjacent on the surface. */
class Unfolding {
public:
  explicit Unfolding(const Cage& cage) : cage(cage), borders(cage), cells(cage.numFaces()), done(cage.numFaces()) {}

  std::vector<Chart> run() {
    std::vector<Chart> charts;
    for (unsigned seed = 0; seed < cage.numFaces(); seed++)
      if (!done[seed]) charts.push_back(grow(seed));
    return charts;
  }

  std::vector<ChartCell> takeCells() { return std::move(cells); }

private:
  using Point = std::pair<int, int>;

  static Point squareCorner(const ChartCell& c, int i) {
    static constexpr int dx[4] = {0, 1, 1, 0}, dy[4] = {0, 0, 1, 1};
    return {c.x + dx[i & 3], c.y + dy[i & 3]};
  }

  bool place(unsigned face, const ChartCell& cell, Chart& chart) {
    if (used.count({cell.x, cell.y})) return false;
    if (std::max(chart.x1, cell.x) - std::min(chart.x0, cell.x) >= largestChart ||
        std::max(chart.y1, cell.y) - std::min(chart.y0, cell.y) >= largestChart)
      return false;
    for (int i = 0; i < 4; i++) {
      const auto known = points.find(squareCorner(cell, i + cell.turn));
      if (known != points.end() && known->second != cage.faceIndices[4 * face + size_t(i)]) return false;
    }
    for (int i = 0; i < 4; i++) points[squareCorner(cell, i + cell.turn)] = cage.faceIndices[4 * face + size_t(i)];
    used[{cell.x, cell.y}] = face;
    chart.x0 = std::min(chart.x0, cell.x);
    chart.x1 = std::max(chart.x1, cell.x);
    chart.y0 = std::min(chart.y0, cell.y);
    chart.y1 = std::max(chart.y1, cell.y);
    chart.faces.push_back(face);
    cells[face] = cell;
    done[face] = 1;
    return true;
  }

  Chart grow(unsigned seed) {
    Chart chart;
    points.clear();
    used.clear();
    place(seed, {}, chart);
    for (size_t next = 0; next < chart.faces.size(); next++) {
      const unsigned face = chart.faces[next];
      for (int edge = 0; edge < 4; edge++) {
        const FaceBorders::Side other = borders.opposite(face, unsigned(edge));
        if (other.face == ~0u || done[other.face]) continue;
        /* Side s of a square is below, right of, above or left of it; the neighbor's square has the common edge on
         * the opposite side. */
        const ChartCell& here = cells[face];
        const int side = (edge + here.turn) & 3;
        static constexpr int dx[4] = {0, 1, 0, -1}, dy[4] = {-1, 0, 1, 0};
        place(other.face, {here.x + dx[side], here.y + dy[side], (side + 2 - int(other.edge) + 4) & 3}, chart);
      }
    }
    return chart;
  }

  const Cage& cage;
  FaceBorders borders;
  std::vector<ChartCell> cells;
  std::vector<char> done;
  std::map<Point, unsigned> points, used;
};

} // namespace

Charts unfoldCharts(const Cage& cage, int texels, int padding) {
  Unfolding unfolding(cage);
  std::vector<Chart> pieces = unfolding.run();
  Charts charts;
  charts.texels = texels;
  charts.count = pieces.size();
  charts.cells = unfolding.takeCells();

  /* Packs charts into rows, tallest first. */
  std::sort(pieces.begin(), pieces.end(), [](const Chart& a, const Chart& b) {
    return std::make_pair(a.height(), a.width()) > std::make_pair(b.height(), b.width());
  });
  double area = 0;
  for (const Chart& c : pieces)
    area += double(c.width() * texels + 2 * padding) * double(c.height() * texels + 2 * padding);
  charts.width = std::max(int(std::sqrt(area)), largestChart * texels + 2 * padding);
  int x = 0, y = 0, shelf = 0;
  for (const Chart& c : pieces) {
    const int w = c.width() * texels + 2 * padding, h = c.height() * texels + 2 * padding;
    if (x + w > charts.width) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    for (unsigned face : c.faces) {
      ChartCell& cell = charts.cells[face];
      cell.x = x + padding + (cell.x - c.x0) * texels;
      cell.y = y + padding + (cell.y - c.y0) * texels;
    }
    x += w;
    shelf = std::max(shelf, h);
  }
  charts.height = y + shelf;
  return charts;
}

void setChartUVs(Cage& cage, const Charts& charts) {
  cage.uvs.clear();
  cage.uvIndices.resize(cage.faceIndices.size());
  for (size_t face = 0; face < cage.numFaces(); face++)
    for (int i = 0; i < 4; i++) {
      const ChartCell& c = charts.cells[face];
      const int corner = (i + c.turn) & 3;
      cage.uvIndices[4 * face + size_t(i)] = unsigned(cage.uvs.size());
      cage.uvs.push_back({float(c.x + (corner == 1 || corner == 2 ? charts.texels : 0)) / float(charts.width),
                          float(c.y + (corner >= 2 ? charts.texels : 0)) / float(charts.height)});
    }
}

} // namespace programs
