// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Every cage, level and frame level that can be compressed, against GRID through the
 * API. cGRID finds GRID's hits to a few ulps. cVOXEL and cLEAF are approximate:
 *
 *   - where they hit and GRID does not, and where both hit, GRID's surface lies within
 *     the box of the leaf, as that contains its quad;
 *   - where GRID hits, so do they: cVOXEL always, as boxes contain the surface, cLEAF
 *     unless the ray grazes, as its patches bound the vertices of a quad, which a
 *     triangle between them may leave;
 *   - across the surface they differ by the thickness that the statistics report,
 *     but for hits on what a leaf extrapolates past its quad. */

#include "kernels/cbvh/frame.h"
#include "kernels/cbvh/node_codec.h"
#include "scene_blocks.h"
#include "test_random.h"
#include "test_scene.h"

#include <algorithm>
#include <map>

namespace cbvh {
namespace {

constexpr float ulp = std::numeric_limits<float>::epsilon();

Cage creasedCube(float sharpness)
{
  Cage cage = cubeCage();
  cage.creases = {{0,1}, {1,3}, {3,2}, {2,0}, {4,5}};
  cage.creaseWeights = {sharpness, 1.5f, 0.5f, sharpness, sharpness};
  return cage;
}

Cage corneredCube()
{
  Cage cage = cubeCage();
  cage.corners = {0, 5, 6};
  cage.cornerWeights = {std::numeric_limits<float>::infinity(), 2.5f, 0.7f};
  return cage;
}

Cage sheetWithHoles()
{
  Cage cage = sheetCage(4);
  cage.holes = {5, 6, 11};
  return cage;
}

Cage sheetOfMode(RTCSubdivisionMode mode)
{
  Cage cage = sheetCage(3);
  cage.mode = mode;
  return cage;
}

const std::map<std::string, Cage> cages = {
  {"Quad", quadCage()}, {"Cube", cubeCage()},
  {"Triangles", prismCage(3)}, {"Pentagons", prismCage(5)}, {"Hexagons", prismCage(6)}, {"Heptagons", prismCage(7)},
  {"SemiSharpCreases", creasedCube(1.7f)}, {"InfiniteCreases", creasedCube(std::numeric_limits<float>::infinity())}, {"Corners", corneredCube()},
  {"NoBoundary", sheetOfMode(RTC_SUBDIVISION_MODE_NO_BOUNDARY)}, {"SmoothBoundary", sheetOfMode(RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY)},
  {"PinCorners", sheetOfMode(RTC_SUBDIVISION_MODE_PIN_CORNERS)}, {"PinBoundary", sheetOfMode(RTC_SUBDIVISION_MODE_PIN_BOUNDARY)},
  {"PinAll", sheetOfMode(RTC_SUBDIVISION_MODE_PIN_ALL)}, {"Holes", sheetWithHoles()},
  {"Valence3", trapezohedronCage(3)}, {"Valence5", trapezohedronCage(5)}, {"Valence8", trapezohedronCage(8)}, {"Valence16", trapezohedronCage(16)},
};

std::vector<RTCRayHit> raysAt(Random& random, unsigned count)
{
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < count; i++) {
    Vec o, d;
    double length = 0;
    double n[3];
    for (double& x : n) { x = random.normal(); length += x*x; }
    for (int k = 0; k < 3; k++) {
      o[k] = float(4*n[k]/std::sqrt(length));
      d[k] = float(0.45*random.normal()) - o[k];
    }
    rays.push_back(makeRay(o, d));
  }
  return rays;
}

Vec hitPoint(const RTCRayHit& r) {
  return {r.ray.org_x + r.ray.tfar*r.ray.dir_x, r.ray.org_y + r.ray.tfar*r.ray.dir_y, r.ray.org_z + r.ray.tfar*r.ray.dir_z};
}

double dot(const double a[3], const double b[3]) { return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]; }

void unitNormal(const RTCRayHit& r, double n[3])
{
  const double x = r.hit.Ng_x, y = r.hit.Ng_y, z = r.hit.Ng_z, l = std::sqrt(x*x + y*y + z*z);
  n[0] = x/l; n[1] = y/l; n[2] = z/l;
}

// Lengths of the shortest and the longest edge.
std::pair<float, float> edgeLengths(const Cage& cage)
{
  std::pair<float, float> range(INFINITY, 0);
  size_t first = 0;
  for (unsigned n : cage.faces) {
    for (unsigned i = 0; i < n; i++) {
      const Vec &a = cage.positions[cage.indices[first + i]], &b = cage.positions[cage.indices[first + (i+1) % n]];
      const float length = std::hypot(a[0]-b[0], a[1]-b[1], a[2]-b[2]);
      range = {std::min(range.first, length), std::max(range.second, length)};
    }
    first += n;
  }
  return range;
}

void expectEqualToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage)
{
  const double face = 0.5*edgeLengths(cage).first;
  unsigned hits = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), occluded(grid, ray));
    ASSERT_EQ(isHit(b), isHit(a));
    if (!isHit(a)) continue;
    hits++;
    ASSERT_EQ(b.hit.geomID, a.hit.geomID);
    double m[3], n[3];
    unitNormal(a, m);
    unitNormal(b, n);
    const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z}, length = std::sqrt(dot(d, d));
    const double cosine = std::fabs(dot(d, m))/length;
    // GRID keeps u and v as integers of 8/65536, which levels up to 8 hit exactly. Where GRID cuts a
    // face into 8 x 8 quads its vertices may round another way, and the compiler may fuse one of two
    // copies of the same test another way: that shifts a hit by ulps of t over the cosine, and u and v
    // by as much out of the length of a face.
    ASSERT_LE(std::fabs(b.ray.tfar - a.ray.tfar), 4*ulp*(a.ray.tfar + 1/(cosine*length)));
    if (b.hit.primID != a.hit.primID) continue; // on the border of two faces either may come first
    ASSERT_GT(dot(m, n), 1 - 1e-5);
    const double tolerance = 4*ulp*(1 + 1/(cosine*face));
    ASSERT_LE(std::fabs(b.hit.u - a.hit.u), tolerance);
    ASSERT_LE(std::fabs(b.hit.v - a.hit.v), tolerance);
  }
  EXPECT_GT(hits, rays.size()/10);
}

// Whether GRID has a surface within a distance of a point. Probes start beside the point,
// as it may lie in the plane of the surface, past its border.
bool isNearGrid(RTCScene grid, const Vec& p, float distance)
{
  Random random(1);
  for (int i = 0; i < 1000; i++) {
    Vec o = p, d;
    double q[3], r[3], q2 = 0, r2 = 0;
    for (int k = 0; k < 3; k++) {
      q[k] = random.normal(); q2 += q[k]*q[k];
      r[k] = random.normal(); r2 += r[k]*r[k];
    }
    const double beside = random.uniform(0, 0.5);
    for (int k = 0; k < 3; k++) {
      o[k] += float(beside*distance*q[k]/std::sqrt(q2));
      d[k] = float(r[k]/std::sqrt(r2));
    }
    if (occluded(grid, makeRay(o, d, 0, float(1 - beside)*distance))) return true;
  }
  return false;
}

// Distance from a point to the farthest corner of the boxes of the leaves that report
// these parameters: no part of their quads is farther. Several on the border of two.
float reachOfLeaf(const std::vector<const embree::cbvh::Block*>& blocks, const RTCRayHit& r)
{
  using namespace embree::cbvh;
  const Vec point = hitPoint(r);
  double reach = 0;
  for (const Block* block : blocks) {
    if (block->primID != r.hit.primID) continue;
    const double rounding = 1e-3, quads = 1u << block->height();
    const double x = (r.hit.u - block->u0*0.5)*block->quadsX() - block->blockX()*quads;
    const double y = (r.hit.v - block->v0*0.5)*block->quadsY() - block->blockY()*quads;
    auto row = [&](int k, double d) { return Form{{block->columns[0][k], block->columns[1][k], block->columns[2][k]}, d}; };
    const FrameMap map = {row(0, 0.5), row(1, 0.5), row(2, 0.5), row(3, 1), true};
    for (double i = std::floor(x - rounding); i <= x + rounding; i++)
      for (double j = std::floor(y - rounding); j <= y + rounding; j++) {
        if (i < 0 || j < 0 || i >= quads || j >= quads) continue;
        const uint32_t leaf = morton(uint32_t(i), uint32_t(j));
        NodeBox box = NodeBox::root();
        for (uint32_t level = 0; level < block->height(); level++) {
          const uint32_t m = leaf >> 2*(block->height() - level), child = (leaf >> 2*(block->height() - level - 1)) & 3;
          box = decodeChild(block->nodes()[nodesOfLevels(level) + m], int(child), box);
        }
        for (int c = 0; c < 8; c++) {
          Double3 p;
          EXPECT_TRUE(unproject(map, c & 1 ? box.upper(0) : box.lower[0], c & 2 ? box.upper(1) : box.lower[1], c & 4 ? box.upper(2) : box.lower[2], p));
          reach = std::max(reach, length(Double3{p.x + block->centre[0] - point[0], p.y + block->centre[1] - point[1], p.z + block->centre[2] - point[2]}));
        }
      }
  }
  return float(reach);
}

void expectCloseToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, RTCCompression compression, unsigned level, const Cage& cage)
{
  const float thickness = statisticsOf(scene).maxLeafThickness;
  // Catmull-Clark pulls faces of high valence together, to about half their width.
  const float quad = edgeLengths(cage).second/float(1u << level), narrow = 0.5f*edgeLengths(cage).first/float(1u << level);
  const std::vector<const embree::cbvh::Block*> blocks = sceneBlocks(scene);
  // A quad's two triangles leave its bilinear patch by a quarter of its twist, the mixed
  // derivative of the displacement, at most amplitude times twice the frequency squared.
  const float twist = 0.25f*2*Displacement().amplitude*Displacement().frequency*Displacement().frequency*quad*quad;
  unsigned hits = 0, misses = 0, falseHits = 0, compared = 0, across = 0, otherWay = 0, parameters = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), isHit(b));
    hits += isHit(a);
    if (isHit(a) && !isHit(b)) {
      ASSERT_NE(compression, RTC_COMPRESSION_VOXEL) << "a box contains the surface: no misses";
      double m[3];
      unitNormal(a, m);
      const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
      EXPECT_LT(std::fabs(dot(d, m))/std::sqrt(dot(d, d)), 0.5) << "a ray that does not graze is missed";
      misses++;
    }
    falseHits += isHit(b) && !isHit(a);
    if (isHit(b)) {
      ASSERT_EQ(b.hit.geomID, 0u);
      ASSERT_GE(b.hit.u, 0);
      ASSERT_GE(b.hit.v, 0);
      const double n2 = double(b.hit.Ng_x)*b.hit.Ng_x + double(b.hit.Ng_y)*b.hit.Ng_y + double(b.hit.Ng_z)*b.hit.Ng_z;
      ASSERT_GT(n2, 0);
      const float reach = reachOfLeaf(blocks, b);
      ASSERT_GT(reach, 0) << "no leaf has these parameters: face " << b.hit.primID << ", " << b.hit.u << ", " << b.hit.v;
      ASSERT_TRUE(isNearGrid(grid, hitPoint(b), reach)) << "nothing within " << reach << " of a hit, quad " << quad << ", thickness " << thickness;
    }
    if (!isHit(a) || !isHit(b)) continue;
    double m[3], n[3];
    unitNormal(a, m);
    unitNormal(b, n);
    const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
    const double cosine = std::fabs(dot(d, m))/std::sqrt(dot(d, d));
    if (cosine < 0.5 || a.hit.primID != b.hit.primID) continue;
    compared++;
    across += std::fabs(double(b.ray.tfar) - a.ray.tfar)*std::fabs(dot(d, m)) <= thickness + twist;
    otherWay += dot(m, n) <= 0;
    parameters += std::hypot(b.hit.u - a.hit.u, b.hit.v - a.hit.v)*float(1u << level) <= 1.5f + 2*thickness/narrow;
  }
  EXPECT_GT(hits, rays.size()/10);
  EXPECT_GT(compared, hits/3);
  // The rest: a leaf's box reaches past its quad, and what is extrapolated there may be hit first.
  EXPECT_GE(across, compared - compared/20) << "of " << compared << " hits lie within the thickness";
  EXPECT_LE(otherWay, compared/100) << "of " << compared << " normals point the other way";
  EXPECT_GE(parameters, compared - compared/20) << "of " << compared << " parameters agree";
  EXPECT_LE(misses, hits/200 + 1);
  // A border as wide as the thickness and the overlap of boxes around a sheet
  // that is 2 wide is four times their ratio to it, and as much again for folds.
  EXPECT_LE(falseHits, hits*std::min(1.0f, 8*(thickness + 0.25f*quad)/2) + 2);
}

void compare(Device& device, const Cage& cage, unsigned level, int frameLevel, unsigned numRays, uint32_t seed)
{
  Random random(seed);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = float(1u << level);
  const std::vector<RTCRayHit> rays = raysAt(random, numRays);
  Scene grid(device);
  settings.compression = RTC_COMPRESSION_NONE;
  addSurface(device, grid, cage, settings);
  rtcCommitScene(grid);
  for (RTCCompression compression : {RTC_COMPRESSION_GRID, RTC_COMPRESSION_VOXEL, RTC_COMPRESSION_LEAF}) {
    SCOPED_TRACE(testing::Message() << "compression " << compression << ", level " << level << ", frame level " << frameLevel);
    Scene scene(device);
    settings.compression = compression;
    settings.frameLevel = frameLevel;
    addSurface(device, scene, cage, settings);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_GT(stats.numQuads, 0u);
    EXPECT_EQ(stats.numGridQuads, 0u);
    EXPECT_EQ(stats.numInvalidQuads, 0u);
    if (compression == RTC_COMPRESSION_GRID) expectEqualToGrid(grid, scene, rays, cage);
    else expectCloseToGrid(grid, scene, rays, compression, level, cage);
    if (testing::Test::HasFatalFailure()) return;
  }
}

class Surfaces : public testing::TestWithParam<std::string> {};

TEST_P(Surfaces, AreFoundAsGridFindsThem)
{
  Device device;
  for (int frameLevel : {0, 1, 2, 4}) compare(device, cages.at(GetParam()), 4, frameLevel, 1500, 41);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

std::vector<std::string> cageNames()
{
  std::vector<std::string> names;
  for (const auto& cage : cages) names.push_back(cage.first);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Cage, Surfaces, testing::ValuesIn(cageNames()), [](const auto& info) { return info.param; });

TEST(SurfaceLevels, EveryLevelAndFrameLevelIsFoundAsGridFindsIt)
{
  Device device;
  Cage cage = sheetCage(1);
  cage.mode = RTC_SUBDIVISION_MODE_PIN_CORNERS;
  for (unsigned level = 1; level <= 8; level++)
    for (int frameLevel = 0; frameLevel <= int(level); frameLevel++) {
      compare(device, cage, level, frameLevel, 300, 42);
      if (HasFatalFailure()) return;
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// A frame level past the level leaves one quad a block.
TEST(SurfaceLevels, FrameLevelsPastTheLevelAreClamped)
{
  Device device;
  Displacement displacement;
  for (unsigned level : {0, 1, 3}) {
    Scene scene(device);
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = float(1u << level);
    settings.compression = RTC_COMPRESSION_LEAF;
    settings.frameLevel = 8;
    addSurface(device, scene, cubeCage(), settings);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numBlocks, 6*(size_t(1) << (2*level)));
    EXPECT_EQ(statisticsOf(scene).numQuads, 6*(size_t(1) << (2*level)));
  }
}

// --- what is traced by GRID --------------------------------------------------------------

// The same surface in a scene that compresses and in one that does not; levels of all
// edges when given.
void compareUncompressed(float rate, const std::vector<float>& edgeRates, bool compressed, const char* says, unsigned timeSteps = 1)
{
  Random random(43);
  Displacement displacement;
  std::vector<RTCRayHit> rays = raysAt(random, 1500);
  for (RTCRayHit& ray : rays) ray.ray.time = float(random.uniform());
  Device stock;
  for (const char* kind : {"grid", "voxel", "leaf"}) {
    SCOPED_TRACE(testing::Message() << kind << ", rate " << rate << ", " << edgeRates.size() << " edge rates");
    testing::internal::CaptureStdout();
    Device device(std::string("verbose=1,subdiv_accel=cbvh.") + kind);
    Scene a(stock), b(device);
    for (int i = 0; i < 2; i++) {
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = rate;
      settings.timeSteps = timeSteps;
      RTCDevice owner = i ? device : stock;
      settings.edgeRates = edgeRates;
      addSurface(owner, i ? b : a, cubeCage(), settings);
      rtcCommitScene(i ? b : a);
    }
    const std::string output = testing::internal::GetCapturedStdout();
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(b);
    EXPECT_EQ(stats.numQuads != 0, compressed);
    if (*says) { EXPECT_NE(output.find(says), std::string::npos) << output; }
    unsigned hits = 0;
    for (const RTCRayHit& ray : rays) {
      const RTCRayHit x = intersect(a, ray), y = intersect(b, ray);
      ASSERT_EQ(isHit(x), isHit(y));
      ASSERT_EQ(occluded(b, ray), occluded(a, ray));
      if (!isHit(x)) continue;
      hits++;
      ASSERT_EQ(x.ray.tfar, y.ray.tfar);
      ASSERT_EQ(x.hit.primID, y.hit.primID);
      ASSERT_EQ(x.hit.u, y.hit.u);
      ASSERT_EQ(x.hit.v, y.hit.v);
    }
    EXPECT_GT(hits, rays.size()/4);
  }
}

TEST(UncompressedSurfaces, RatesAbove256EqualStock)
{
  std::vector<float> rates;
  for (unsigned i = 0; i < 24; i++) rates.push_back(i % 4 == 1 ? 257 : float(1 + (i*7)%12));
  compareUncompressed(4, rates, false, "traced by GRID");
}

TEST(UncompressedSurfaces, MotionBlurEqualsStock)
{
  compareUncompressed(8, {}, false, "motion blur: traced by GRID", 2);
}

// Compressed faces beside others, in one BVH.
TEST(UncompressedSurfaces, FacesOfTooHighRatesLiveBesideCompressedOnes)
{
  Device device;
  Displacement displacement;
  Random random(44);
  std::vector<float> rates(24, 16.0f);
  for (int i = 0; i < 4; i++) rates[i] = 300; // face 0; its neighbours' edges keep their own
  Scene scene(device), grid(device);
  for (int i = 0; i < 2; i++) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = i ? RTC_COMPRESSION_GRID : RTC_COMPRESSION_NONE;
    settings.frameLevel = 1;
    settings.edgeRates = rates;
    addSurface(device, i ? scene : grid, cubeCage(), settings);
    rtcCommitScene(i ? scene : grid);
  }
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_GT(stats.numQuads, 0u);
  EXPECT_GT(stats.numGridQuads, 0u);
  EXPECT_GT(stats.gridBytes, 0u);
  expectEqualToGrid(grid, scene, raysAt(random, 3000), cubeCage());
}

} // namespace
} // namespace cbvh
