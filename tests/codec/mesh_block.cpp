// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Mesh blocks are lossless: decoded triangles have the same floats, order of corners and numbers. A second decoder,
 * written from docs/formats/mesh.md, must agree with the first. */

#include "kernels/cvert/encoder/mesh_encoder.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "codec/format_pages.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <random>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 4711;

typedef std::array<float, 3> Point;
typedef std::vector<MeshTriangle> Mesh;

void add(Mesh& mesh, const Point& a, const Point& b, const Point& c, uint32_t primID) {
  MeshTriangle t;
  for (int k = 0; k < 3; k++) {
    t.corners[0][k] = a[k];
    t.corners[1][k] = b[k];
    t.corners[2][k] = c[k];
  }
  t.number = primID;
  mesh.push_back(t);
}

struct Encoded {
  alignas(16) uint8_t bytes[MeshEncoder::maxBytes];
  size_t size;
  uint32_t stored;

  const MeshHeader* block() const { return (const MeshHeader*)bytes; }
};

// Groups are runs of up to groupSize triangles.
std::vector<std::unique_ptr<Encoded>> encode(MeshEncoder& encoder, const Mesh& mesh, uint32_t groupSize,
                                             MeshStatistics& statistics) {
  std::vector<std::unique_ptr<Encoded>> blocks;
  for (size_t first = 0; first < mesh.size(); first += blocks.back()->stored) {
    const uint32_t room = uint32_t(std::min(mesh.size() - first, size_t(maxMeshTriangles)));
    std::vector<uint32_t> ends;
    for (uint32_t end = groupSize; ends.empty() || ends.back() < room; end += groupSize)
      ends.push_back(std::min(end, room));
    blocks.push_back(std::make_unique<Encoded>());
    Encoded& encoded = *blocks.back();
    encoded.size = encoder.encode(mesh.data() + first, ends.data(), uint32_t(ends.size()), 3, encoded.bytes,
                                  encoded.stored, statistics);
    EXPECT_GT(encoded.stored, 0u);
    EXPECT_LE(encoded.size, MeshEncoder::maxBytes);
    if (encoded.stored == 0) break;
  }
  return blocks;
}

std::string bytesOf(const MeshTriangle& t) {
  float p[9];
  for (int i = 0; i < 9; i++) p[i] = t.corners[i / 3][i % 3] + 0.0f; // maps -0 to 0
  return std::string((const char*)p, sizeof(p)) + std::string((const char*)&t.number, sizeof(t.number));
}

/* --- a decoder written from the page --------------------------------------------------- */

class PageDecoder {
public:
  Mesh triangles;

  explicit PageDecoder(const uint8_t* block) : block(block) {
    const uint32_t counts = word(48), info = word(52), spacings = word(12);
    const uint32_t vertices = (counts & 1023) + 1, groups = (counts >> 10 & 15) + 1, baseBits = counts >> 24 & 63;
    struct Group {
      uint32_t triangles, restarts, vertices, own, numberBits, lower[3], extent[3], bits[3];
    };
    std::vector<Group> all(groups);
    for (uint32_t g = 0; g < groups; g++) {
      const uint32_t byte = block[32 + g], record = block[56 + 2 * g] | block[57 + 2 * g] << 8;
      Group& group = all[g];
      group.triangles = (byte & 31) + 1;
      group.restarts = byte >> 5 | (record >> 15) << 3;
      group.vertices = record & 31;
      group.own = record >> 5 & 31;
      group.numberBits = (record >> 10 & 31) == 31 ? 32 : record >> 10 & 31;
      for (uint32_t k = 0; k < 3; k++) {
        group.lower[k] = block[56 + 2 * groups + k * groups + g];
        group.extent[k] = block[56 + 2 * groups + (3 + k) * groups + g];
        const bool ranks = (spacings >> 8 * k & 255) == 0;
        shift[k] = (info >> 4 * k & 15) + (ranks ? 9 : 0);
        group.bits[k] = bits((uint64_t(group.extent[k] + 1) << shift[k]) - 1);
      }
    }
    position = 8 * (56 + 8 * groups);
    struct Topology {
      std::vector<std::array<uint32_t, 3>> triangles;
    };
    std::vector<Topology> topology(groups);
    uint32_t firstOwn = 0;
    for (uint32_t g = 0; g < groups; g++) {
      const Group& group = all[g];
      const uint32_t n = group.triangles, stream = n + 2 + 2 * group.restarts;
      std::vector<bool> restarts(n, false), fans(n, false);
      for (uint32_t t = 1; t < n; t++) restarts[t] = read(1);
      for (uint32_t t = 1; t < n; t++) fans[t] = read(1);
      std::vector<uint32_t> firstCorners(n), entries(stream), numbers(group.vertices);
      for (uint32_t& firstCorner : firstCorners) firstCorner = read(2);
      std::vector<bool> isNew(stream, true), isOwn(group.vertices);
      for (uint32_t i = 3; i < stream; i++) isNew[i] = read(1);
      for (uint32_t i = 0; i < group.vertices; i++) isOwn[i] = read(1);
      uint32_t next = 0;
      for (uint32_t i = 0; i < stream; i++) entries[i] = isNew[i] ? next++ : read(bits(group.vertices - 1));
      for (uint32_t i = 0, own = firstOwn; i < group.vertices; i++)
        numbers[i] = isOwn[i] ? own++ : read(bits(vertices - 1));
      firstOwn += group.own;
      // triangle by triangle
      uint32_t at = 0, a = 0, b = 0, c = 0;
      bool flipped = false;
      for (uint32_t t = 0; t < n; t++) {
        if (t == 0 || restarts[t]) {
          a = entries[at++];
          b = entries[at++];
          c = entries[at++];
          flipped = false;
        } else if (fans[t]) {
          b = c;
          c = entries[at++];
        } else {
          a = b;
          b = c;
          c = entries[at++];
          flipped = !flipped;
        }
        const uint32_t corners[3] = {numbers[flipped ? b : a], numbers[flipped ? a : b], numbers[c]};
        const uint32_t first = firstCorners[t];
        topology[g].triangles.push_back({corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]});
      }
    }
    position = (position + 7) / 8 * 8;
    std::vector<Point> points;
    for (const Group& group : all)
      for (uint32_t v = 0; v < group.own; v++) {
        int64_t c[3];
        for (int k = 0; k < 3; k++) c[k] = read(group.bits[k]) + (int64_t(group.lower[k]) << shift[k]);
        const int m = info >> 12 & 3, s1 = signed5(info >> 16), s2 = signed5(info >> 21);
        const double sheared = std::floor((s1 * double(c[(m + 1) % 3]) + s2 * double(c[(m + 2) % 3]) + 8) / 16);
        if (s1 != 0 || s2 != 0) c[m] -= int64_t(sheared);
        Point p;
        for (int k = 0; k < 3; k++) {
          const uint32_t exponent = spacings >> 8 * k & 255;
          float origin;
          std::memcpy(&origin, block + 4 * k, 4);
          if (exponent != 0) {
            p[k] = float(double(origin) + double(c[k]) * std::ldexp(1.0, int(exponent) - 127));
            continue;
          }
          for (p[k] = origin; c[k] > 0; c[k]--) p[k] = next(p[k], c[k]);
        }
        points.push_back(p);
      }
    position = (position + 7) / 8 * 8;
    const uint32_t primID = word(20);
    for (uint32_t g = 0; g < groups; g++) {
      const uint32_t base = primID + read(baseBits);
      for (const auto& t : topology[g].triangles)
        add(triangles, points[t[0]], points[t[1]], points[t[2]], base + read(all[g].numberBits));
    }
    bytes = ((position + 7) / 8 + 3) / 4 * 4;
  }

  size_t bytes;

private:
  static uint32_t bits(uint64_t x) {
    uint32_t n = 0;
    for (; x; x >>= 1) n++;
    return n;
  }
  static int signed5(uint32_t x) { return int(x & 31) - ((x & 16) ? 32 : 0); }

  // Returns the float `steps` after x, but at most 0 if x is negative. Subtracts the used steps less 1 from `steps`.
  static float next(float x, int64_t& steps) {
    uint32_t bits;
    std::memcpy(&bits, &x, 4);
    const bool isNegative = bits >> 31;
    const uint32_t magnitude = bits & 0x7FFFFFFF;
    const int64_t room = isNegative ? std::max(int64_t(magnitude), int64_t(1)) : int64_t(1) << 32,
                  used = std::min(room, steps);
    if (isNegative && magnitude == 0) bits = uint32_t(used); // -0
    else bits = isNegative ? uint32_t(used) == magnitude ? 0 : bits - uint32_t(used) : bits + uint32_t(used);
    steps -= used - 1;
    std::memcpy(&x, &bits, 4);
    return x;
  }

  uint32_t word(size_t offset) const {
    uint32_t w;
    std::memcpy(&w, block + offset, 4);
    return w;
  }

  uint32_t read(uint32_t count) {
    uint64_t value = 0;
    for (uint32_t i = 0; i < count; i++, position++) value |= uint64_t(block[position / 8] >> position % 8 & 1) << i;
    return uint32_t(value);
  }

  const uint8_t* block;
  size_t position;
  uint32_t shift[3];
};

/* --- properties of all blocks ---------------------------------------------------------- */

long double shearedCoordinate(const MeshHeader* block, const float* p) {
  const uint32_t m = meshShearedAxis(block->info);
  long double h = ((long double)p[m] - block->origin[m]) / meshSpacing(block->spacings, m);
  for (uint32_t i = 1; i < 3; i++)
    h += meshSlope(block->info, i) / 16.0L * ((long double)p[(m + i) % 3] - block->origin[(m + i) % 3]) /
         meshSpacing(block->spacings, (m + i) % 3);
  return h * meshSpacing(block->spacings, m);
}

// Blocks must contain the mesh's triangles and have all properties that the format guarantees.
void expectMesh(const Mesh& mesh, const std::vector<std::unique_ptr<Encoded>>& blocks) {
  std::map<std::string, int> left;
  for (const MeshTriangle& t : mesh) left[bytesOf(t)]++;
  size_t count = 0;
  for (const auto& encoded : blocks) {
    const MeshHeader* const block = encoded->block();
    ASSERT_EQ(validateMesh(block, encoded->size).message(), "");
    ASSERT_EQ(block->bytes, encoded->size);
    ASSERT_EQ(block->surface, 3u);
    const auto decoded = std::make_unique<DecodedMesh>(block);
    ASSERT_EQ(decoded->numTriangles, encoded->stored);
    const PageDecoder second(encoded->bytes);
    ASSERT_EQ(second.bytes, encoded->size);
    ASSERT_EQ(second.triangles.size(), encoded->stored);
    const MeshView view(block);
    ASSERT_EQ(view.bytes(), encoded->size);
    for (uint32_t t = 0; t < decoded->numTriangles; t++) {
      MeshTriangle triangle;
      for (int c = 0; c < 3; c++)
        std::memcpy(triangle.corners[c], decoded->vertices[decoded->triangles[t][c]], sizeof(triangle.corners[c]));
      triangle.number = decoded->numbers[t];
      const auto found = left.find(bytesOf(triangle));
      ASSERT_TRUE(found != left.end() && found->second > 0)
          << "triangle " << t << ", primID " << triangle.number << " is not of the mesh";
      found->second--;
      ASSERT_EQ(bytesOf(second.triangles[t]), bytesOf(triangle)) << "triangle " << t << " by the page";
    }
    count += decoded->numTriangles;
    for (uint32_t g = 0; g < decoded->numGroups; g++) {
      const auto group = std::make_unique<DecodedMeshGroup>(view, g);
      float lower[3], upper[3];
      view.groupBox(g, lower, upper);
      for (uint32_t t = 0; t < group->numTriangles; t++)
        for (int c = 0; c < 3; c++) {
          const float p[3] = {group->corners[c][0][t], group->corners[c][1][t], group->corners[c][2][t]};
          ASSERT_EQ(std::memcmp(p, decoded->vertices[decoded->triangles[decoded->firstTriangle[g] + t][c]], sizeof(p)),
                    0)
              << "lane " << t;
          for (uint32_t k = 0; k < 3; k++) {
            const long double x =
                view.isSheared() && k == meshShearedAxis(block->info) ? shearedCoordinate(block, p) : (long double)p[k];
            ASSERT_LE(lower[k], x) << "group " << g << ", axis " << k;
            ASSERT_GE(upper[k], x) << "group " << g << ", axis " << k;
          }
        }
    }
  }
  EXPECT_EQ(count, mesh.size());
}

void expectMesh(MeshEncoder& encoder, const Mesh& mesh, uint32_t groupSize, MeshStatistics& statistics) {
  expectMesh(mesh, encode(encoder, mesh, groupSize, statistics));
}

float snapped(double x, int exponent) {
  return float(std::ldexp(std::floor(std::ldexp(x, -exponent) + 0.5), exponent));
}

bool areDifferent(const Point& a, const Point& b, const Point& c) { return a != b && b != c && c != a; }

/* A wavy sheet of triangles with random diagonals and random first corners, optionally on a lattice. */
Mesh sheet(Random& random, uint32_t size, int exponent, double far) {
  Mesh mesh;
  std::vector<Point> points;
  double axis[3][3], origin[3];
  for (int k = 0; k < 3; k++) {
    origin[k] = far * random.uniform(-1, 1);
    for (auto& a : axis) a[k] = random.uniform(-1, 1);
  }
  for (uint32_t y = 0; y <= size; y++)
    for (uint32_t x = 0; x <= size; x++) {
      const double u = x + random.uniform(-0.3, 0.3), v = y + random.uniform(-0.3, 0.3),
                   h = 0.3 * std::sin(0.4 * u) * std::cos(0.3 * v) + 0.02 * random.normal();
      Point p;
      for (int k = 0; k < 3; k++) {
        const double value = origin[k] + u * axis[0][k] + v * axis[1][k] + h * axis[2][k];
        p[k] = exponent > -1000 ? snapped(value, exponent) : float(value);
      }
      points.push_back(p);
    }
  for (uint32_t y = 0; y < size; y++)
    for (uint32_t x = 0; x < size; x++) {
      const uint32_t a = y * (size + 1) + x, b = a + 1, c = a + size + 1, d = c + 1;
      const bool other = random.chance(0.5);
      uint32_t t[2][3] = {{a, b, other ? d : c}, {other ? a : b, d, c}};
      for (auto& corners : t) {
        std::rotate(corners, corners + random.below(3), corners + 3);
        if (areDifferent(points[corners[0]], points[corners[1]], points[corners[2]]))
          add(mesh, points[corners[0]], points[corners[1]], points[corners[2]], uint32_t(mesh.size()));
      }
    }
  return mesh;
}

/* --- tests ------------------------------------------------------------------------------ */

TEST(MeshBlock, SheetsRoundTrip) {
  Random random(seed);
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  for (int i = 0; i < 300; i++) {
    const int exponent = i % 3 == 0 ? -1000 : -int(random.below(16));
    Mesh mesh = sheet(random, 1 + random.below(12), exponent, std::vector<double>{0, 10, 1e4, 1e6}[random.below(4)]);
    if (mesh.empty()) continue;
    const uint32_t first = random.chance(0.5) ? random.bits() : 0;
    for (MeshTriangle& t : mesh) t.number = random.chance(0.1) ? random.bits() : t.number + first;
    expectMesh(*encoder, mesh, std::vector<uint32_t>{1, 3, 16, 32}[random.below(4)], statistics);
    if (HasFatalFailure()) FAIL() << "sheet " << i;
  }
  EXPECT_GT(statistics.rankAxes, 30u);
  EXPECT_GT(statistics.shearedBlocks, 30u);
  EXPECT_LT(statistics.shearedBlocks, statistics.blocks);
}

// Any three of a few vertices: edges of many triangles, both orientations, duplicates.
TEST(MeshBlock, NonManifoldTrianglesRoundTrip) {
  Random random(seed + 1);
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  for (int i = 0; i < 300; i++) {
    std::vector<Point> points(4 + random.below(i % 2 ? 8 : 300));
    for (Point& p : points)
      for (float& x : p) x = float(random.below(1000));
    Mesh mesh;
    for (uint32_t n = 1 + random.below(300); mesh.size() < n;) {
      const Point a = points[random.below(uint32_t(points.size()))], b = points[random.below(uint32_t(points.size()))],
                  c = points[random.below(uint32_t(points.size()))];
      if (areDifferent(a, b, c)) add(mesh, a, b, c, random.below(4));
      else if (points.size() < 8) points.push_back({float(random.below(9)), float(random.below(9)), 0});
    }
    expectMesh(*encoder, mesh, std::vector<uint32_t>{7, 16, 32}[i % 3], statistics);
    if (HasFatalFailure()) FAIL() << "mesh " << i;
  }
  EXPECT_GT(statistics.groups, statistics.triangles / 16) << "no group was split";
}

TEST(MeshBlock, DifficultMeshesRoundTrip) {
  Random random(seed + 2);
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  std::map<std::string, Mesh> meshes;
  for (int i = 0; i < 300; i++) {
    const auto f = [&](double a, double b) { return float(random.uniform(a, b)); };
    const uint32_t n = uint32_t(i);
    add(meshes["one triangle many times"], {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n);
    const double s = 2 * M_PI * i / 300, t = 2 * M_PI * (i + 1) / 300;
    add(meshes["a fan around a vertex"], {0, 0, 1}, {float(std::cos(s)), float(std::sin(s)), 0},
        {float(std::cos(t)), float(std::sin(t)), 0}, n);
    add(meshes["pages of a book"], {0, 0, 0}, {0, 0, 1}, {float(std::cos(s)), float(std::sin(s)), 0.5f}, n);
    add(meshes["needles of aspect 1e6"], {f(-1, 1), f(-1, 1), f(-1, 1)}, {f(-1, 1) + 1e6f, 0, 0},
        {f(-1, 1) + 1e6f, 1, 0}, n);
    const float x = float(i), huge = i == 77 ? 1e7f : 1;
    add(meshes["a huge triangle among small ones"], {x, 0, 0}, {x + huge, 0, f(0, 1)}, {x, huge, 0}, n);
    const float place = i % 2 ? 1e17f : -1e3f;
    add(meshes["far components"], {place + x, 0, 0}, {place * 1.01f, 5, f(0, 1)}, {0.1f, place, 0.7f}, n);
    for (float scale : {1e-38f, 1e-30f, 1e-20f, 1e10f, 1e18f})
      add(meshes["scale " + std::to_string(std::log10(scale))], {scale * f(-1, 1), scale * f(-1, 1), scale * f(-1, 1)},
          {scale * f(-1, 1), 0, scale}, {-0.0f, scale * f(-1, 1), scale * f(-1, 1)}, n);
    const auto any = [&] { return float((random.chance(0.5) ? -1 : 1) * random.magnitude(1e-45, 1.8e18)); };
    add(meshes["any floats"], {any(), any(), any()}, {any(), any(), any()}, {any(), any(), any()}, random.bits());
    add(meshes["denormals"], {1e-45f * float(i + 1), 0, 0}, {0, 1e-45f * float(2 * i + 1), 1e-40f},
        {-1e-44f, -1e-45f, 1}, n);
    add(meshes["a plane"], {f(0, 1), f(0, 1), 0.1f}, {f(1, 2), f(0, 1), 0.1f}, {f(0, 1), f(1, 2), 0.1f}, n);
    add(meshes["numbers of all sizes"], {0, 0, 0}, {x + 1, 0, 0}, {0, x + 1, 0},
        i == 0   ? 0
        : i == 1 ? ~0u
                 : random.bits() >> random.below(32));
  }
  for (const auto& mesh : meshes)
    for (uint32_t groupSize : {1u, 16u, 32u}) {
      SCOPED_TRACE(mesh.first);
      expectMesh(*encoder, mesh.second, groupSize, statistics);
      if (HasFatalFailure()) return;
    }
}

// On coordinates of 23 bits: an inclined sheet whose shear moves the origin far, and a vertex below it.
TEST(MeshBlock, LargeShearsRoundTrip) {
  Random random(seed + 6);
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  const uint32_t size = 15;
  for (int i = 0; i < 60; i++) {
    const double below = 0.01 * i;
    std::vector<Point> points;
    for (uint32_t y = 0; y <= size; y++)
      for (uint32_t x = 0; x <= size; x++) {
        const double u = 0.999 * x / size, v = 0.999 * y / size, h = std::max(0.94 * (u + v) - 0.93, 0.0);
        points.push_back({float(1 + u), float(1 + v), float(1 + h + std::ldexp(random.below(64), -23))});
      }
    Mesh mesh;
    for (uint32_t y = 0; y < size; y++)
      for (uint32_t x = size - y; x < size; x++) {
        const uint32_t a = y * (size + 1) + x, c = a + size + 1;
        add(mesh, points[a], points[a + 1], points[c + 1], uint32_t(mesh.size()));
        add(mesh, points[a], points[c + 1], points[c], uint32_t(mesh.size()));
      }
    add(mesh, {1.999f, 1.999f, float(1.9 - below)}, points[points.size() - 2], points.back(), uint32_t(mesh.size()));
    expectMesh(*encoder, mesh, 16, statistics);
    if (HasFatalFailure()) FAIL() << below;
  }
  EXPECT_GT(statistics.shearedBlocks, 0u);
  EXPECT_LT(statistics.shearedBlocks, statistics.blocks);
}

TEST(MeshBlock, GroupsDecodeIndependently) {
  Random random(seed + 3);
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  const Mesh mesh = sheet(random, 11, -8, 10);
  const auto blocks = encode(*encoder, mesh, 16, statistics);
  ASSERT_EQ(blocks.size(), 1u);
  const Encoded& whole = *blocks[0];
  const MeshView view(whole.block());
  ASSERT_GT(view.groups, 10u);
  for (uint32_t g = 0; g < view.groups; g++) {
    const auto group = std::make_unique<DecodedMeshGroup>(view, g);
    // Sets all bits that the group does not need to 1.
    auto damaged = std::make_unique<Encoded>(whole);
    const auto setBits = [&](const uint8_t* section, size_t begin, size_t end) {
      for (size_t b = begin; b < end; b++) damaged->bytes[size_t(section - whole.bytes) + b / 8] |= uint8_t(1 << b % 8);
    };
    for (uint32_t o = 0; o < view.groups; o++) {
      if (o == g) continue;
      setBits(view.topology, view.topologyBegin[o], view.topologyBegin[o + 1]);
      setBits(view.numbers, view.numberBegin[o], view.numberBegin[o + 1]);
    }
    for (uint32_t v = 0; v < meshVertices(whole.block()->counts); v++) {
      if (std::find(group->vertices, group->vertices + group->numVertices, v) != group->vertices + group->numVertices)
        continue;
      const uint32_t owner = view.groupOfVertex(v),
                     bits = view.fieldBits[owner][0] + view.fieldBits[owner][1] + view.fieldBits[owner][2];
      const size_t at = view.vertexBegin[owner] + size_t(v - view.firstVertex[owner]) * bits;
      setBits(view.vertices, at, at + bits);
    }
    const auto again = std::make_unique<DecodedMeshGroup>(MeshView(damaged->block()), g);
    for (uint32_t t = 0; t < group->numTriangles; t++) {
      ASSERT_EQ(again->numbers[t], group->numbers[t]);
      for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
          ASSERT_EQ(again->corners[c][k][t], group->corners[c][k][t]) << "group " << g << ", lane " << t;
    }
  }
}

TEST(MeshBlock, BuffersHoldAllSizes) {
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  Random random(seed + 4);
  Mesh mesh;
  const auto any = [&] { return float((random.chance(0.5) ? -1 : 1) * random.magnitude(1e-45, 1.8e18)); };
  for (int i = 0; i < 2000; i++)
    add(mesh, {any(), any(), any()}, {any(), any(), any()}, {any(), any(), any()}, random.bits());
  size_t most = 0;
  for (const auto& block : encode(*encoder, mesh, 32, statistics)) most = std::max(most, block->size);
  EXPECT_GT(most, 5000u);
  // an upper bound that no mesh reaches: each section at its largest size
  const size_t topology = maxMeshGroups * ((31 + 31 + 64 + 61 + 31 + 61 * 5 + 31 * 9 + 7) / 8),
               vertices = maxMeshVertices * 12, numbers = maxMeshTriangles * 4 + maxMeshGroups * 4;
  EXPECT_LE(meshHeaderBytes + 8 * maxMeshGroups + topology + vertices + numbers + 8, MeshEncoder::maxBytes);
}

/* --- strips ---------------------------------------------------------------------------- */

// Groups are divided at the end of a block, because of vertices or strips. At the first seeds, cutting off a half
// divides the last group elsewhere: the shorter block then ends earlier, within another quad.
TEST(MeshBlock, HalvesOfAQuadStayInOneBlock) {
  std::vector<uint32_t> seeds = {34854, 46029, 52542, 73968, 112940, 211336, 256211, 275941, 276798, 479549};
  for (uint32_t i = 0; i < 300; i++) seeds.push_back(i);
  auto encoder = std::make_unique<MeshEncoder>();
  Encoded encoded;
  size_t divided = 0;
  for (uint32_t s : seeds) {
    std::mt19937 random(s);
    const auto below = [&](uint32_t n) { return uint32_t(random() % n); };
    Mesh mesh;
    MeshGroups groups;
    const uint32_t numGroups = 9 + below(8);
    for (uint32_t g = 0; g < numGroups && mesh.size() < 254; g++) {
      const uint32_t points = 20 + below(30), room = uint32_t(256 - mesh.size());
      for (uint32_t n = std::min(2 * (8 + below(9)), room); n > 0; n--) {
        uint32_t c[3];
        do
          for (uint32_t& corner : c) corner = below(points);
        while (c[0] == c[1] || c[1] == c[2] || c[0] == c[2]);
        const auto point = [&](uint32_t i) { return Point{float(i + 100 * g), float(i * 7 % 13), float(i * 5 % 11)}; };
        add(mesh, point(c[0]), point(c[1]), point(c[2]), uint32_t(mesh.size()));
      }
      groups.add(uint32_t(mesh.size()));
    }
    MeshStatistics statistics;
    uint32_t next = 0;
    encoder->encodeCluster(mesh.data(), groups, true, 1, encoded.bytes, statistics,
                           [&](size_t, uint32_t first, uint32_t count) {
                             EXPECT_EQ(first, next);
                             next = first + count;
                             if (next == mesh.size()) return;
                             EXPECT_EQ(next % 2, 0u) << "seed " << s;
                             EXPECT_GE(count + 1, maxMeshGroups);
                             divided++;
                           });
    ASSERT_EQ(next, mesh.size());
  }
  EXPECT_GT(divided, 200u);
}

TEST(MeshStrips, RanksCountFloats) {
  float x = -1.0f;
  for (uint32_t i = 0, first = rankOfFloat(x); i < 1000; i++, x = std::nextafterf(x, 2)) {
    ASSERT_EQ(rankOfFloat(x), first + i);
    ASSERT_EQ(floatOfRank(first + i), x);
  }
  x = -10 * 1.401298464e-45f;
  for (int i = -10; i <= 10; i++, x = std::nextafterf(x, 2)) {
    ASSERT_EQ(rankOfFloat(x), 0x80000000u + uint32_t(i));
    ASSERT_EQ(floatOfRank(0x80000000u + uint32_t(i)), x);
  }
}

/* --- the page ----------------------------------------------------------------------------- */

// The sides of a pyramid are in one group, its base and a separate triangle in another.
Mesh annotatedMesh() {
  Mesh mesh;
  const Point apex = {104, 8, 6}, base[4] = {{100, 0, 0}, {108, 0, 0}, {108, 16, 0}, {100, 16, 0}};
  for (uint32_t i = 0; i < 4; i++) add(mesh, base[i], base[(i + 1) % 4], apex, 40 + i);
  add(mesh, base[0], base[2], base[1], 50);
  add(mesh, base[0], base[3], base[2], 51);
  add(mesh, {112, 0, 0}, {116, 0, 0}, {112, 0, 4}, 52);
  return mesh;
}

TEST(MeshBlock, EncoderWritesAnnotatedBlock) {
  auto encoder = std::make_unique<MeshEncoder>();
  MeshStatistics statistics;
  const Mesh mesh = annotatedMesh();
  const auto blocks = encode(*encoder, mesh, 4, statistics);
  expectMesh(mesh, blocks);
  ASSERT_EQ(blocks.size(), 1u);
  expectAnnotatedBytes(blocks[0]->bytes, blocks[0]->size, "A mesh block");
}

TEST(MeshBlock, ConstantsAndFieldsMatchPage) {
  expectConstants("mesh.md", {{"format version, `meshFormatVersion`", meshFormatVersion},
                              {"kind of a block, `kindOfMesh`", kindOfMesh},
                              {"bytes of the header", meshHeaderBytes},
                              {"bytes of a record", meshRecordBytes},
                              {"bytes of a box", meshBoxBytes},
                              {"triangles of a block, at most", maxMeshTriangles},
                              {"groups of a block, at most", maxMeshGroups},
                              {"vertices of a block, at most", maxMeshVertices},
                              {"triangles of a group, at most", maxGroupTriangles},
                              {"vertices of a group, at most", maxGroupVertices},
                              {"restarts of a group, at most", maxGroupRestarts},
                              {"shift of boxes on an axis of ranks, at least", minRankShift},
                              {"bytes after a block that decoders may read", vertReadPadding}});
  expectRows("mesh.md", "Header",
             {{"origin", offsetof(MeshHeader, origin)},
              {"spacings", offsetof(MeshHeader, spacings)},
              {"surface", offsetof(MeshHeader, surface)},
              {"primID", offsetof(MeshHeader, primID)},
              {"bytes", offsetof(MeshHeader, bytes)},
              {"motion", offsetof(MeshHeader, motion)},
              {"groups", offsetof(MeshHeader, groups)},
              {"counts", offsetof(MeshHeader, counts)},
              {"info", offsetof(MeshHeader, info)}},
             0, meshHeaderBytes);
}

}} // namespace programs::test
