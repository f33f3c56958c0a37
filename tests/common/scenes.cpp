// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/error.h"
#include "building/built_scene.h"
#include "building/diced_surface.h"
#include "scenes/baked_heights.h"
#include "scenes/catalogue.h"
#include "scenes/cube.h"
#include "scenes/frog.h"
#include "scenes/herd.h"
#include "scenes/knee.h"
#include "scenes/motion.h"
#include "scenes/scythe.h"
#include "scenes/trex_cage.h"
#include "scenes/trex_skin.h"
#include "scenes/uv_charts.h"
#include "support/message_parts.h"
#include "surface/cage_validation.h"
#include "surface/face_borders.h"
#include "measure/true_errors.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>
#include <set>
#include <sstream>
#include <unistd.h>

namespace programs::test { namespace {

double volume(const Cage& cage, const std::vector<size_t>& faces) {
  double sum = 0; // by the divergence theorem; positive if faces are oriented outwards
  for (size_t f : faces) {
    const unsigned* q = &cage.faceIndices[4 * f];
    const Vec3f a = cage.positions[q[0]], b = cage.positions[q[1]], c = cage.positions[q[2]], d = cage.positions[q[3]];
    sum += dot(a, cross(b, c)) + dot(a, cross(c, d));
  }
  return sum / 6;
}

std::vector<std::vector<size_t>> connectedPieces(const Cage& cage) {
  const FaceBorders borders(cage);
  std::vector<char> seen(cage.numFaces());
  std::vector<std::vector<size_t>> pieces;
  for (unsigned seed = 0; seed < cage.numFaces(); seed++) {
    if (seen[seed]) continue;
    std::vector<size_t> piece{seed};
    seen[seed] = 1;
    for (size_t i = 0; i < piece.size(); i++)
      for (unsigned edge = 0; edge < 4; edge++) {
        const unsigned other = borders.opposite(unsigned(piece[i]), edge).face;
        if (other != ~0u && !seen[other]) {
          seen[other] = 1;
          piece.push_back(other);
        }
      }
    pieces.push_back(piece);
  }
  return pieces;
}

/* Only quads, manifold, without boundary, every piece oriented outwards. */
void expectClosedCage(const Cage& cage) {
  for (unsigned size : cage.faceSizes) ASSERT_EQ(size, 4u);
  Cage checked = cage;
  std::string warnings;
  validateCage(checked, warnings);
  EXPECT_EQ(warnings, "");
  const FaceBorders borders(cage);
  for (unsigned f = 0; f < cage.numFaces(); f++)
    for (unsigned edge = 0; edge < 4; edge++)
      ASSERT_NE(borders.opposite(f, edge).face, ~0u) << cage.name << ": a boundary at face " << f;
  for (const std::vector<size_t>& piece : connectedPieces(cage))
    EXPECT_GT(volume(cage, piece), 0.0) << cage.name << ": the piece of face " << piece[0];
}

/* Offsets on both sides of every edge are equal up to the tolerance: positions differ by rounding. */
void expectContinuous(const Cage& cage, const Displacement& d, int level, float tolerance) {
  const FaceBorders borders(cage);
  const auto offset = [&](const FacePoint& p) {
    float result;
    d.offsets({p.face, level, 1, &p.u, &p.v}, &result);
    return result;
  };
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned edge = 0; edge < 4; edge++)
      for (int i = 0; i <= 1 << level; i++) {
        const float t = std::ldexp(float(i), -level);
        const FaceBorders::Side other = borders.opposite(face, edge);
        ASSERT_NEAR(offset(borders.point(face, edge, t)), offset(borders.point(other.face, other.edge, 1.0f - t)),
                    tolerance)
            << cage.name << ": face " << face << " edge " << edge << " at " << t;
      }
}

TEST(Scenes, SmallScenesAreClosedAndContinuous) {
  for (const Model& model : {makeCube(), makeFrog(), makeScythe(), makeKnee()}) {
    SCOPED_TRACE(model.name);
    expectClosedCage(model.cage);
    EXPECT_LE(model.cage.numFaces(), 1000u);
    for (int level : {2, 6})
      expectContinuous(model.cage, *model.displacement, level, 1e-4f * model.cage.bounds().diagonal());
  }
}

TEST(Scenes, AmplitudeScalesTheDisplacement) {
  const Model once = makeScythe(0.01f), fivefold = makeScythe(0.05f);
  for (float u : {0.25f, 0.5f, 0.8125f}) {
    float a, b;
    once.displacement->offsets({30, 6, 1, &u, &u}, &a);
    fivefold.displacement->offsets({30, 6, 1, &u, &u}, &b);
    EXPECT_NEAR(b, 5.0f * a, 1e-5f);
    EXPECT_NE(a, 0.0f);
  }
}

class Trex : public testing::Test {
protected:
  static void SetUpTestSuite() { trex = new TrexCage(makeTrexCage()); }
  static void TearDownTestSuite() { delete trex; }
  static TrexCage* trex;
};
TrexCage* Trex::trex;

TEST_F(Trex, CageIsClosedWithSixToEightThousandQuads) {
  EXPECT_GE(trex->cage.numFaces(), 6000u);
  EXPECT_LE(trex->cage.numFaces(), 8000u);
  EXPECT_EQ(trex->parts.size(), trex->cage.numFaces());
  expectClosedCage(trex->cage);
}

TEST_F(Trex, BodyIsOnePieceAndHasManyExtraordinaryVertices) {
  const std::vector<std::vector<size_t>> pieces = connectedPieces(trex->cage);
  size_t skin = 0, teeth = 0, claws = 0;
  for (const std::vector<size_t>& piece : pieces) {
    skin += trex->parts[piece[0]] == TrexPart::Skin;
    teeth += trex->parts[piece[0]] == TrexPart::Tooth;
    claws += trex->parts[piece[0]] == TrexPart::Claw;
  }
  EXPECT_EQ(skin, 1u);
  EXPECT_EQ(teeth, 60u);
  EXPECT_EQ(claws, 12u);
  std::vector<int> valence(trex->cage.positions.size());
  for (unsigned v : trex->cage.faceIndices) valence[v]++;
  size_t extraordinary = 0;
  for (int v : valence) extraordinary += v != 4;
  EXPECT_GT(extraordinary, 1000u);
}

TEST_F(Trex, SkinIsContinuousAndUsesItsRange) {
  const FaceAtlas atlas = FaceAtlas::forFaces(trex->cage.numFaces(), 8);
  HeightMap map = bakeTiles(
      trex->cage, atlas, {"skin", 0, [&](const LimitPoint& p) { return trexHeight(trex->parts[p.face], p.position); }});
  float low = 1, high = 0;
  for (int y = 0; y < map.height(); y++)
    for (int x = 0; x < map.width(); x++) {
      low = std::min(low, map.at(x, y));
      high = std::max(high, map.at(x, y));
    }
  EXPECT_GE(low, 0.0f);
  EXPECT_LE(high, 1.0f);
  EXPECT_LT(low, 0.15f);
  EXPECT_GT(high, 0.8f);
  const auto d = displaceByAtlas(trex->cage, atlas, map, 1.0f);
  expectContinuous(trex->cage, *d, 3, 0.01f);
  expectContinuous(trex->cage, *d, 2, 0.0f);
}

TEST_F(Trex, ChartsDoNotOverlapAndAreFew) {
  const Charts charts = unfoldCharts(trex->cage, 8, 2);
  EXPECT_LT(charts.count, trex->cage.numFaces() / 10);
  EXPECT_LT(double(charts.width) * charts.height, 3.0 * 64 * double(trex->cage.numFaces()));
  std::vector<int> owner(size_t(charts.width) * charts.height, 0);
  for (const ChartCell& c : charts.cells)
    for (int y = 0; y < 8; y++)
      for (int x = 0; x < 8; x++) {
        ASSERT_LT(c.x + x, charts.width);
        ASSERT_LT(c.y + y, charts.height);
        ASSERT_EQ(owner[size_t(c.y + y) * charts.width + c.x + x]++, 0);
      }
}

/* A map that is linear in the position is the same in either parametrization. */
TEST_F(Trex, TilesAndChartsShowTheSameHeights) {
  Cage cage = makeKnee().cage;
  const auto height = [](const LimitPoint& p) {
    return 0.3f * p.position.x - 0.2f * p.position.y + 0.1f * p.position.z;
  };
  const auto tiles = displaceByBake(cage, 16, 1.0f, {"tiles", 0, height});
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("cbvh_scenes_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  bakeCharts(cage, 16, {"charts", 0, height}).write((folder / "charts.exr").string());
  DisplacementMap map;
  map.path = (folder / "charts.exr").string();
  std::string warnings;
  const auto charts = displaceByMap(cage, map, warnings);
  std::filesystem::remove_all(folder);
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (float u : {0.25f, 0.5f, 0.75f})
      for (float v : {0.25f, 0.625f}) {
        float a, b;
        tiles->offsets({face, finestLevel, 1, &u, &v}, &a);
        charts->offsets({face, finestLevel, 1, &u, &v}, &b);
        EXPECT_NEAR(a, b, 0.01f) << "face " << face << " at " << u << "," << v;
      }
}

/* Three small copies. */
TEST(Herd, CopiesAreAtTheirPositionsInEveryRepresentation) {
  Model model = makeCube();
  model.copies = {{{0, 0, 0}, 0.0f, 1.0f}, {{9, 0, 0}, 0.6f, 1.5f}, {{0, 0, 9}, -1.0f, 0.5f}};
  BuildSettings settings;
  settings.level = 3;
  EXPECT_EQ(model.layout(3).numQuads(), 3u * 6 * 64);
  for (const RepresentationKind kind : representationKinds()) {
    const Representation representation{kind, 1};
    SCOPED_TRACE(representation.label());
    const BuiltScene scene(model, representation, settings);
    EXPECT_EQ(scene.report().quads, 3u * 6 * 64);
    std::vector<Ray> rays;
    for (const Placement& copy : model.copies) // down onto the center of the face at +y
      rays.push_back({copy.apply({0.01f, 20.0f, 0.02f}), 0.0f, {0, -1, 0}, INFINITY});
    const std::vector<SurfaceHit> hits = traceClosest(scene, rays, 1);
    for (size_t i = 0; i < rays.size(); i++) {
      ASSERT_TRUE(hits[i].hit()) << i;
      EXPECT_EQ(hits[i].face, 6 * i + 3);
      EXPECT_NEAR(hits[i].u, 0.5f, 0.06f);
      EXPECT_NEAR((rays[i].origin.y - hits[i].t) / model.copies[i].scale, (rays[0].origin.y - hits[0].t), 0.05f);
    }
  }
}

/* The shapes share no quads, and hits of each copy are on its own true surface. */
TEST(Herd, CopiesWithOwnShapesAreHitThere) {
  Model model = makeCube();
  model.displacement = nullptr;
  model.copies = {{{0, 0, 0}, 0.0f, 1.0f}, {{9, 0, 0}, 0.6f, 1.5f}};
  model.shapes = {poseVertices("twist", model.cage.positions, 30), poseVertices("bend", model.cage.positions, -20)};
  BuildSettings settings;
  settings.level = 5;
  const BuiltScene scene(model, {RepresentationKind::CVert}, settings);
  const Camera camera = Camera::fit(model.positions(), 0, model.view, 40, {128, 128});
  const std::vector<Ray> rays = primaryRays(camera);
  const std::vector<SurfaceHit> hits = traceClosest(scene, rays, 1);
  const TrueSurfaces surfaces(model);
  const TrueView view{model, surfaces, rays, sampleHits(hits, 500, 1), camera.footprint()};
  const TrueErrors errors = compareToTrueSurface(view, hits, scene.layout(), 1);
  EXPECT_GT(errors.hits, 400u);
  EXPECT_LT(errors.p99World, 2e-3f);

  model.shapes[0].swap(model.shapes[1]); // swapped shapes, which must fail
  const TrueSurfaces swapped(model);
  const TrueErrors others =
      compareToTrueSurface({model, swapped, rays, view.sample, view.footprint}, hits, scene.layout(), 1);
  EXPECT_GT(others.medianWorld, 1e-2f);
}

TEST(Herd, EachCopyHasItsOwnPoseAndMotion) {
  TrexSettings settings;
  Model model = makeHerd(settings, 5);
  ASSERT_EQ(model.shapes.size(), 5u);
  for (size_t i = 0; i < 5; i++)
    for (size_t j = 0; j < i; j++) {
      size_t equal = 0;
      for (size_t k = 0; k < model.cage.positions.size(); k++)
        equal += length(model.shapes[i][k] - model.shapes[j][k]) < 1e-6f;
      EXPECT_LT(equal, model.cage.positions.size() / 20) << i << " and " << j;
    }
  addMotion(model, {"bend", 2, 15});
  const std::vector<Vec3f> positions = model.positions();
  const size_t n = model.cage.positions.size();
  ASSERT_EQ(positions.size(), 5 * 2 * n);
  const Vec3f moved = model.poses[0][7] - model.cage.positions[7];
  EXPECT_LT(length(positions[7 * n + 7] - model.copies[3].apply(model.shapes[3][7] + moved)), 1e-4f);
}

TEST(Motion, FlatCagesStayFinite) {
  for (const std::string& name : motionNames())
    for (const Vec3f flat : {Vec3f{0, 1, 1}, Vec3f{1, 0, 1}, Vec3f{1, 1, 0}, Vec3f{}})
      for (const Vec3f& p : poseVertices(name, {flat * Vec3f{-1, -1, -1}, flat * Vec3f{2, 3, 4}}, 30))
        EXPECT_TRUE(isFinite(p)) << name << ", flat along " << (flat.x == 0 ? "x" : flat.y == 0 ? "y" : "z");
}

TEST(DicedSurface, RefinementToLevel0IsOnlyOfQuads) {
  Model model;
  model.cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  model.cage.faceSizes.assign(4, 3);
  model.cage.faceIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  BuildSettings settings;
  settings.threads = 1;
  for (int level : {0, 1}) {
    settings.level = level;
    const DicedSurface surface(model, settings);
    EXPECT_EQ(surface.mesh(DicedInput::Rows).quads.size(), 12u) << level;
    if (level) EXPECT_EQ(surface.mesh(DicedInput::Refined).quads.size(), 12u);
    else try {
        surface.mesh(DicedInput::Refined);
        ADD_FAILURE() << "triangles are quads";
      } catch (const Error& e) { EXPECT_TRUE(containsInOrder(e.what(), {"level 0", "quads", "level 1"})); }
  }
}

std::string complaint(const SceneSettings& settings) {
  try {
    validateScene(settings);
  } catch (const Error& e) { return e.what(); }
  return "";
}

TEST(Catalogue, UnknownNamesListTheKnownOnes) {
  SceneSettings s;
  s.scene = "teapot";
  EXPECT_TRUE(containsInOrder(complaint(s), {"--scene 'teapot'", "cube", "frog", "herd", "knee", "scythe", "trex"}));
  for (const std::string& name : sceneNames()) {
    s.scene = name;
    EXPECT_EQ(complaint(s), "");
  }
}

TEST(Catalogue, DisplacementAmplitudeIsTheGivenOneOrTheDefault) {
  SceneSettings s;
  s.cagePath = "body.obj";
  EXPECT_FALSE(withDefaultAmplitude(s).amplitude || withDefaultAmplitude(s).mapScale) << "no map, no amplitude";
  s.heightPath = "skin.png";
  EXPECT_EQ(withDefaultAmplitude(s).amplitude, defaultAmplitude);
  s.mapValues = MapValues::ObjectVectors;
  EXPECT_EQ(withDefaultAmplitude(s).mapScale, 1.0f);
  EXPECT_FALSE(withDefaultAmplitude(s).amplitude);
  s.amplitude = 0.5f;
  EXPECT_EQ(withDefaultAmplitude(s).amplitude, 0.5f);
  EXPECT_FALSE(withDefaultAmplitude(s).mapScale);
  SceneSettings cube;
  cube.scene = "cube";
  EXPECT_EQ(withDefaultAmplitude(cube).amplitude, cubeAmplitude);
}

TEST(Catalogue, DisplacementBeyondEmbreesCoordinatesNamesItsScale) {
  std::string warnings;
  SceneSettings s;
  s.scene = "cube";
  for (float amplitude : {1e38f, 1e18f, -1e18f}) try {
      s.amplitude = amplitude;
      loadScene(s, warnings);
      ADD_FAILURE() << amplitude;
    } catch (const Error& e) {
      std::ostringstream value;
      value << "--amplitude " << amplitude << " ";
      EXPECT_TRUE(containsInOrder(e.what(), {value.str(), "e+16"}));
    }
  s.amplitude = 1e10f;
  EXPECT_NO_THROW(loadScene(s, warnings));
}

TEST(Catalogue, OptionsBelongToTheirScenes) {
  SceneSettings s;
  s.scene = "cube";
  s.count = 3;
  EXPECT_TRUE(containsInOrder(complaint(s), {"--count ", "--scene herd"}));
  s.scene = "herd";
  EXPECT_EQ(complaint(s), "");
  s.count = 0;
  EXPECT_TRUE(containsInOrder(complaint(s), {"--count 0 ", " 1 ", std::to_string(maxHerdCount)}));
  s.count = 2;
  s.mapping = "sphere";
  EXPECT_TRUE(containsInOrder(complaint(s), {"--mapping 'sphere'", "faces", "atlas"}));
  s.mapping = "atlas";
  EXPECT_EQ(complaint(s), "");
}

}} // namespace programs::test
