// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/grid_agreement.h"
#include "kernels/cbvh/paper/frame_map.h"
#include "kernels/cbvh/paper/local_ray.h"
#include "support/leaf_of_hit.h"
#include "support/scene_blocks.h"

#include <algorithm>

namespace programs::test {
namespace {

using namespace embree::cbvh;

constexpr float ulp = std::numeric_limits<float>::epsilon();

Vec hitPoint(const RTCRayHit& r) {
  return {r.ray.org_x + r.ray.tfar * r.ray.dir_x, r.ray.org_y + r.ray.tfar * r.ray.dir_y,
          r.ray.org_z + r.ray.tfar * r.ray.dir_z};
}

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void unitNormal(const RTCRayHit& r, double n[3]) {
  const double x = r.hit.Ng_x, y = r.hit.Ng_y, z = r.hit.Ng_z, l = std::sqrt(x * x + y * y + z * z);
  n[0] = x / l;
  n[1] = y / l;
  n[2] = z / l;
}

std::pair<float, float> edgeLengths(const Cage& cage) {
  std::pair<float, float> range(INFINITY, 0);
  size_t first = 0;
  for (unsigned n : cage.faces) {
    for (unsigned i = 0; i < n; i++) {
      const Vec &a = cage.positions[cage.indices[first + i]], &b = cage.positions[cage.indices[first + (i + 1) % n]];
      const float length = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
      range = {std::min(range.first, length), std::max(range.second, length)};
    }
    first += n;
  }
  return range;
}

// Probes start next to the point, because it may lie in the plane of the surface, outside of its border.
bool isNearGrid(RTCScene grid, const Vec& p, float distance) {
  Random random(1);
  for (int i = 0; i < 1000; i++) {
    Vec o = p, d;
    double q[3], r[3], q2 = 0, r2 = 0;
    for (int k = 0; k < 3; k++) {
      q[k] = random.normal();
      q2 += q[k] * q[k];
      r[k] = random.normal();
      r2 += r[k] * r[k];
    }
    const double beside = random.uniform(0, 0.5);
    for (int k = 0; k < 3; k++) {
      o[k] += float(beside * distance * q[k] / std::sqrt(q2));
      d[k] = float(r[k] / std::sqrt(r2));
    }
    if (occluded(grid, makeRay(o, d, 0, float(1 - beside) * distance))) return true;
  }
  return false;
}

// Position relative to the leaf with the hit's parameters. On borders there are several such leaves.
struct LeafOfHit {
  bool exists = false;
  double outside = INFINITY; // distance to the nearest leaf's box, in units of the error by which rays are widened
  double reach = 0;          // distance to the farthest corner of the boxes that contain the hit
};

// In the frame W is 1 over a linear form, so its minimum over the block's box is at a corner.
double leastW(const FrameMap& map) {
  double least = INFINITY;
  for (int c = 0; c < 8; c++) {
    Double3 p = {};
    EXPECT_TRUE(unproject(map, c & 1, (c >> 1) & 1, c >> 2, p));
    least = std::min(least, map.W(p));
  }
  return least;
}

// The traversal widens boxes by the error of its ray, divided by the smaller W of both ends of the ray in the block
// (local_ray.h). The rounding of the hit's t is at most as large.
constexpr double hitError = 2;

LeafOfHit leafOfHit(const std::vector<const Block*>& blocks, const RTCRayHit& r) {
  const double t = r.ray.tfar;
  const float org[3] = {r.ray.org_x, r.ray.org_y, r.ray.org_z}, dir[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
  double point[3];
  for (int k = 0; k < 3; k++) point[k] = double(org[k]) + t * double(dir[k]);
  LeafOfHit found;
  for (const LeafOfBlock& at : leavesOfHit(blocks, r.hit)) {
    found.exists = true;
    const FrameMap map = frameMap(at.block);
    const Double3 p = {point[0] - at.block->center[0], point[1] - at.block->center[1], point[2] - at.block->center[2]};
    const double W = map.W(p), local[3] = {map.X(p) / W, map.Y(p) / W, map.Z(p) / W}, least = leastW(map);
    double distance = 0, error[3];
    for (int k = 0; k < 3; k++) distance = std::max(distance, std::fabs(double(org[k]) - double(at.block->center[k])));
    for (int k = 0; k < 3; k++) error[k] = rayEpsilon(*at.block, distance, k);
    const NodeBox box = decodeLeafOfBlock(at).box;
    double outside = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double beyond = std::max(box.lower[axis] - local[axis], local[axis] - upperOf(box, axis));
      outside = std::max(outside, beyond * least / error[axis]);
    }
    found.outside = std::min(found.outside, outside);
    if (outside > hitError) continue;
    for (int c = 0; c < 8; c++) {
      Double3 q = {};
      EXPECT_TRUE(unproject(map, c & 1 ? upperOf(box, 0) : box.lower[0], c & 2 ? upperOf(box, 1) : box.lower[1],
                            c & 4 ? upperOf(box, 2) : box.lower[2], q));
      found.reach = std::max(found.reach, length(q - p));
    }
  }
  return found;
}

void expectNearGrid(RTCScene grid, const std::vector<const Block*>& blocks, const RTCRayHit& hit, float slack) {
  ASSERT_EQ(hit.hit.geomID, 0u);
  ASSERT_GE(hit.hit.u, 0);
  ASSERT_GE(hit.hit.v, 0);
  const double n2 =
      double(hit.hit.Ng_x) * hit.hit.Ng_x + double(hit.hit.Ng_y) * hit.hit.Ng_y + double(hit.hit.Ng_z) * hit.hit.Ng_z;
  ASSERT_GT(n2, 0);
  if (blocks.empty()) { // blocks of cVERT have no leaf boxes
    ASSERT_TRUE(isNearGrid(grid, hitPoint(hit), slack)) << "nothing within " << slack << " of a hit";
    return;
  }
  const LeafOfHit leaf = leafOfHit(blocks, hit);
  ASSERT_TRUE(leaf.exists) << "no leaf has these parameters: face " << hit.hit.primID << ", " << hit.hit.u << ", "
                           << hit.hit.v;
  ASSERT_LE(leaf.outside, hitError) << "a hit outside of its leaf's box: face " << hit.hit.primID << ", " << hit.hit.u
                                    << ", " << hit.hit.v;
  const float reach = slack + float(leaf.reach);
  ASSERT_TRUE(isNearGrid(grid, hitPoint(hit), reach)) << "nothing within " << reach << " of a hit";
}

// Largest distance of cVERT's surface from GRID's: rounded vertices, closed borders, and float errors.
float vertSlack(RTCScene scene) {
  const RTCCompressionStatistics stats = statisticsOf(scene);
  if (stats.maxVertexSpacing == 0) return 0;
  RTCBounds bounds;
  rtcGetSceneBounds(scene, &bounds);
  const float size = std::max({std::fabs(bounds.lower_x), std::fabs(bounds.lower_y), std::fabs(bounds.lower_z),
                               std::fabs(bounds.upper_x), std::fabs(bounds.upper_y), std::fabs(bounds.upper_z)});
  return stats.maxVertexDeviation + stats.maxBorderMismatch + 64 * ulp * size;
}

} // namespace

void expectEqualToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage) {
  const double face = 0.5 * edgeLengths(cage).first;
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
    const double cosine = std::fabs(dot(d, m)) / length;
    // GRID's u and v are multiples of 8/65536, exact for levels up to 8. Vertices of faces that GRID splits may round
    // differently, and the compiler may fuse operations in only one copy of the same test. This shifts a hit by ulps of
    // t divided by the cosine, and u and v by this distance divided by the length of a face.
    ASSERT_LE(std::fabs(b.ray.tfar - a.ray.tfar), 4 * ulp * (a.ray.tfar + 1 / (cosine * length)))
        << "face " << a.hit.primID << " at " << a.hit.u << ", " << a.hit.v << " is face " << b.hit.primID << " at "
        << b.hit.u << ", " << b.hit.v << ", cosine " << cosine << ", t " << a.ray.tfar;
    if (b.hit.primID != a.hit.primID) continue; // on the border of two faces the ray may hit either first
    ASSERT_GT(dot(m, n), 1 - 1e-5);
    const double tolerance = 4 * ulp * (1 + 1 / (cosine * face));
    ASSERT_LE(std::fabs(b.hit.u - a.hit.u), tolerance);
    ASSERT_LE(std::fabs(b.hit.v - a.hit.v), tolerance);
  }
  EXPECT_GT(hits, rays.size() / 10);
}

void expectCloseToGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, const Cage& cage,
                       const SurfaceSettings& settings) {
  const Displacement& displacement = *settings.displacement;
  const float thickness = statisticsOf(scene).maxLeafThickness + vertSlack(scene), rate = settings.rate;
  // Catmull-Clark subdivision shrinks faces of high valence to about half their width.
  const float quad = edgeLengths(cage).second / rate, narrow = 0.5f * edgeLengths(cage).first / rate;
  const std::vector<const Block*> blocks = sceneBlocks(scene);
  // A quad's triangles deviate from its bilinear patch by a quarter of its twist, which is at most twice the amplitude
  // times the squared frequency.
  const float twist =
      0.25f * 2 * displacement.amplitude * displacement.frequency * displacement.frequency * quad * quad;
  unsigned hits = 0, misses = 0, falseHits = 0, compared = 0, across = 0, otherWay = 0, parameters = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), isHit(b));
    hits += isHit(a);
    if (isHit(a) && !isHit(b)) {
      ASSERT_NE(settings.compression, RTC_COMPRESSION_CVOXEL) << "a box contains the surface: no misses";
      // at a border or a silhouette, within the movement of vertices
      if (settings.compression == RTC_COMPRESSION_CVERT) {
        ASSERT_TRUE(isNearGrid(scene, hitPoint(a), vertSlack(scene))) << "a miss far from the surface";
        continue;
      }
      double m[3];
      unitNormal(a, m);
      const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
      EXPECT_LT(std::fabs(dot(d, m)) / std::sqrt(dot(d, d)), 0.5) << "a ray that does not graze is missed";
      misses++;
    }
    falseHits += isHit(b) && !isHit(a);
    if (isHit(b)) {
      expectNearGrid(grid, blocks, b, vertSlack(scene));
      if (testing::Test::HasFatalFailure()) return;
    }
    if (!isHit(a) || !isHit(b)) continue;
    double m[3], n[3];
    unitNormal(a, m);
    unitNormal(b, n);
    const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
    const double cosine = std::fabs(dot(d, m)) / std::sqrt(dot(d, d));
    if (cosine < 0.5 || a.hit.primID != b.hit.primID) continue;
    compared++;
    across += std::fabs(double(b.ray.tfar) - a.ray.tfar) * std::fabs(dot(d, m)) <= thickness + twist;
    otherWay += dot(m, n) <= 0;
    parameters += std::hypot(b.hit.u - a.hit.u, b.hit.v - a.hit.v) * rate <= 1.5f + 2 * thickness / narrow;
  }
  EXPECT_GT(hits, rays.size() / 10);
  EXPECT_GT(compared, hits / 3);
  // The other hits: a leaf's box extends beyond its quad, and rays may hit the extrapolated surface there first.
  EXPECT_GE(across, compared - compared / 10) << "of " << compared << " hits lie within the thickness";
  EXPECT_LE(otherWay, compared / 100) << "of " << compared << " normals point the other way";
  EXPECT_GE(parameters, compared - compared / 10) << "of " << compared << " parameters agree";
  EXPECT_LE(misses, hits / 200 + 1);
  // The sheet is 2 wide, so a border as wide as thickness and overlap of boxes covers four times half its width. Folds
  // add as much again.
  EXPECT_LE(falseHits, hits * std::min(1.0f, 8 * (thickness + 0.25f * quad) / 2) + 2);
}

void expectHitsNearGrid(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, float slack) {
  const std::vector<const Block*> blocks = sceneBlocks(scene);
  unsigned hits = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit hit = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), isHit(hit));
    if (!isHit(hit)) continue;
    hits++;
    expectNearGrid(grid, blocks, hit, slack + vertSlack(scene));
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(hits, rays.size() / 10);
}

void expectNoLeaks(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& raysFromInside,
                   RTCCompression compression) {
  unsigned leaks = 0, gridLeaks = 0;
  for (const RTCRayHit& ray : raysFromInside) {
    const bool hit = isHit(intersect(scene, ray));
    ASSERT_EQ(occluded(scene, ray), hit) << "any hit differs from closest hit";
    leaks += !hit;
    gridLeaks += compression == RTC_COMPRESSION_CGRID && !isHit(intersect(grid, ray));
  }
  EXPECT_LE(leaks, gridLeaks) << "of " << raysFromInside.size();
}

} // namespace programs::test
