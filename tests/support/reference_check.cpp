// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/reference_check.h"
#include "kernels/cbvh/build/frame_map.h"
#include "kernels/cbvh/trace/scalar_intersector.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <cstdio>

namespace cbvh::test {
namespace {

using embree::cbvh::Block;
using embree::cbvh::Double3;
using embree::cbvh::FrameMap;
using embree::cbvh::frameMap;
using ReferenceIntersector = embree::cbvh::ScalarIntersector<double>;
using ReferenceHit = ReferenceIntersector::Hit;
using ReferenceRay = ReferenceIntersector::Ray;
constexpr double ulp = std::numeric_limits<float>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

double determinant(const double m[3][3]) {
  return m[0][0]*(m[1][1]*m[2][2] - m[1][2]*m[2][1]) - m[0][1]*(m[1][0]*m[2][2] - m[1][2]*m[2][0]) + m[0][2]*(m[1][0]*m[2][1] - m[1][1]*m[2][0]);
}

// World vector that the linear part of the frame takes to a multiple of one axis.
void axisInWorld(const Block* block, int axis, double size, double out[3])
{
  double m[3][3]; // row k: the gradient of x_k at the centre of the box
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) m[k][i] = double(block->columns[i][k]) - 0.5*double(block->columns[i][3]);
  const double det = determinant(m);
  for (int i = 0; i < 3; i++) { // Cramer
    double n[3][3];
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++) n[k][j] = j == i ? (k == axis ? size : 0) : m[k][j];
    out[i] = determinant(n)/det;
  }
}

// W at the corners of the box, where it is smallest. SIMD takes that where the ray is.
double smallestW(const Block* block)
{
  const FrameMap map = frameMap(block);
  double smallest = infinity;
  for (int i = 0; i < 8; i++) {
    Double3 corner;
    if (unproject(map, i & 1, (i >> 1) & 1, i >> 2, corner)) smallest = std::min(smallest, map.W(corner));
  }
  return smallest;
}

// A ray, and how far SIMD may be from it.
struct UncertainRay
{
  const Block* block;
  ReferenceRay ray;
  double epsilon[3];    // of local_ray.h
  double shift[3][3];   // each axis' epsilon, in the world
  double rounding;      // of t
  double middle, half;  // parameter nearest to the block's centre, and of half its size

  UncertainRay(const Block* block, const RTCRay& r) : block(block)
  {
    ray.org[0] = r.org_x; ray.org[1] = r.org_y; ray.org[2] = r.org_z;
    ray.dir[0] = r.dir_x; ray.dir[1] = r.dir_y; ray.dir[2] = r.dir_z;
    ray.tnear = r.tnear; ray.tfar = r.tfar;
    const double W = smallestW(block);
    double reach = 0, dir2 = 0, od = 0, size = 0;
    for (int i = 0; i < 3; i++) {
      const double o = ray.org[i] - double(block->centre[i]);
      reach = std::max(reach, std::fabs(o));
      od += o*ray.dir[i];
      dir2 += ray.dir[i]*ray.dir[i];
    }
    for (int k = 0; k < 3; k++) {
      double axis[3];
      epsilon[k] = embree::cbvh::rayEpsilon(*block, reach, k)/W;
      axisInWorld(block, k, epsilon[k], shift[k]);
      axisInWorld(block, k, 1, axis);
      size += std::sqrt(axis[0]*axis[0] + axis[1]*axis[1] + axis[2]*axis[2]);
    }
    const double length = std::sqrt(dir2);
    middle = -od/dir2;
    half = std::max(size, 1e-30)/length;
    // t0, t1 and their sums round like the distance to the block, s like 1
    rounding = 16*ulp*(reach + size)/length;
  }

  ReferenceHit exactHit() const { return ReferenceIntersector(block, 0).intersect(ray); }

  // Extends the bounds by what the reference finds when the ends of the ray in the block
  // move by these parts of each axis' epsilon.
  void extend(const double move[2][3], double& nearest, double& farthest) const
  {
    ReferenceRay moved = ray;
    for (int i = 0; i < 3; i++) {
      double mean = 0, turn = 0;
      for (int k = 0; k < 3; k++) {
        mean += 0.5*(move[0][k] + move[1][k])*shift[k][i];
        turn += 0.5*(move[1][k] - move[0][k])*shift[k][i]/half;
      }
      moved.org[i] += mean - turn*middle;
      moved.dir[i] += turn;
    }
    for (int widening = 0; widening <= 2; widening++) {
      const ReferenceHit hit = ReferenceIntersector(block, widening).intersect(moved);
      nearest = std::min(nearest, hit.t);
      if (hit.found || widening == 0) farthest = std::max(farthest, hit.t);
    }
  }

  // Whether one of the rays that SIMD may have taken it for has a hit at t or before, and one
  // at t or behind.
  bool allows(double t, double& nearest, double& farthest) const
  {
    nearest = infinity;
    farthest = -infinity;
    const double unmoved[2][3] = {};
    extend(unmoved, nearest, farthest);
    auto inside = [&] { return t >= nearest - rounding && t <= farthest + rounding; };
    // both ends alike, apart, or one of them alone: towards each corner of the box of errors
    static const double ends[4][2] = {{1, 1}, {1, -1}, {1, 0}, {0, 1}};
    for (int m = 0; m < 32; m++) {
      double move[2][3];
      for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) move[end][k] = ((m >> k) & 1 ? 1 : -1)*ends[m >> 3][end];
      extend(move, nearest, farthest);
    }
    // a ray along a surface may be any side of each of its leaves, whose own heights round as
    // much as the ray does
    Random random(35);
    for (int i = 0; i < 1000 && !inside(); i++) {
      double move[2][3];
      for (auto& end : move)
        for (double& m : end) m = random.uniform(-2, 2);
      extend(move, nearest, farthest);
    }
    return inside();
  }
};

// Whether a ray lies in the plane of a triangle: its test divides by this cosine.
bool grazes(const RTCRay& r, const double n[3])
{
  const double d[3] = {r.dir_x, r.dir_y, r.dir_z};
  return std::fabs(d[0]*n[0] + d[1]*n[1] + d[2]*n[2]) <= 1e-3*std::sqrt((d[0]*d[0] + d[1]*d[1] + d[2]*d[2])*(n[0]*n[0] + n[1]*n[1] + n[2]*n[2]));
}

bool sameHit(const RTCRayHit& a, const RTCRayHit& b)
{
  return isHit(a) == isHit(b) && (!isHit(a) || (std::fabs(double(a.ray.tfar) - b.ray.tfar) <= 4*ulp*std::fabs(double(b.ray.tfar)) &&
    std::fabs(a.hit.u - b.hit.u) <= 4*ulp && std::fabs(a.hit.v - b.hit.v) <= 4*ulp));
}

// Whether a hit is too near a triangle's edge to tell which one it is on.
bool nearEdge(double u, double v)
{
  const double x = u - std::floor(u), y = v - std::floor(v);
  return std::min({x, y, 1-x, 1-y, std::fabs(1-x-y)}) < 1e-3;
}

// Whether a parameter, in quads, is that of an edge between quads.
bool onLine(double x, double epsilon) { return std::fabs(x - std::round(x)) < 1e-5 + 2*epsilon; }

} // namespace

void ReferenceCheck::trace(Random& random, const Sheet& sheet, const std::vector<RayKind>& kinds, unsigned raysOfAKind, bool unitLength)
{
  Scene scene(device), grid(device);
  commitSheet(device, scene, sheet, compression);
  commitSheet(device, grid, sheet, RTC_COMPRESSION_NONE);
  const std::vector<const Block*> blocks = sceneBlocks(scene);
  sheetsOfGrid += blocks.empty();
  for (RayKind kind : kinds)
    for (unsigned i = 0; i < raysOfAKind; i++) {
      const RTCRayHit ray = randomRay(random, kind, sheet, unitLength ? 1 : random.magnitude(1e-15, 1e18));
      if (!blocks.empty()) compare(ray, kind, sheet, blocks[0], scene, grid);
      else if (!sameHit(intersect(scene, ray), intersect(grid, ray)) || occluded(scene, ray) != occluded(grid, ray)) {
        failures++;
        ADD_FAILURE() << "left to GRID, but not its hit: " << nameOf(sheet.shape) << ", ray " << nameOf(kind);
      }
    }
}

void ReferenceCheck::compare(const RTCRayHit& ray, RayKind kind, const Sheet& sheet, const Block* block, RTCScene scene, RTCScene grid)
{
  const RTCRayHit found = intersect(scene, ray);
  const double t = isHit(found) ? double(found.ray.tfar) : infinity;
  const UncertainRay uncertain(block, ray.ray);
  const ReferenceHit exact = uncertain.exactHit();
  const double rounding = uncertain.rounding;
  rays++;
  hits += isHit(found);
  auto fail = [&](const testing::Message& what) {
    if (failures++ < 12)
      ADD_FAILURE() << what << ": " << sheet.quads << " quads, " << nameOf(sheet.shape) << ", scale " << sheet.scale << " at " << block->centre[0]
        << ", ray " << nameOf(kind) << ", t " << t << ", reference " << exact.t << ", rounding " << rounding;
  };
  if (occluded(scene, ray) != isHit(found)) fail(testing::Message() << "any hit differs");

  const bool isExact = isHit(found) ? std::fabs(t - exact.t) <= rounding : !exact.found;
  exactRays += isExact;
  const double u = found.hit.u, v = found.hit.v, n[3] = {found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z};
  if (compression == RTC_COMPRESSION_GRID && !isExact) {
    // Embree's triangle test is less exact than a block's bounds are, at edges and for rays in the
    // plane of a triangle. cGRID has to find what GRID does; there the compiler may fuse one of two
    // copies of the same test another way.
    if (sameHit(found, intersect(grid, ray))) { hitsOfGrid++; return; }
    if ((isHit(found) && (grazes(ray.ray, n) || nearEdge(u*sheet.quads, v*sheet.quads))) || (exact.found && grazes(ray.ray, exact.Ng))) { strayed++; return; }
  }
  if (!isExact) {
    double nearest, farthest;
    if (!uncertain.allows(t, nearest, farthest)) fail(testing::Message() << "not in [" << nearest << ", " << farthest << "]");
  }
  if (!isHit(found)) return;
  if (!(found.ray.tfar >= ray.ray.tnear && found.ray.tfar <= ray.ray.tfar)) fail(testing::Message() << "outside tnear, tfar");
  // GRID's own parameters leave [0,1] by its rounding, and its triangles may have no area
  const double outside = compression == RTC_COMPRESSION_GRID ? 1e-4 : 0, n2 = n[0]*n[0] + n[1]*n[1] + n[2]*n[2];
  if (!(std::min(u, v) >= -outside && std::max(u, v) <= 1 + outside && n2 < infinity && (n2 > 0 || outside)))
    fail(testing::Message() << "parameters " << u << ", " << v << ", normal " << n[0] << " " << n[1] << " " << n[2]);

  // The same point of the same leaf has the same parameters and normal. Leaves overlap, and
  // a ray may enter two at once.
  const double quads = sheet.quads, epsilon = std::max(uncertain.epsilon[0], uncertain.epsilon[1]);
  if (!isExact || !(epsilon < 1e-4)) return;
  if (std::floor(exact.u*quads) != std::floor(u*quads) || std::floor(exact.v*quads) != std::floor(v*quads)) return;
  if (compression == RTC_COMPRESSION_GRID && (nearEdge(exact.u*quads, exact.v*quads) || nearEdge(u*quads, v*quads))) return;
  // a ray may hit leaves that share an edge there, whose normals differ
  if (compression == RTC_COMPRESSION_LEAF && (onLine(u*quads, epsilon) || onLine(v*quads, epsilon))) return;
  parameters++;
  const double cosine = (exact.Ng[0]*n[0] + exact.Ng[1]*n[1] + exact.Ng[2]*n[2])/
    std::sqrt((exact.Ng[0]*exact.Ng[0] + exact.Ng[1]*exact.Ng[1] + exact.Ng[2]*exact.Ng[2])*n2);
  // the error of the position over the extent of a leaf, which may be a few times less than 1/quads
  const double tolerance = 0.01/quads + 8*epsilon;
  if (!(std::fabs(exact.u - u) < tolerance && std::fabs(exact.v - v) < tolerance && (cosine > 0.999 || uncertain.epsilon[2] > 1e-4)) &&
      !(compression == RTC_COMPRESSION_GRID && sameHit(found, intersect(grid, ray))))
    fail(testing::Message() << "u " << u << ", v " << v << ", expected " << exact.u << ", " << exact.v << ", cosine " << cosine);
}

void ReferenceCheck::conclude(double exact)
{
  std::printf("%u rays, %u hits, %u exact, %u GRID's, %u strayed, %u parameters and normals\n", rays, hits, exactRays, hitsOfGrid, strayed, parameters);
  EXPECT_EQ(failures, 0u) << "of " << rays;
  EXPECT_GT(hits, rays/3) << "the rays miss the blocks";
  EXPECT_GE(exactRays + hitsOfGrid, exact*rays) << "the reference is too vague to test anything";
  EXPECT_LE(strayed, rays/20);
}

} // namespace cbvh::test
