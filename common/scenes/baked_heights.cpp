// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/baked_heights.h"
#include "basics/hash.h"
#include "basics/parallel.h"
#include "building/subdivision_geometry.h"
#include "scenes/uv_charts.h"

#include <cstdint>
#include <cstdio>

namespace programs {
namespace {

constexpr int padding = 4; // texels around each chart

/* Evaluates heights at points (u,v) of every face. store(face, index of the point, height) must be thread-safe. */
template<typename Store>
void evaluate(const Cage& cage, std::vector<float> u, std::vector<float> v, const Bake& bake, const Store& store) {
  Phase phase(bake.name);
  EmbreeDevice device("threads=1");
  DisplacementContext plain;
  const GeometryHandle geometry = SharedTopology(device, cage).makeGeometry(Placement(), plain);
  const size_t n = u.size(), points = (n + 3) & ~size_t(3); // Embree evaluates four at a time
  u.resize(points);
  v.resize(points);
  std::atomic<size_t> done{0};
  parallelFor(cage.numFaces(), 16, bake.threads, [&](size_t begin, size_t end) {
    std::vector<float> positions(3 * points);
    std::vector<unsigned> faces(points);
    for (size_t face = begin; face < end; face++) {
      std::fill(faces.begin(), faces.end(), unsigned(face));
      RTCInterpolateNArguments args{};
      args.geometry = geometry.get();
      args.primIDs = faces.data();
      args.u = u.data();
      args.v = v.data();
      args.N = unsigned(points);
      args.bufferType = RTC_BUFFER_TYPE_VERTEX;
      args.P = positions.data();
      args.valueCount = 3;
      rtcInterpolateN(&args);
      for (size_t i = 0; i < n; i++) {
        const Vec3f position{positions[i], positions[points + i], positions[2 * points + i]};
        store(face, i, bake.height({unsigned(face), u[i], v[i], position}));
      }
    }
    done += end - begin;
    phase.update(double(done) / double(cage.numFaces()));
  });
  device.check("evaluating the limit surface");
}

/* In rows; true for texels with a height. */
using Coverage = std::vector<char>;

/* Extends covered areas by one texel per step, with the mean of the covered neighbors. */
void dilate(HeightMap& map, Coverage& covered, int steps, unsigned threads) {
  const int width = map.width(), height = map.height();
  for (int step = 0; step < steps; step++) {
    const Coverage before = covered;
    const auto has = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < width && y < height && before[size_t(y) * width + x];
    };
    parallelFor(size_t(height), 64, threads, [&](size_t begin, size_t end) {
      for (int y = int(begin); y < int(end); y++)
        for (int x = 0; x < width; x++) {
          if (has(x, y)) continue;
          float sum = 0;
          int count = 0;
          for (int dy = -1; dy <= 1; dy++)
            for (int dx = -1; dx <= 1; dx++)
              if (has(x + dx, y + dy)) {
                sum += map.at(x + dx, y + dy);
                count++;
              }
          if (count) {
            map.at(x, y) = sum / float(count);
            covered[size_t(y) * width + x] = 1;
          }
        }
    });
  }
}

} // namespace

HeightMap bakeTiles(const Cage& cage, const FaceAtlas& atlas, const Bake& bake) {
  HeightMap map(atlas.columns(), atlas.rows(cage.numFaces()));
  const int side = atlas.tileSize + 1;
  std::vector<float> u, v;
  for (int i = 0; i < side * side; i++) {
    u.push_back(float(i % side) / float(atlas.tileSize));
    v.push_back(float(i / side) / float(atlas.tileSize));
  }
  evaluate(cage, std::move(u), std::move(v), bake, [&](size_t face, size_t i, float h) {
    const int x = int(face) % atlas.tilesPerRow * side + int(i) % side;
    map.at(x, int(face) / atlas.tilesPerRow * side + int(i) / side) = h;
  });
  return map;
}

/* The padding continues the outermost texels, for filters at a seam. */
HeightMap bakeCharts(Cage& cage, int texels, const Bake& bake) {
  const Charts charts = unfoldCharts(cage, texels, padding);
  setChartUVs(cage, charts);
  HeightMap map(charts.width, charts.height);
  std::vector<float> u, v;
  for (int i = 0; i < texels * texels; i++) {
    u.push_back((float(i % texels) + 0.5f) / float(texels));
    v.push_back((float(i / texels) + 0.5f) / float(texels));
  }
  /* Texel (i,j) of a face; the map's rows run downwards. */
  const auto texel = [&](size_t face, int i, int j) -> float& {
    const ChartCell& c = charts.cells[face];
    const int last = texels - 1;
    const int rotated[4][2] = {{i, j}, {last - j, i}, {last - i, last - j}, {j, last - i}};
    return map.at(c.x + rotated[c.turn][0], charts.height - 1 - (c.y + rotated[c.turn][1]));
  };
  evaluate(cage, std::move(u), std::move(v), bake,
           [&](size_t face, size_t i, float h) { texel(face, int(i) % texels, int(i) / texels) = h; });

  Coverage covered(size_t(charts.width) * charts.height);
  const auto at = [&](int x, int y) -> char& { return covered[size_t(y) * charts.width + x]; };
  for (const ChartCell& c : charts.cells)
    for (int y = 0; y < texels; y++)
      for (int x = 0; x < texels; x++) at(c.x + x, charts.height - 1 - (c.y + y)) = 1;
  dilate(map, covered, 2 * padding, bake.threads);
  for (int y = 0; y < charts.height; y++)
    for (int x = 0; x < charts.width; x++)
      if (!at(x, y)) map.at(x, y) = neutralHeight;
  return map;
}

void assignChartUVs(Cage& cage, int texels) { setChartUVs(cage, unfoldCharts(cage, texels, padding)); }

std::shared_ptr<const Displacement> displaceByBake(const Cage& cage, int tileSize, float scale, const Bake& bake) {
  const FaceAtlas atlas = FaceAtlas::forFaces(cage.numFaces(), tileSize);
  return displaceByAtlas(cage, atlas, bakeTiles(cage, atlas, bake), scale);
}

std::string fingerprint(const Cage& cage) {
  uint64_t h = hashOfBytes(cage.positions.data(), cage.positions.size() * sizeof(Vec3f));
  h = hashOfBytes(cage.faceIndices.data(), cage.faceIndices.size() * sizeof(unsigned), h);
  char text[20];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(h));
  return text;
}

} // namespace programs
