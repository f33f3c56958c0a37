// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Moving mesh blocks are lossless at every time step, and boxes contain their groups. A second decoder, written from
 * docs/formats/mesh.md, must agree. Rigid motion needs few bytes. Moving mesh tiles have the same triangles at all
 * steps, and become such blocks again. */

#include "kernels/cvert/conversion/moving_mesh_tile_conversion.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "codec/format_pages.h"
#include "support/moving_mesh.h"

#include <gtest/gtest.h>

#include <memory>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 2026;

/* --- a decoder of later steps, written from the page ------------------------------------- */

class PageSteps {
public:
  std::vector<std::vector<Point>> steps; // vertices of the block at each later step
  float begin, end;
  size_t bytes;

  // first: vertices at the first step. firstVertex: of each group, then the total number.
  PageSteps(const uint8_t* block, const std::vector<Point>& first, const std::vector<uint32_t>& firstVertex)
    : data(block) {
    const size_t motion = word(28);
    begin = real(motion);
    end = real(motion + 4);
    const uint32_t numSteps = word(motion + 8), table = word(motion + 12);
    const uint32_t groups = uint32_t(firstVertex.size()) - 1;
    for (uint32_t s = 1; s < numSteps; s++) {
      const size_t at = word(table + 4 * (s - 1));
      const uint32_t spacings = word(at + 12), info = word(at + 64);
      const uint32_t baseBits[3] = {info >> 12 & 63, info >> 18 & 63, info >> 24 & 63};
      std::vector<std::array<int64_t, 3>> bases(groups);
      position = 8 * (at + 68 + 8 * groups);
      for (auto& base : bases)
        for (int k = 0; k < 3; k++) {
          base[k] = read(baseBits[k]);
          if (baseBits[k] && base[k] >> (baseBits[k] - 1) & 1) base[k] -= int64_t(1) << baseBits[k];
        }
      position = (position + 7) / 8 * 8;
      std::vector<Point> points;
      for (uint32_t g = 0; g < groups; g++) {
        const uint32_t record = data[at + 68 + 2 * g] | data[at + 69 + 2 * g] << 8;
        for (uint32_t v = firstVertex[g]; v < firstVertex[g + 1]; v++) {
          Point p;
          for (int k = 0; k < 3; k++) {
            double x[3], map[4];
            for (int i = 0; i < 3; i++) x[i] = wide(first[v][i]);
            for (int i = 0; i < 4; i++) map[i] = wide(real(at + 16 + 16 * k + 4 * i));
            const double predicted = map[0] * x[0] + map[1] * x[1] + map[2] * x[2] + map[3];
            const uint32_t bits = record >> 5 * k & 31, exponent = spacings >> 8 * k & 255;
            const int64_t rest = bases[g][k] + int64_t(read(bits == 31 ? 32 : bits));
            const float origin = real(at + 4 * k);
            if (exponent != 0) {
              const double spacing = std::ldexp(1.0, int(exponent) - 127), limit = 1 << 30;
              const double steps = std::floor((predicted - wide(origin)) / spacing + 0.5);
              const double c = std::min(std::max(steps, -limit), limit);
              p[k] = float(double(origin) + double(int32_t(int64_t(c) + rest)) * spacing);
            } else {
              const float nearest = std::fabs(predicted) < std::ldexp(1.0, -126) ? 0.0f : float(predicted);
              p[k] = floatAt(uint32_t(orderOf(nearest) + rest));
            }
          }
          points.push_back(p);
        }
      }
      bytes = ((position + 7) / 8 + 3) / 4 * 4;
      steps.push_back(points);
    }
  }

private:
  uint32_t word(size_t offset) const {
    uint32_t w;
    std::memcpy(&w, data + offset, 4);
    return w;
  }
  float real(size_t offset) const {
    float f;
    std::memcpy(&f, data + offset, 4);
    return f;
  }
  static double wide(float x) { return std::fabs(double(x)) < std::ldexp(1.0, -126) ? 0.0 : double(x); }

  // Position of a float among all floats; 0 for 0.
  static int64_t orderOf(float x) {
    int32_t bits;
    std::memcpy(&bits, &x, 4);
    return bits >= 0 ? int64_t(bits) : -int64_t(bits & 0x7FFFFFFF);
  }

  static float floatAt(uint32_t order) {
    const int32_t i = int32_t(order);
    const uint32_t bits = i >= 0 ? order : (0u - order) | 0x80000000u;
    float x;
    std::memcpy(&x, &bits, 4);
    return x;
  }

  uint32_t read(uint32_t count) {
    uint64_t value = 0;
    for (uint32_t i = 0; i < count; i++, position++) value |= uint64_t(data[position / 8] >> position % 8 & 1) << i;
    return uint32_t(value);
  }

  const uint8_t* data;
  size_t position;
};

/* --- properties of all blocks ---------------------------------------------------------- */

bool areEqual(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0 || (a == 0 && b == 0); }

// Returns false if the block has no tile.
bool expectTile(const EncodedBlock& encoded) {
  const MeshHeader* const block = encoded.block();
  const uint32_t numSteps = motionOfMesh(block).numSteps;
  std::vector<uint32_t> memory(maxBytesOfMovingMeshTile(numSteps) / 4 + meshTileReadPadding / 4);
  const MeshTileHeader* const tile = (const MeshTileHeader*)memory.data();
  const size_t bytes = std::make_unique<MovingMeshTileWriter>()->write(block, (uint8_t*)memory.data());
  if (bytes == 0) return false;
  EXPECT_LE(bytes, maxBytesOfMovingMeshTile(numSteps));
  EXPECT_EQ(tile->bytes, bytes);
  EXPECT_TRUE(isMeshTile(tile) && isMovingMeshTile(tile));
  EXPECT_EQ(motionOfMeshTile(tile).begin, 0.25f);
  EXPECT_EQ(motionOfMeshTile(tile).end, 0.75f);
  EXPECT_EQ(motionOfMeshTile(tile).numSteps, numSteps);
  const MeshTileView first(meshTileOfStep(tile, 0));
  for (uint32_t step = 0; step < numSteps; step++) {
    const auto decoded = std::make_unique<DecodedMesh>(block, step);
    const MeshTileView view(meshTileOfStep(tile, step));
    for (uint32_t g = 0, i = 0; g < first.groups; g++)
      for (uint32_t t = 0; t < first.triangles(g); t++, i++) {
        EXPECT_EQ(first.number(g, t), decoded->numbers[i]);
        for (uint32_t c = 0; c < 3; c++) {
          float p[3];
          view.vertex(g, first.corner(g, t, c), p);
          for (uint32_t k = 0; k < 3; k++) {
            EXPECT_EQ(p[k], decoded->vertices[decoded->triangles[i][c]][k]) << "step " << step;
            const double spacing = double(meshSpacing(view.tile->spacings, k)),
                         unit = std::ldexp(spacing, int((view.tile->meshInfo >> (4 * k)) & 15u)),
                         origin = double(view.tile->origin[k]);
            EXPECT_LE(origin + unit * view.plane(g, k), double(p[k]));
            EXPECT_GE(origin + unit * (view.plane(g, 3 + k) + 1), double(p[k]));
          }
        }
      }
  }
  // Groups may share other vertices than before if several have the same positions.
  std::vector<uint32_t> again(MeshMotionEncoder::maxBytes(numSteps) / 4 + 1);
  const MeshHeader* const second = (const MeshHeader*)again.data();
  const size_t size = movingMeshOfTile(tile, *std::make_unique<MeshMotionEncoder>(), (uint8_t*)again.data());
  EXPECT_LE(double(size), 1.1 * double(encoded.size()));
  EXPECT_EQ(validateMesh(second, second->bytes).message(), "");
  for (uint32_t step = 0; step < numSteps; step++) {
    const auto a = std::make_unique<DecodedMesh>(block, step), b = std::make_unique<DecodedMesh>(second, step);
    EXPECT_EQ(a->numTriangles, b->numTriangles);
    for (uint32_t i = 0; i < a->numTriangles; i++) {
      EXPECT_EQ(a->numbers[i], b->numbers[i]);
      for (uint32_t c = 0; c < 3; c++)
        for (uint32_t k = 0; k < 3; k++)
          EXPECT_EQ(a->vertices[a->triangles[i][c]][k], b->vertices[b->triangles[i][c]][k]);
    }
  }
  return true;
}

// tiles: receives the number of blocks that have a tile.
void expectMesh(const MovingMesh& mesh, const std::vector<EncodedBlock>& blocks, size_t* tiles = nullptr) {
  size_t count = 0;
  for (const EncodedBlock& encoded : blocks) {
    if (expectTile(encoded) && tiles) ++*tiles;
    const MeshHeader* const block = encoded.block();
    ASSERT_EQ(validateMesh(block, encoded.size()).message(), "");
    ASSERT_EQ(block->bytes, encoded.size());
    ASSERT_EQ(block->surface, 3u);
    ASSERT_TRUE(isMeshBlock(block));
    ASSERT_EQ(motionOfMesh(block).numSteps, mesh.steps.size());
    const MeshView view(block);
    std::vector<Point> first;
    for (uint32_t step = 0; step < mesh.steps.size(); step++) {
      const auto decoded = std::make_unique<DecodedMesh>(block, step);
      ASSERT_EQ(decoded->numTriangles, encoded.stored);
      for (uint32_t t = 0; t < decoded->numTriangles; t++) {
        const uint32_t number = decoded->numbers[t];
        ASSERT_TRUE(number >= encoded.first && number < encoded.first + encoded.stored) << number;
        for (int c = 0; c < 3; c++)
          for (int k = 0; k < 3; k++)
            ASSERT_TRUE(areEqual(decoded->vertices[decoded->triangles[t][c]][k],
                                 mesh.steps[step][mesh.triangles[number][c]][k]))
                << "step " << step << ", triangle " << number << ", corner " << c << ", axis " << k << ": "
                << decoded->vertices[decoded->triangles[t][c]][k] << " instead of "
                << mesh.steps[step][mesh.triangles[number][c]][k];
      }
      if (step == 0) {
        for (uint32_t v = 0; v < decoded->numVertices; v++)
          first.push_back({decoded->vertices[v][0], decoded->vertices[v][1], decoded->vertices[v][2]});
        continue;
      }
      const MeshStepView later(view, step);
      for (uint32_t g = 0; g < view.groups; g++) {
        const auto group =
            std::make_unique<DecodedMeshGroup>(view, g, [&](uint32_t v, float out[3]) { later.vertex(v, out); });
        float lower[3], upper[3];
        later.groupBox(g, lower, upper);
        for (uint32_t t = 0; t < group->numTriangles; t++)
          for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++) {
              ASSERT_EQ(group->corners[c][k][t],
                        decoded->vertices[decoded->triangles[decoded->firstTriangle[g] + t][c]][k]);
              ASSERT_TRUE(lower[k] <= group->corners[c][k][t] && group->corners[c][k][t] <= upper[k])
                  << "step " << step << ", group " << g << ", axis " << k;
            }
      }
    }
    const std::vector<uint32_t> firstVertex(view.firstVertex, view.firstVertex + view.groups + 1);
    const PageSteps page((const uint8_t*)block, first, firstVertex);
    ASSERT_EQ(page.bytes, encoded.size());
    ASSERT_EQ(page.begin, 0.25f);
    ASSERT_EQ(page.end, 0.75f);
    for (uint32_t step = 1; step < mesh.steps.size(); step++) {
      const auto decoded = std::make_unique<DecodedMesh>(block, step);
      for (uint32_t v = 0; v < decoded->numVertices; v++)
        for (int k = 0; k < 3; k++)
          ASSERT_TRUE(areEqual(decoded->vertices[v][k], page.steps[step - 1][v][k]))
              << "step " << step << ", vertex " << v << " by the page: " << page.steps[step - 1][v][k] << " instead of "
              << decoded->vertices[v][k];
    }
    count += encoded.stored;
  }
  EXPECT_EQ(count, mesh.triangles.size());
}

/* --- tests ------------------------------------------------------------------------------- */

TEST(MeshMotion, SheetsRoundTripAtEveryStep) {
  Random random(seed);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  size_t tiles = 0;
  for (int i = 0; i < 200; i++) {
    const MovingMesh mesh = sheetOfSeries(random, i);
    expectMesh(mesh, encode(*encoder, mesh, anyGroupTriangles(random), statistics), &tiles);
    if (HasFatalFailure()) FAIL() << "sheet " << i;
  }
  EXPECT_GT(statistics.rankAxes, 30u);
  EXPECT_GT(statistics.shearedBlocks, 30u);
  EXPECT_GT(tiles, 100u);
}

TEST(MeshMotion, DifficultMeshesRoundTrip) {
  Random random(seed + 1);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  const auto any = [&](double low, double high) {
    return float((random.chance(0.5) ? -1 : 1) * random.magnitude(low, high));
  };
  for (const auto& range : {std::pair<double, double>{1e-45, 1.8e18}, {1e-45, 1e-36}, {1e10, 1.8e18}, {1e-3, 1e3}})
    for (uint32_t numSteps : {2u, 3u, maxTimeSteps}) {
      MovingMesh mesh;
      const uint32_t numVertices = numSteps > 3 ? 40 : 300;
      for (uint32_t s = 0; s < numSteps; s++) {
        mesh.steps.emplace_back();
        for (uint32_t v = 0; v < numVertices; v++)
          mesh.steps.back().push_back(random.chance(0.1)
                                          ? Point{0, -0.0f, 0}
                                          : Point{any(range.first, range.second), any(range.first, range.second),
                                                  any(range.first, range.second)});
      }
      while (mesh.triangles.size() < numVertices) {
        const uint32_t a = random.below(numVertices), b = random.below(numVertices), c = random.below(numVertices);
        if (a != b && b != c && c != a) mesh.triangles.push_back({a, b, c});
      }
      for (uint32_t group : {1u, 16u, 32u}) {
        expectMesh(mesh, encode(*encoder, mesh, group, statistics));
        if (HasFatalFailure()) FAIL() << "floats from " << range.first << ", " << numSteps << " steps";
      }
    }
}

// A flat, a straight and a collapsed mesh leave axes of the map undetermined.
TEST(MeshMotion, FlatMeshesRoundTrip) {
  Random random(seed + 2);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  for (int axes = 0; axes < 3; axes++) {
    MovingMesh mesh = sheet(random, 8, 3, -1000, turned);
    for (Point& p : mesh.steps[0])
      for (int k = axes; k < 3; k++) p[k] = 7;
    expectMesh(mesh, encode(*encoder, mesh, 16, statistics));
    if (HasFatalFailure()) FAIL() << axes << " axes";
  }
}

// Distances from a line that are as small as rounding errors do not determine the map.
TEST(MeshMotion, NearlyStraightMeshesDetermineOneAxis) {
  for (int axis = 0; axis < 3; axis++) {
    float first[4][3], later[4][3], map[3][4];
    for (int v = 0; v < 4; v++)
      for (int k = 0; k < 3; k++) {
        first[v][k] = k == axis ? float(v) : v == k ? 1e-6f : 0.0f;
        later[v][k] = k == axis ? float(2 * v + 1) : 1.0f;
      }
    AffineFit fit;
    fit.setFirst(first, 4);
    fit.fit(later, map);
    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 4; i++)
        EXPECT_EQ(map[k][i], i == 3 ? 1.0f : k == axis && i == axis ? 2.0f : 0.0f) << "axis " << axis;
  }
}

TEST(MeshMotion, VerticesThatCoincideAtOneStepStaySeparate) {
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  MovingMesh mesh;
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
  mesh.steps = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 0, 0}},
                {{0.5f, 0, 0}, {1.5f, 0, 0}, {0.5f, 1, 0}, {-0.5f, 0, 0}, {-0.5f, 1, 0}, {-1.5f, 0, 0}}};
  const auto blocks = encode(*encoder, mesh, 16, statistics);
  expectMesh(mesh, blocks);
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_EQ(meshVertices(blocks[0].block()->counts), 6u);
}

TEST(MeshMotion, FirstStepIsStoredAsInAStillBlock) {
  Random random(seed + 3);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  auto other = std::make_unique<MeshEncoder>();
  for (int i = 0; i < 20; i++) {
    MeshStatistics statistics;
    const MovingMesh mesh = sheet(random, 11, 3, i % 2 ? -1000 : -12, bent);
    const auto blocks = encode(*encoder, mesh, 16, statistics);
    ASSERT_EQ(blocks.size(), 1u);
    std::vector<MeshTriangle> triangles;
    for (const auto& ids : mesh.triangles) {
      triangles.emplace_back();
      for (int c = 0; c < 3; c++)
        std::memcpy(triangles.back().corners[c], mesh.steps[0][ids[c]].data(), sizeof(float[3]));
      triangles.back().number = uint32_t(triangles.size() - 1);
    }
    alignas(16) uint8_t block[MeshEncoder::maxBytes];
    other->encodeCluster(triangles.data(), fullGroups(uint32_t(triangles.size()), 16), false, 3, block, statistics,
                         [&](size_t bytes, uint32_t, uint32_t) {
                           MeshHeader& header = *(MeshHeader*)block;
                           ASSERT_EQ(bytes, blocks[0].block()->motion);
                           header.bytes = blocks[0].block()->bytes;
                           header.motion = blocks[0].block()->motion;
                           header.counts |= 1u << 15; // version 7
                           EXPECT_EQ(std::memcmp(block, blocks[0].words.data(), bytes), 0);
                         });
  }
}

TEST(MeshMotion, RigidMotionAndBendingNeedFewBytes) {
  Random random(seed + 4);
  auto encoder = std::make_unique<MeshMotionEncoder>();
  struct Case {
    const char* name;
    Motion motion;
    int exponent;
    double most;
  }; // bytes per triangle and step
  for (const Case& of :
       {Case{"still", still, -14, 1.0}, Case{"still", still, -1000, 2.0}, Case{"turned", turned, -14, 1.4},
        Case{"turned", turned, -1000, 2.0}, Case{"bent", bent, -14, 2.6}, Case{"bent", bent, -1000, 4.9}}) {
    MeshStatistics statistics;
    const MovingMesh mesh = sheet(random, 40, 3, of.exponent, of.motion);
    expectMesh(mesh, encode(*encoder, mesh, 16, statistics));
    const double first = double(statistics.bytes) / double(statistics.triangles),
                 later = double(statistics.stepBytes) / double(2 * statistics.triangles);
    std::printf("%s, %s: %.2f bytes per triangle, %.2f per later step\n", of.name,
                of.exponent == -1000 ? "all floats" : "lattice", first, later);
    EXPECT_LT(later, of.most) << of.name;
    EXPECT_LT(later, 0.6 * first) << of.name;
  }
}

/* --- the page ----------------------------------------------------------------------------- */

// Two triangles that turn by a right angle, except for one corner.
MovingMesh annotatedMesh() {
  MovingMesh mesh;
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  mesh.steps = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 2}}, {{8, 0, 0}, {8, 4, 0}, {4, 0, 0}, {4, 5, 2}}};
  return mesh;
}

TEST(MeshMotion, EncoderWritesAnnotatedBlock) {
  auto encoder = std::make_unique<MeshMotionEncoder>();
  MeshStatistics statistics;
  const MovingMesh mesh = annotatedMesh();
  const auto blocks = encode(*encoder, mesh, 16, statistics);
  expectMesh(mesh, blocks);
  ASSERT_EQ(blocks.size(), 1u);
  expectAnnotatedBytes(blocks[0].block(), blocks[0].size(), "A moving mesh block");
}

TEST(MeshMotion, ConstantsAndFieldsMatchPage) {
  expectConstants("mesh.md", {{"format version, `movingMeshFormatVersion`", movingMeshFormatVersion},
                              {"bytes of the motion section", sizeof(VertMotion)},
                              {"bytes of the header of a step", meshStepBytes},
                              {"bytes of a record of a step", meshStepRecordBytes},
                              {"time steps, at most", maxTimeSteps}});
  expectRows("mesh.md", "A later step",
             {{"origin", offsetof(MeshStep, origin)},
              {"spacings", offsetof(MeshStep, spacings)},
              {"map", offsetof(MeshStep, map)},
              {"info", offsetof(MeshStep, info)}},
             0, meshStepBytes);
}

}} // namespace programs::test
