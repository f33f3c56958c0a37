// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Closed cages whose texture coordinates are cut into charts. */

#include "building/built_scene.h"
#include "building/scene_file_builder.h"
#include "support/map_files.h"
#include "surface/displacement.h"
#include "surface/face_borders.h"
#include "surface/height_map.h"
#include "surface/height_texture.h"
#include "surface/seam_gaps.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <tuple>

namespace programs::test { namespace {

constexpr float background = 0.0f;

/* A chart is a rectangle of the map, and of quads. Texture coordinates are linear in (a,b). */
struct Chart {
  Vec2f origin, size;                           // in texture coordinates
  std::function<Vec3f(float a, float b)> point; // position of (a,b), which neighboring charts agree on
  int columns, rows;                            // quads

  Vec2f uv(float a, float b) const { return {origin.x + a * size.x, origin.y + b * size.y}; }
};

struct Charts {
  std::vector<Chart> charts;

  /* Vertices of charts at the same position are one vertex. */
  Cage cage() const {
    Cage cage;
    cage.name = "charts";
    std::map<std::tuple<long, long, long>, unsigned> vertices;
    for (const Chart& chart : charts)
      for (int y = 0; y < chart.rows; y++)
        for (int x = 0; x < chart.columns; x++) {
          cage.faceSizes.push_back(4);
          for (const auto& [i, j] : {std::pair{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}) {
            const float a = float(i) / float(chart.columns), b = float(j) / float(chart.rows);
            const Vec3f p = chart.point(a, b);
            const auto key = std::make_tuple(std::lround(1e4f * p.x), std::lround(1e4f * p.y), std::lround(1e4f * p.z));
            const auto [vertex, isNew] = vertices.try_emplace(key, unsigned(cage.positions.size()));
            if (isNew) cage.positions.push_back(p);
            cage.faceIndices.push_back(vertex->second);
            cage.uvIndices.push_back(unsigned(cage.uvs.size()));
            cage.uvs.push_back(chart.uv(a, b));
          }
        }
    return cage;
  }

  /* Heights of texels whose center is in a chart, and `outside` elsewhere. */
  HeightMap map(int width, int height, float outside,
                const std::function<float(const Chart&, float, float)>& heightOf) const {
    HeightMap map(width, height);
    for (int y = 0; y < height; y++)
      for (int x = 0; x < width; x++) {
        map.at(x, y) = outside;
        for (const Chart& chart : charts) {
          const float a = ((float(x) + 0.5f) / float(width) - chart.origin.x) / chart.size.x;
          const float b = (1.0f - (float(y) + 0.5f) / float(height) - chart.origin.y) / chart.size.y;
          if (a > -1e-5f && a < 1.0f + 1e-5f && b > -1e-5f && b < 1.0f + 1e-5f) map.at(x, y) = heightOf(chart, a, b);
        }
      }
    return map;
  }
};

float smoothHeight(const Chart& chart, float a, float b) {
  const Vec3f p = chart.point(a, b);
  return 0.6f + 0.1f * std::sin(1.3f * p.x + 0.5f) + 0.1f * std::cos(1.1f * p.y - 0.7f * p.z);
}

Vec3f cubePoint(int side, float a, float b) {
  const float x = 2.0f * a - 1.0f, y = 2.0f * b - 1.0f;
  switch (side) {
  case 0: return {1, x, y};
  case 1: return {-1, y, x};
  case 2: return {y, 1, x};
  case 3: return {x, -1, y};
  case 4: return {x, y, 1};
  default: return {y, x, -1};
  }
}

constexpr int ballQuads = 6; // along a chart

/* Six charts; three of them at each corner of the cube. Positions are on the cube, as only the topology matters. */
Charts ball(float margin) {
  Charts ball;
  for (int side = 0; side < 6; side++)
    ball.charts.push_back({{(float(side % 3) + margin) / 3.0f, (float(side / 3) + margin) / 2.0f},
                           {(1.0f - 2.0f * margin) / 3.0f, (1.0f - 2.0f * margin) / 2.0f},
                           [side](float a, float b) { return cubePoint(side, a, b); },
                           ballQuads,
                           ballQuads});
  return ball;
}

/* The same on UDIM tiles 1001 to 1006. */
Charts ballOnTiles() {
  Charts ball = test::ball(0.05f);
  for (int side = 0; side < 6; side++) {
    ball.charts[size_t(side)].origin = {float(side) + 0.05f, 0.05f};
    ball.charts[size_t(side)].size = {0.9f, 0.9f};
  }
  return ball;
}

/* One chart whose left and right sides are the same edges. */
Charts cylinder(float left, float right, float bottom = 0.2f, float top = 0.7f) {
  const auto point = [](float a, float b) {
    const float angle = 6.2831853f * a;
    return Vec3f{std::cos(angle), std::sin(angle), 2.0f * b};
  };
  return {{{{left, bottom}, {right - left, top - bottom}, point, 12, 4}}};
}

/* Two halves that read the same part of the map, mirrored at their common edges. */
Charts mirroredTube() {
  const auto point = [](float a, float b) {
    return Vec3f{std::cos(3.1415927f * a), std::sin(3.1415927f * a), 2.0f * b};
  };
  const auto mirrored = [=](float a, float b) {
    const Vec3f p = point(1.0f - a, b);
    return Vec3f{p.x, -p.y, p.z};
  };
  return {{{{0.3f, 0.3f}, {0.4f, 0.4f}, point, 6, 4}, {{0.7f, 0.3f}, {-0.4f, 0.4f}, mirrored, 6, 4}}};
}

float offset(const Displacement& d, unsigned face, float u, float v, int level) {
  float result;
  d.offsets({face, level, 1, &u, &v}, &result);
  return result;
}

class TextureSeams : public MapFiles {
protected:
  std::unique_ptr<Displacement> displaced(const Cage& cage, const HeightMap& heights,
                                          std::optional<TextureWrap> wrap = {}) {
    const std::string name = "map" + std::to_string(numMaps++) + ".exr";
    heights.write((folder / name).string());
    return displacedBy(cage, name, wrap);
  }

  std::unique_ptr<Displacement> displacedBy(const Cage& cage, const std::string& name,
                                            std::optional<TextureWrap> wrap = {}) {
    DisplacementMap map;
    map.path = (folder / name).string();
    map.midLevel = 0.0f;
    map.wrap = wrap;
    std::string warnings;
    return displaceByMap(cage, map, warnings);
  }

  int numMaps = 0;
};

/* All faces have the same heights on common edges. */
void expectClosed(const Cage& cage, const Displacement& d, int level) {
  const FaceBorders borders(cage);
  const int n = 1 << level;
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned edge = 0; edge < 4; edge++)
      for (int i = 0; i <= n; i++) {
        const float t = float(i) / float(n);
        const FaceBorders::Side other = borders.opposite(face, edge);
        if (other.face == ~0u) continue;
        const FacePoint here = borders.point(face, edge, t), there = borders.point(other.face, other.edge, 1.0f - t);
        ASSERT_EQ(offset(d, face, here.u, here.v, level), offset(d, there.face, there.u, there.v, level))
            << "face " << face << " edge " << edge << " at " << t << " level " << level;
      }
}

/* Calls visit(chart, face, u, v, a, b) for the vertices of a level. */
template<typename Visit>
void forVertices(const Charts& charts, int level, const Visit& visit) {
  const int n = 1 << level;
  unsigned face = 0;
  for (const Chart& chart : charts.charts)
    for (int y = 0; y < chart.rows; y++)
      for (int x = 0; x < chart.columns; x++, face++)
        for (int i = 0; i <= n; i++)
          for (int j = 0; j <= n; j++) {
            const float u = float(i) / float(n), v = float(j) / float(n);
            visit(chart, face, u, v, (float(x) + u) / float(chart.columns), (float(y) + v) / float(chart.rows));
          }
}

float largestError(const Charts& charts, const Displacement& d, int level) {
  float largest = 0;
  forVertices(charts, level, [&](const Chart& chart, unsigned face, float u, float v, float a, float b) {
    largest = std::max(largest, std::abs(offset(d, face, u, v, level) - smoothHeight(chart, a, b)));
  });
  return largest;
}

std::vector<std::pair<const char*, Charts>> closedCages() {
  return {{"ball, charts touch", ball(0.0f)},           {"ball with gutters", ball(0.03f)},
          {"cylinder", cylinder(0.1f, 0.9f)},           {"cylinder, whole map", cylinder(0.0f, 1.0f)},
          {"cylinder, mirrored", cylinder(0.9f, 0.1f)}, {"mirrored halves", mirroredTube()}};
}

TEST_F(TextureSeams, BothSidesHaveTheSameHeights) {
  for (const auto& [name, charts] : closedCages())
    for (const auto& [width, height] : {std::pair{128, 128}, {100, 75}}) {
      SCOPED_TRACE(name);
      const Cage cage = charts.cage();
      const auto d = displaced(cage, charts.map(width, height, background, smoothHeight));
      for (int level : {0, 1, 3}) expectClosed(cage, *d, level);
    }
}

/* A footprint that includes texels of other charts has an error of up to half of a height. */
TEST_F(TextureSeams, HeightsAreThoseOfTheChart) {
  for (const Charts& charts : {ball(0.0f), ball(0.03f)})
    for (int size : {64, 128, 512}) {
      const Cage cage = charts.cage();
      const auto d = displaced(cage, charts.map(size, size, background, smoothHeight));
      for (int level : {2, 3, 4, 5})
        EXPECT_LT(largestError(charts, *d, level), 0.012f) << size << " texels, level " << level;
    }
}

/* To the bit, so that no footprint contains a texel outside of its chart. */
TEST_F(TextureSeams, TexelsOutsideOfChartsDoNotMatter) {
  for (const Charts& charts : {ball(0.03f), cylinder(0.1f, 0.9f, 0.0f, 1.0f), cylinder(0.8f, 0.2f, 0.0f, 1.0f)})
    for (const auto& size : {std::pair{256, 256}, {64, 64}, {75, 160}}) {
      // Clang 14 captures no structured bindings.
      const int width = size.first, height = size.second;
      const Cage cage = charts.cage();
      const auto low = displaced(cage, charts.map(width, height, background, smoothHeight));
      const auto high = displaced(cage, charts.map(width, height, 1000.0f, smoothHeight));
      for (int level : {0, 1, 2, 3, 4})
        forVertices(charts, level, [&](const Chart&, unsigned face, float u, float v, float, float) {
          ASSERT_EQ(offset(*low, face, u, v, level), offset(*high, face, u, v, level))
              << width << " x " << height << " level " << level << " face " << face << " at " << u << ", " << v;
        });
    }
}

/* Farther from a seam than four filter widths, and than a texel. */
TEST_F(TextureSeams, HeightsInsideOfChartsAreThoseOfTheTexture) {
  const Charts charts = ball(0.03f);
  const Cage cage = charts.cage();
  const int size = 256;
  const auto d = displaced(cage, charts.map(size, size, background, smoothHeight));
  std::string warnings;
  const HeightTexture texture({(folder / "map0.exr").string()}, {}, TextureWrap::Repeat, warnings);
  size_t compared = 0;
  for (int level : {3, 5, 7})
    forVertices(charts, level, [&](const Chart& chart, unsigned face, float u, float v, float a, float b) {
      const Vec2f width{chart.size.x / float(ballQuads << level), chart.size.y / float(ballQuads << level)};
      const float reach = 4.1f * std::max(std::max(width.x, width.y), 1.0f / float(size));
      const Vec2f inset{std::min(a, 1 - a) * chart.size.x, std::min(b, 1 - b) * chart.size.y};
      if (std::min(inset.x, inset.y) < reach || (level == 7 && compared % 7)) return;
      const Vec2f uv = chart.uv(a, b);
      float expected;
      texture.sample(0, uv.x, 1.0f - uv.y, width.x, width.y, &expected);
      ASSERT_NEAR(offset(*d, face, u, v, level), expected, 2e-6f) << "level " << level << " face " << face;
      compared++;
    });
  EXPECT_GT(compared, 10000u);
}

/* Vectors as heights: both sides equal, of their chart, and independent of texels outside. */
TEST_F(TextureSeams, VectorsAreThoseOfTheChart) {
  const Charts charts = ball(0.03f);
  const Cage cage = charts.cage();
  const int size = 128;
  const auto vectorOf = [](Vec3f p) { return Vec3f{0.1f * p.y, 0.3f + 0.1f * p.z, -0.1f * p.x}; };
  const auto mapped = [&](float outside, MapValues values) {
    HeightMap channels[3] = {{size, size}, {size, size}, {size, size}};
    for (int k = 0; k < 3; k++)
      channels[k] = charts.map(size, size, outside, [&](const Chart& chart, float a, float b) {
        const Vec3f v = vectorOf(chart.point(a, b));
        return k == 0 ? v.x : k == 1 ? v.y : v.z;
      });
    std::vector<float> texels;
    for (int y = 0; y < size; y++)
      for (int x = 0; x < size; x++)
        for (const HeightMap& channel : channels) texels.push_back(channel.at(x, y));
    DisplacementMap map;
    map.path = pathOf("vectors" + std::to_string(numMaps++) + ".exr");
    map.values = values;
    const auto output = OIIO::ImageOutput::create(map.path);
    EXPECT_TRUE(output->open(map.path, OIIO::ImageSpec(size, size, 3, OIIO::TypeDesc::FLOAT)) &&
                output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) && output->close());
    std::string warnings;
    return displaceByMap(cage, map, warnings);
  };
  const Vec3f normal = normalize(Vec3f{0.3f, 0.5f, 0.8f});
  const auto at = [&](const Displacement& d, FacePoint p, int level) {
    Vec3f vector;
    d.vectors({p.face, level, 1, &p.u, &p.v}, &normal, &vector);
    return vector;
  };
  const FaceBorders borders(cage);
  for (MapValues values : {MapValues::ObjectVectors, MapValues::TangentVectors}) {
    const auto low = mapped(background, values), high = mapped(1000.0f, values);
    for (int level : {0, 2, 4}) {
      for (unsigned face = 0; face < cage.numFaces(); face++)
        for (unsigned edge = 0; edge < 4; edge++)
          for (float t : {0.0f, 0.25f, 0.5f, 1.0f}) {
            const FaceBorders::Side other = borders.opposite(face, edge);
            const Vec3f a = at(*low, borders.point(face, edge, t), level),
                        b = at(*low, borders.point(other.face, other.edge, 1 - t), level);
            ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << "face " << face << " edge " << edge << " at " << t;
          }
      forVertices(charts, level, [&](const Chart& chart, unsigned face, float u, float v, float a, float b) {
        const Vec3f x = at(*low, {face, u, v}, level), y = at(*high, {face, u, v}, level);
        ASSERT_TRUE(x.x == y.x && x.y == y.y && x.z == y.z) << "face " << face << " at " << u << ", " << v;
        if (values == MapValues::ObjectVectors && level >= 2)
          EXPECT_LT(length(x - vectorOf(chart.point(a, b))), 0.02f) << "face " << face << " at " << u << ", " << v;
      });
    }
  }
}

/* The map continues where it repeats: no footprint is cut. */
TEST_F(TextureSeams, RepeatedMapsContinueAcrossSeams) {
  const Charts charts = cylinder(0.0f, 1.0f, 0.0f, 1.0f);
  Cage cage = charts.cage();
  HeightMap noise(128, 128);
  for (int y = 0; y < 128; y++)
    for (int x = 0; x < 128; x++) noise.at(x, y) = float((x * 7919 + y * 104729) % 1009) / 1009.0f;
  const auto whole = displaced(cage, noise);
  for (Vec2f& uv : cage.uvs) uv.x += 0.25f; // from 0.25 to 1.25
  HeightMap moved(128, 128);
  for (int y = 0; y < 128; y++)
    for (int x = 0; x < 128; x++) moved.at((x + 32) % 128, y) = noise.at(x, y);
  const auto other = displaced(cage, moved);
  for (int level : {2, 4})
    forVertices(charts, level, [&](const Chart&, unsigned face, float u, float v, float, float) {
      ASSERT_NEAR(offset(*whole, face, u, v, level), offset(*other, face, u, v, level), 1e-5f) << face;
    });
  /* Clamped, the sides read different texels. */
  SeamGaps repeated, clamped;
  const auto byClamp = displaced(charts.cage(), noise, TextureWrap::Clamp);
  for (const auto& [d, gaps] : {std::pair{whole.get(), &repeated}, {byClamp.get(), &clamped}})
    forVertices(charts, 4, [&, d = d, gaps = gaps](const Chart&, unsigned face, float u, float v, float, float) {
      SurfacePoints points{face, 4, 1, &u, &v};
      points.gaps = gaps;
      float ignored;
      d->offsets(points, &ignored);
    });
  EXPECT_LT(repeated.maximum().distance, 1e-5f);
  EXPECT_GT(clamped.maximum().distance, 0.05f);
}

TEST_F(TextureSeams, TilesAreClosed) {
  const Charts charts = ballOnTiles();
  const Cage cage = charts.cage();
  for (int side = 0; side < 6; side++) {
    Charts one{{charts.charts[size_t(side)]}};
    one.charts[0].origin.x -= float(side);
    const std::string name = "skin." + std::to_string(1001 + side) + ".exr";
    one.map(64, 64, background, smoothHeight).write((folder / name).string());
  }
  const auto d = displacedBy(cage, "skin.<UDIM>.exr");
  for (int level : {0, 2, 4}) expectClosed(cage, *d, level);
  for (int level : {3, 4, 5}) EXPECT_LT(largestError(charts, *d, level), 0.012f) << level;
}

/* The outermost texels of an image count, too, where a chart ends there. */
TEST_F(TextureSeams, WrapContinuesTheImage) {
  Charts plane{{{{-0.5f, 0.25f}, {2.0f, 0.5f}, [](float a, float b) { return Vec3f{a, b, 0}; }, 1, 1}}};
  const Cage cage = plane.cage();
  HeightMap ramp(64, 64);
  for (int y = 0; y < 64; y++)
    for (int x = 0; x < 64; x++) ramp.at(x, y) = 1.0f + (float(x) + 0.5f) / 64.0f;
  const auto at = [&](std::optional<TextureWrap> wrap, float s) {
    return offset(*displaced(cage, ramp, wrap), 0, (s + 0.5f) / 2.0f, 0.5f, finestLevel);
  };
  EXPECT_NEAR(at({}, 1.25f), 1.25f, 1e-4f);
  EXPECT_NEAR(at(TextureWrap::Repeat, 1.25f), 1.25f, 1e-4f);
  EXPECT_NEAR(at(TextureWrap::Clamp, 1.25f), 2.0f - 0.5f / 64.0f, 1e-4f);
  EXPECT_NEAR(at(TextureWrap::Clamp, -0.25f), 1.0f + 0.5f / 64.0f, 1e-4f);
  EXPECT_EQ(at(TextureWrap::Black, 1.25f), 0.0f);
  for (TextureWrap wrap : {TextureWrap::Repeat, TextureWrap::Clamp, TextureWrap::Black})
    EXPECT_NEAR(at(wrap, 0.5f), 1.5f, 1e-4f);
}

/* Single texels as the filter reads them, against the texture's own lookup at their centers. */
TEST_F(TextureSeams, TexelsAreWrappedAsLookUps) {
  HeightMap map(5, 3);
  for (int y = 0; y < 3; y++)
    for (int x = 0; x < 5; x++) map.at(x, y) = float(10 * y + x + 1);
  const std::string file = (folder / "small.exr").string();
  map.write(file);
  for (TextureWrap wrap : {TextureWrap::Clamp, TextureWrap::Repeat, TextureWrap::Black}) {
    std::string warnings;
    const HeightTexture texture({file}, {}, wrap, warnings);
    for (int y = -4; y < 8; y++) {
      float row[25];
      texture.texels(0, -10, y, 25, row);
      for (int x = -10; x < 15; x++) {
        float expected;
        texture.sample(0, (float(x) + 0.5f) / 5.0f, (float(y) + 0.5f) / 3.0f, 0.0f, 0.0f, &expected);
        EXPECT_NEAR(row[x + 10], expected, 1e-4f) << int(wrap) << ": " << x << ", " << y;
      }
    }
  }
}

Model modelOf(const Charts& charts, std::unique_ptr<Displacement> displacement) {
  Model model;
  model.name = "charts";
  model.cage = charts.cage();
  for (Vec3f& p : model.cage.positions) p = normalize(p);
  model.displacement = std::move(displacement);
  return model;
}

/* Rays at points of seams, from outside; all of them must hit the near side. */
void expectNoHoles(const BuiltScene& scene, float time) {
  for (int side = 0; side < 6; side++)
    for (int i = 0; i <= 400; i++)
      for (const auto& [a, b] : {std::pair{0.0f, float(i) / 400}, {float(i) / 400, 1.0f}}) {
        const Vec3f p = normalize(cubePoint(side, a, b));
        RTCRayHit ray{};
        ray.ray.org_x = 5 * p.x, ray.ray.org_y = 5 * p.y, ray.ray.org_z = 5 * p.z;
        ray.ray.dir_x = -p.x, ray.ray.dir_y = -p.y, ray.ray.dir_z = -p.z;
        ray.ray.tfar = 5.0f;
        ray.ray.time = time;
        ray.ray.mask = ~0u;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        scene.tracer().intersect(&ray, 1);
        ASSERT_NE(ray.hit.geomID, RTC_INVALID_GEOMETRY_ID) << side << ": " << a << ", " << b << " at " << time;
      }
}

TEST_F(TextureSeams, RaysDoNotSlipThrough) {
  const Charts charts = ball(0.02f);
  Model model = modelOf(charts, displaced(charts.cage(), charts.map(128, 128, background, smoothHeight)));
  for (bool moves : {false, true}) {
    if (moves) {
      model.poses.push_back(model.cage.positions);
      for (Vec3f& p : model.poses[0]) p = {1.2f * p.x, 0.9f * p.y, p.z + 0.1f * p.x};
    }
    for (int level : {2, 3, 4}) {
      BuildSettings settings;
      settings.level = level;
      const BuiltScene scene(model, {RepresentationKind::CVert}, settings); // GRID's triangles are not watertight
      for (float time : {0.0f, 0.4f, 1.0f})
        if (moves || time == 0.0f) expectNoHoles(scene, time);
    }
  }
}

TEST_F(TextureSeams, TheLargestGapIsReported) {
  const Charts charts = ball(0.02f);
  const auto constants = [&](const Chart& chart, float, float) { // 0, 0.125 ... 0.625: up to 0.5 apart at an edge
    return 0.125f * float(&chart - charts.charts.data());
  };
  const Model model = modelOf(charts, displaced(charts.cage(), charts.map(128, 128, 0.0f, constants)));
  for (RepresentationKind kind : {RepresentationKind::Grid, RepresentationKind::Naive, RepresentationKind::CVert})
    for (int threads : {1, 4}) {
      BuildSettings settings;
      settings.level = 3;
      settings.threads = threads;
      const SeamGap gap = BuiltScene(model, {kind}, settings).report().seams;
      EXPECT_NEAR(gap.distance, 0.625f, 1e-6f); // at corners of the cube
      EXPECT_GT(gap.quads, 0.5f * 0.625f / (2.0f / ballQuads / 8));
    }
  const Model agreeing = modelOf(charts, displaced(charts.cage(), charts.map(128, 128, background, smoothHeight)));
  BuildSettings settings;
  settings.level = 3;
  EXPECT_LT(BuiltScene(agreeing, {RepresentationKind::CVert}, settings).report().seams.quads, 0.2f);
}

/* Otherwise an interrupted build would be resumed with heights of two kinds. */
TEST_F(TextureSeams, AnotherWrapIsAnotherInputOfAFile) {
  const Charts charts = cylinder(0.0f, 1.0f, 0.0f, 1.0f);
  HeightMap ramp(64, 64);
  for (int y = 0; y < 64; y++)
    for (int x = 0; x < 64; x++) ramp.at(x, y) = float(x + y) / 128.0f;
  std::set<unsigned long long> keys;
  for (TextureWrap wrap : {TextureWrap::Repeat, TextureWrap::Clamp, TextureWrap::Black}) {
    const Model model = modelOf(charts, displaced(charts.cage(), ramp, wrap));
    keys.insert(inputKey(model, {RepresentationKind::CVert}, BuildSettings()));
  }
  EXPECT_EQ(keys.size(), 3u);
}

}} // namespace programs::test
