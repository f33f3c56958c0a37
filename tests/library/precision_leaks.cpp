// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays from inside closed surfaces hit at every precision of cVERT, and have the same hits in tiles: to the bit, unless
 * they meet a vertex or edge between blocks, where the order of blocks decides which of its triangles is reported. The
 * surfaces are cages, grids, quads and triangles, static and moving. Rays aim at stored vertices and
 * edges, straight on and grazing. Embree's robust kernel decides which points are inside.
 *
 * CBVH_AIMED_RAYS sets the number of rays for each precision, for example 10000000, and CBVH_AIMED_ISA the instruction
 * set, for example avx2. */

#include "basics/parallel.h"
#include "measure/leak_rays.h"
#include "support/diced_mesh.h"
#include "support/moving_surface.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace programs::test { namespace {

constexpr size_t raysByDefault = 400000;
constexpr unsigned steps = 3; // time steps of moving surfaces

size_t raysOfPrecision() {
  const char* const many = std::getenv("CBVH_AIMED_RAYS");
  return many ? std::strtoull(many, nullptr, 10) : raysByDefault;
}

// --- surfaces ------------------------------------------------------------------------------------

// A closed surface, star-shaped around the origin. edge: approximate length of a quad.
struct Closed {
  std::string name;
  double edge;
  bool moves;
  std::function<RTCGeometry(RTCDevice)> make;
};

std::vector<Closed> closedSurfaces(Random& random) {
  static Displacement displacement;
  displacement.amplitude = 0.03f;
  std::vector<Closed> all;
  for (unsigned timeSteps : {1u, steps}) {
    const bool moves = timeSteps > 1;
    const std::string suffix = moves ? ", moving" : "";
    const DicedMotion motion = [](const Vec& p, unsigned step) { return twisted(p, 0.2 * step); };
    const struct {
      const char* name;
      Cage cage;
      unsigned rate;
    } cages[] = {{"a cage of quads", cubeCage(), 64}, {"a cage of pentagons", prismCage(5), 32}};
    for (const auto& cage : cages)
      all.push_back({cage.name + suffix, 1.5 / cage.rate, moves, [=](RTCDevice device) {
                       SurfaceSettings settings;
                       settings.displacement = &displacement;
                       settings.rate = float(cage.rate);
                       settings.timeSteps = timeSteps;
                       settings.motion = motion;
                       settings.compression = RTC_COMPRESSION_CVERT;
                       return newSurface(device, cage.cage, settings);
                     }});
    Diced grids = dicedBall(4, 32);
    grids.motion = motion;
    const double edge = 1.5 / (4 * 32);
    all.push_back({"grids" + suffix, edge, moves,
                   [=](RTCDevice device) { return newGrids(device, grids, RTC_COMPRESSION_CVERT, 0, timeSteps); }});
    for (QuadOrder order : {QuadOrder::Rows, QuadOrder::Recursive}) {
      DicedMesh quads = meshOf(grids, order, random);
      quads.motion = motion;
      const DicedMesh mesh = order == QuadOrder::Rows ? quads : trianglesOf(quads, 1, 2);
      all.push_back({(mesh.isTriangleForm() ? "triangles" : "quads") + suffix, edge, moves,
                     [=](RTCDevice device) { return newMesh(device, mesh, RTC_COMPRESSION_CVERT, 0, timeSteps); }});
    }
  }
  return all;
}

// --- stored triangles ---------------------------------------------------------------------------------

// At a time, oriented outwards, and points to aim at.
class StoredAt {
public:
  AimPoints points;

  StoredAt(RTCGeometry geometry, float time) { forEachStoredPart(geometry, time, add, this); }

  // The triangles as a geometry of Embree's own triangle kernel.
  RTCGeometry newTriangles(RTCDevice device) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices);
    std::vector<std::array<unsigned, 3>> triangles;
    for (unsigned i = 0; i < vertices.size(); i += 3) triangles.push_back({i, i + 1, i + 2});
    setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles);
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = RTC_COMPRESSION_NONE;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    return geometry;
  }

private:
  static bool add(void* self, const CbvhPart* part) { return ((StoredAt*)self)->addPart(*part); }

  bool addPart(const CbvhPart& part) {
    const unsigned w = part.width, h = part.height;
    const auto at = [&](unsigned x, unsigned y) {
      const float* p = part.vertices + 3 * (y * w + x);
      return Vec3f{p[0], p[1], p[2]};
    };
    for (unsigned y = 0; y + 1 < h; y++)
      for (unsigned x = 0; x + 1 < w; x++) {
        addTriangle(at(x, y), at(x + 1, y), at(x, y + 1));
        addTriangle(at(x, y + 1), at(x + 1, y), at(x + 1, y + 1));
      }
    const int dx[] = {1, 0, -1, 0, 1, -1}, dy[] = {0, 1, 0, -1, -1, 1}; // the last two are diagonals
    for (unsigned y = 0; y < h; y++)
      for (unsigned x = 0; x < w; x++) {
        const bool onX = x == 0 || x + 1 == w, onY = y == 0 || y + 1 == h;
        const AimKind kind = onX && onY ? AtCageVertex : onX ? AtFaceBorder : onY ? AtBlockBorder : AtVertex;
        const auto neighbor = [&](unsigned i) {
          return std::array<unsigned, 2>{x + unsigned(dx[i]), y + unsigned(dy[i])};
        };
        const auto isPresent = [&](unsigned i) { return neighbor(i)[0] < w && neighbor(i)[1] < h; };
        unsigned turn = unsigned(points[kind].size());
        while (!isPresent(turn % 6)) turn++;
        const auto next = neighbor(turn % 6);
        const unsigned x0 = x > 0 ? x - 1 : x, x1 = x + 1 < w ? x + 1 : x;
        const unsigned y0 = y > 0 ? y - 1 : y, y1 = y + 1 < h ? y + 1 : y;
        const Vec3f normal = cross(at(x1, y) - at(x0, y), at(x, y1) - at(x, y0));
        if (!(length(normal) > 0)) continue;
        points[kind].push_back({at(x, y), at(next[0], next[1]), dot(normal, at(x, y)) > 0 ? normal : -normal});
      }
    return true;
  }

  void addTriangle(Vec3f a, Vec3f b, Vec3f c) {
    if (dot(cross(b - a, c - a), a + b + c) < 0) std::swap(b, c);
    for (const Vec3f& p : {a, b, c}) vertices.push_back({p.x, p.y, p.z});
  }

  std::vector<Vec> vertices; // three per triangle
};

// --- rays -----------------------------------------------------------------------------------------------

class TracerAt : public SceneTracer {
public:
  // other: must have the same hits; may be null.
  TracerAt(RTCScene scene, float time, bool inPackets, const TracerAt* other = nullptr)
    : single(scene),
      packets(scene),
      time(time),
      inPackets(inPackets),
      other(other) {}

  void intersect(RTCRayHit* rays, size_t n) const override {
    for (size_t i = 0; i < n; i++) rays[i].ray.time = time;
    std::vector<RTCRayHit> others(rays, rays + (other ? n : 0));
    tracer().intersect(rays, n);
    if (!other) return;
    other->intersect(others.data(), n);
    for (size_t i = 0; i < n; i++) {
      if (std::memcmp(&rays[i], &others[i], sizeof(RTCRayHit)) == 0) continue;
      (isSamePlace(rays[i], others[i]) ? numTies : numDifferent)++;
    }
  }

  void occluded(RTCRay* rays, size_t n) const override {
    for (size_t i = 0; i < n; i++) rays[i].time = time;
    std::vector<RTCRay> others(rays, rays + (other ? n : 0));
    tracer().occluded(rays, n);
    if (!other) return;
    other->occluded(others.data(), n);
    for (size_t i = 0; i < n; i++) numDifferent += std::memcmp(&rays[i], &others[i], sizeof(RTCRay)) != 0;
  }

  mutable std::atomic<size_t> numDifferent{0}; // hits that are not those of `other`
  mutable std::atomic<size_t> numTies{0};      // other triangles at the same place

private:
  // Distances to triangles that share the place differ by rounding, more at grazing angles.
  static bool isSamePlace(const RTCRayHit& a, const RTCRayHit& b) {
    return isHit(a) && isHit(b) && std::fabs(a.ray.tfar - b.ray.tfar) <= 1e-4f * a.ray.tfar;
  }

  const SceneTracer& tracer() const { return inPackets ? (const SceneTracer&)packets : single; }

  const EmbreeTracer single;
  const PacketTracer packets;
  const float time;
  const bool inPackets;
  const TracerAt* const other;
};

// The surface in a form. partOfEdge: see expectNoLeaks.
RTCGeometry newGeometry(RTCDevice device, const Closed& surface, RTCCompression compression, double partOfEdge) {
  RTCGeometry geometry = surface.make(device);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = compression;
  if (partOfEdge >= 0) args.maxError = float(partOfEdge * surface.edge);
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  return geometry;
}

// True if normals of hits point outwards, as countLeaks expects: a ray from the center hits the back of the surface.
bool pointsOutwards(RTCScene scene) {
  const RTCRayHit r = intersect(scene, makeRay({0, 0, 0}, {0.3f, 0.7f, 0.2f}));
  return isHit(r) && r.hit.Ng_x * r.ray.dir_x + r.hit.Ng_y * r.ray.dir_y + r.hit.Ng_z * r.ray.dir_z > 0;
}

// partOfEdge: max_error relative to an edge; negative for the default.
void expectNoLeaks(double partOfEdge) {
  Random random(1601);
  const char* const isa = std::getenv("CBVH_AIMED_ISA");
  Device device(isa ? std::string("isa=") + isa : "");
  ASSERT_TRUE(device) << isa;
  const std::vector<Closed> surfaces = closedSurfaces(random);
  const size_t raysOfRun = raysOfPrecision() / (2 * surfaces.size());
  size_t rays = 0, aimed = 0, leaks = 0, leaksOfRobust = 0, ties = 0;
  for (const Closed& surface : surfaces) {
    SCOPED_TRACE(surface.name);
    RTCGeometry geometry = newGeometry(device, surface, RTC_COMPRESSION_CVERT, partOfEdge);
    Scene scene(device), tiles(device);
    rtcAttachGeometry(scene, geometry);
    attach(tiles, newGeometry(device, surface, RTC_COMPRESSION_CTILE, partOfEdge));
    rtcCommitScene(scene);
    rtcCommitScene(tiles);
    ASSERT_NE(nodeAndLeafBytes(tiles), nodeAndLeafBytes(scene)) << "no tiles";
    ASSERT_GT(statisticsOf(scene).numQuads, 0u);
    ASSERT_EQ(statisticsOf(scene).maxVertexDeviation == 0, partOfEdge == 0);
    ASSERT_TRUE(pointsOutwards(scene));
    for (const bool inPackets : {false, true}) {
      SCOPED_TRACE(inPackets ? "packets" : "single rays");
      const float time = surface.moves ? float(random.uniform()) : 0;
      const StoredAt stored(geometry, time);
      Scene judge(device, RTC_SCENE_FLAG_ROBUST);
      attach(judge, stored.newTriangles(device));
      rtcCommitScene(judge);
      LeakSettings settings;
      settings.rays = raysOfRun;
      settings.seed = random.bits();
      const TracerAt inTiles(tiles, time, inPackets), tracer(scene, time, inPackets, &inTiles);
      const LeakCounts counts = countLeaks(judge, tracer, stored.points, settings, threadCount(0));
      rays += counts.rays;
      aimed += counts.aimed;
      leaksOfRobust += counts.gridLeaks.closest + counts.gridLeaks.any + counts.gridLeaks.through;
      leaks += counts.sceneLeaks.closest + counts.sceneLeaks.any + counts.sceneLeaks.through;
      EXPECT_EQ(tracer.numDifferent, 0u) << "hits in tiles differ";
      ties += tracer.numTies;
      EXPECT_GT(counts.aimed, raysOfRun / 2);
      EXPECT_EQ(counts.sceneLeaks.closest, 0u);
      EXPECT_EQ(counts.sceneLeaks.any, 0u);
      EXPECT_EQ(counts.sceneLeaks.through, 0u);
      for (const Ray& r : counts.examples)
        ADD_FAILURE() << "leaks from " << r.origin.x << " " << r.origin.y << " " << r.origin.z << " towards "
                      << r.direction.x << " " << r.direction.y << " " << r.direction.z << " at time " << time;
    }
    rtcReleaseGeometry(geometry);
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_GT(aimed, raysOfPrecision() / 2);
  testing::Test::RecordProperty("rays", std::to_string(rays));
  testing::Test::RecordProperty("aimed rays", std::to_string(aimed));
  testing::Test::RecordProperty("leaks", std::to_string(leaks));
  testing::Test::RecordProperty("other triangles in tiles", std::to_string(ties));
  testing::Test::RecordProperty("leaks of Embree's robust triangles", std::to_string(leaksOfRobust));
}

TEST(PrecisionLeaks, NoneByDefault) { expectNoLeaks(-1); }
TEST(PrecisionLeaks, NoneWithACoarseBound) { expectNoLeaks(0.125); }
TEST(PrecisionLeaks, NoneWithAFineBound) { expectNoLeaks(0.001); }
TEST(PrecisionLeaks, NoneLossless) { expectNoLeaks(0); }

}} // namespace programs::test
