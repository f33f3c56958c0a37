// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/reference_check.h"
#include "kernels/cbvh/paper/frame_map.h"
#include "support/scalar_intersector.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <cstdio>
#include <map>

namespace programs::test {
namespace {

using embree::cbvh::Block;
using cvert::Double3;
using embree::cbvh::FrameMap;
using embree::cbvh::frameMap;
using ReferenceIntersector = embree::cbvh::ScalarIntersector<double>;
using ReferenceHit = ReferenceIntersector::Hit;
using ReferenceRay = ReferenceIntersector::Ray;
constexpr double ulp = std::numeric_limits<float>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double determinant(const double m[3][3]) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// World vector that the linear part of the frame maps to a multiple of one axis.
void axisInWorld(const Block* block, int axis, double size, double out[3]) {
  double m[3][3]; // row k: the gradient of x_k at the center of the box
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) m[k][i] = double(block->columns[i][k]) - 0.5 * double(block->columns[i][3]);
  const double det = determinant(m);
  for (int i = 0; i < 3; i++) { // Cramer
    double n[3][3];
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++) n[k][j] = j == i ? (k == axis ? size : 0) : m[k][j];
    out[i] = determinant(n) / det;
  }
}

// W is smallest at a corner of the box. SIMD uses W at the position of the ray.
double smallestW(const Block* block) {
  const FrameMap map = frameMap(block);
  double smallest = infinity;
  for (int i = 0; i < 8; i++) {
    Double3 corner;
    if (unproject(map, i & 1, (i >> 1) & 1, i >> 2, corner)) smallest = std::min(smallest, map.W(corner));
  }
  return smallest;
}

// The reference's hits, for all rays within the error of SIMD.
struct Answers {
  struct OfLeaf {
    double lower[3] = {infinity, infinity, infinity}, upper[3] = {-infinity, -infinity, -infinity}; // ranges of t, u, v
    std::vector<ReferenceHit> hits;
  };
  std::map<uint32_t, OfLeaf> leaves;
  bool misses = false;

  void add(const ReferenceHit& hit) {
    OfLeaf& leaf = leaves[hit.leaf];
    const double value[3] = {hit.t, hit.u, hit.v};
    for (int k = 0; k < 3; k++) {
      leaf.lower[k] = std::min(leaf.lower[k], value[k]);
      leaf.upper[k] = std::max(leaf.upper[k], value[k]);
    }
    leaf.hits.push_back(hit);
  }
};

struct UncertainRay {
  const Block* block;
  ReferenceRay ray;
  double epsilon[3];   // see local_ray.h
  double shift[3][3];  // epsilon of each axis, as a world vector
  double rounding;     // rounding of t
  double middle, half; // ray parameter nearest to the center of the block, and its distance to the moved ends

  UncertainRay(const Block* block, const RTCRay& r) : block(block) {
    ray.org[0] = r.org_x;
    ray.org[1] = r.org_y;
    ray.org[2] = r.org_z;
    ray.dir[0] = r.dir_x;
    ray.dir[1] = r.dir_y;
    ray.dir[2] = r.dir_z;
    ray.tnear = r.tnear;
    ray.tfar = r.tfar;
    const double W = smallestW(block);
    double reach = 0, dir2 = 0, od = 0, size = 0;
    for (int i = 0; i < 3; i++) {
      const double o = ray.org[i] - double(block->center[i]);
      reach = std::max(reach, std::fabs(o));
      od += o * ray.dir[i];
      dir2 += ray.dir[i] * ray.dir[i];
    }
    for (int k = 0; k < 3; k++) {
      double axis[3];
      epsilon[k] = embree::cbvh::rayEpsilon(*block, reach, k) / W;
      axisInWorld(block, k, epsilon[k], shift[k]);
      axisInWorld(block, k, 1, axis);
      size += std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    }
    const double length = std::sqrt(dir2);
    middle = -od / dir2;
    half = std::max(size, 1e-30) / length;
    // t0, t1 and their sums round like the distance to the block, s rounds like 1
    rounding = 16 * ulp * (reach + size) / length;
  }

  ReferenceHit exactHit() const { return ReferenceIntersector(block, 0).intersect(ray); }

  // Adds the reference's hits for a ray whose ends in the block move by the given multiples of each axis' epsilon.
  void add(const double move[2][3], Answers& answers) const {
    ReferenceRay moved = ray;
    for (int i = 0; i < 3; i++) {
      double mean = 0, turn = 0;
      for (int k = 0; k < 3; k++) {
        mean += 0.5 * (move[0][k] + move[1][k]) * shift[k][i];
        turn += 0.5 * (move[1][k] - move[0][k]) * shift[k][i] / half;
      }
      moved.org[i] += mean - turn * middle;
      moved.dir[i] += turn;
    }
    for (int widening = 0; widening <= 2; widening++) {
      std::vector<ReferenceHit> met;
      const ReferenceHit nearest = ReferenceIntersector(block, widening).intersect(moved, &met);
      if (!nearest.found) answers.misses |= widening == 0; // with wider bounds, a miss is also a miss
      for (const ReferenceHit& hit : met)                  // leaves overlap, and a ray may enter several at once
        if (hit.t <= nearest.t + rounding) answers.add(hit);
    }
  }

  // Collects results for rays within the error of SIMD until one of them explains SIMD's hit.
  template<typename Explains>
  bool explain(Answers& answers, const Explains& explains) const {
    const double unmoved[2][3] = {};
    add(unmoved, answers);
    // both ends the same, opposite, or only one of them: towards each corner of the box of errors
    static const double ends[4][2] = {{1, 1}, {1, -1}, {1, 0}, {0, 1}};
    for (int m = 0; m < 32; m++) {
      double move[2][3];
      for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) move[end][k] = ((m >> k) & 1 ? 1 : -1) * ends[m >> 3][end];
      add(move, answers);
    }
    // A ray along a surface may be on any side of each leaf, whose heights round as much as the ray does.
    Random random(35);
    for (int i = 0; i < 1000; i++) {
      if (explains(answers)) return true;
      double move[2][3];
      for (auto& end : move)
        for (double& m : end) m = random.uniform(-2, 2);
      add(move, answers);
    }
    return explains(answers);
  }
};

// Distance of a point from a triangle, which may be degenerate.
double distanceTo(const VertTriangle& triangle, const double point[3]) {
  double e[3][3], q[3][3], n[3], least = infinity;
  for (int i = 0; i < 3; i++) {
    for (int k = 0; k < 3; k++) {
      e[i][k] = double(triangle.vertices[(i + 1) % 3][k]) - triangle.vertices[i][k];
      q[i][k] = point[k] - triangle.vertices[i][k];
    }
    const double along = std::min(1.0, std::max(0.0, dot(q[i], e[i]) / std::max(dot(e[i], e[i]), 1e-300)));
    double off[3];
    for (int k = 0; k < 3; k++) off[k] = q[i][k] - along * e[i][k];
    least = std::min(least, std::sqrt(dot(off, off)));
  }
  const auto cross = [](const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  };
  cross(e[0], e[1], n);
  bool above = dot(n, n) > 0;
  for (int i = 0; i < 3; i++) {
    double side[3];
    cross(e[i], q[i], side);
    above &= dot(side, n) >= 0;
  }
  return above ? std::fabs(dot(q[0], n)) / std::sqrt(dot(n, n)) : least;
}

// Nearly parallel to the plane: the triangle test divides by the cosine.
bool grazes(const RTCRay& r, const double n[3]) {
  const double d[3] = {r.dir_x, r.dir_y, r.dir_z};
  return std::fabs(d[0] * n[0] + d[1] * n[1] + d[2] * n[2]) <=
         1e-3 * std::sqrt((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
}

bool sameHit(const RTCRayHit& a, const RTCRayHit& b) {
  return isHit(a) == isHit(b) &&
         (!isHit(a) || (std::fabs(double(a.ray.tfar) - b.ray.tfar) <= 4 * ulp * std::fabs(double(b.ray.tfar)) &&
                        std::fabs(a.hit.u - b.hit.u) <= 4 * ulp && std::fabs(a.hit.v - b.hit.v) <= 4 * ulp));
}

// Too close to an edge to be assigned to one triangle.
bool nearEdge(double u, double v) {
  const double x = u - std::floor(u), y = v - std::floor(v);
  return std::min({x, y, 1 - x, 1 - y, std::fabs(1 - x - y)}) < 1e-3;
}

} // namespace

void ReferenceCheck::trace(Random& random, const Sheet& sheet, const std::vector<RayKind>& kinds, unsigned raysPerKind,
                           bool unitLength) {
  Scene scene(device), grid(device);
  commitSheet(device, scene, sheet, compression);
  commitSheet(device, grid, sheet, RTC_COMPRESSION_NONE);
  const std::vector<const Block*> blocks = sceneBlocks(scene);
  const std::vector<VertTriangle> triangles = vertTriangles(scene);
  sheetsOfGrid += blocks.empty() && triangles.empty();
  std::vector<Answer> answers;
  std::vector<RTCRayHit> closest;
  std::vector<RTCRay> any;
  for (RayKind kind : kinds)
    for (unsigned i = 0; i < raysPerKind; i++) {
      const RTCRayHit ray = randomRay(random, kind, sheet, unitLength ? 1 : random.magnitude(1e-15, 1e18));
      answers.push_back({ray, ray, ray, false, false, kind});
      closest.push_back(ray);
      any.push_back(ray.ray);
    }
  std::vector<RTCRayHit> closestInGrid = closest;
  std::vector<RTCRay> anyInGrid = any;
  traceRays(scene, closest, any);
  traceRays(grid, closestInGrid, anyInGrid);
  for (size_t i = 0; i < answers.size(); i++) {
    Answer& answer = answers[i];
    answer.found = closest[i];
    answer.isOccluded = any[i].tfar < 0;
    answer.ofGrid = closestInGrid[i];
    answer.isOccludedInGrid = anyInGrid[i].tfar < 0;
    if (!triangles.empty()) compareTriangles(answer, sheet, triangles);
    else if (!blocks.empty()) compare(answer, sheet, blocks[0]);
    else if (!sameHit(answer.found, answer.ofGrid) || answer.isOccluded != answer.isOccludedInGrid) {
      failures++;
      ADD_FAILURE() << "left to GRID, but not its hit: " << nameOf(sheet.shape) << ", ray " << nameOf(answer.kind);
    }
  }
}

void ReferenceCheck::traceByEmbree(RTCScene scene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any) {
  for (RTCRayHit& ray : closest) ray = intersect(scene, ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (RTCRay& ray : any) rtcOccluded1(scene, &context, &ray);
}

void ReferenceCheck::compareTriangles(const Answer& answer, const Sheet& sheet,
                                      const std::vector<VertTriangle>& triangles) {
  const RTCRayHit &ray = answer.ray, &found = answer.found;
  const double t = isHit(found) ? double(found.ray.tfar) : infinity;
  const double d[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z}, length = std::sqrt(dot(d, d));
  const float org[3] = {ray.ray.org_x, ray.ray.org_y, ray.ray.org_z};
  rays++;
  hits += isHit(found);
  ExactHit nearest = {}, hit;
  nearest.t = infinity;
  bool same = false, near = false;
  for (const VertTriangle& triangle : triangles) {
    if (!meet(ray.ray, triangle, hit)) continue; // degenerate, below, or parallel to the ray
    // rounding of vertices minus origin, and its effect on the test
    double reach = 0, e[2][3], n[3];
    for (const auto& v : triangle.vertices)
      for (int k = 0; k < 3; k++) reach = std::max(reach, std::fabs(double(v[k]) - org[k]));
    for (int k = 0; k < 3; k++) {
      e[0][k] = double(triangle.vertices[1][k]) - triangle.vertices[0][k];
      e[1][k] = double(triangle.vertices[2][k]) - triangle.vertices[0][k];
    }
    for (int k = 0; k < 3; k++) n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
    const double area = std::sqrt(dot(n, n)), side = std::sqrt(std::max(dot(e[0], e[0]), dot(e[1], e[1])));
    if (area == 0) continue;
    const double cosine = std::fabs(dot(n, d)) / (area * length), error = 8 * ulp * reach;
    const double ofT = error / (std::max(cosine, 1e-12) * length),
                 ofWeights = 2 * side * error / (area * std::max(cosine, 1e-12));
    const bool inRange = hit.t >= ray.ray.tnear && hit.t <= ray.ray.tfar;
    if (inRange && inside(hit) >= 0 && hit.t < nearest.t) {
      nearest = hit;
      same = std::fabs(hit.t - t) <= ofT + 4 * ulp * std::fabs(hit.t);
    }
    near |= inside(hit) >= -ofWeights &&
            (!isHit(found) ? inside(hit) <= ofWeights || hit.t <= ray.ray.tnear + ofT || hit.t >= ray.ray.tfar - ofT
                           : std::fabs(hit.t - t) <= ofT + 4 * ulp * std::fabs(hit.t));
  }
  // rays that pass a degenerate triangle, or a triangle seen edge-on, within rounding errors also hit it
  for (size_t i = 0; i < triangles.size() && isHit(found) && !same && !near; i++) {
    double p[3], reach = 0;
    for (int k = 0; k < 3; k++) p[k] = org[k] + t * d[k];
    for (const auto& v : triangles[i].vertices)
      for (int k = 0; k < 3; k++) reach = std::max(reach, std::fabs(double(v[k]) - org[k]));
    near |= distanceTo(triangles[i], p) <= 16 * ulp * reach;
  }
  same |= nearest.triangle == nullptr && !isHit(found);
  sameT += same;
  if (answer.isOccluded != isHit(found) || (!same && !near)) {
    if (failures++ < 12)
      ADD_FAILURE() << "no triangle says so: " << sheet.quads << " quads, " << nameOf(sheet.shape) << ", scale "
                    << sheet.scale << ", ray " << nameOf(answer.kind) << ", t " << t << ", reference " << nearest.t
                    << ", weights " << nearest.weight[0] << " " << nearest.weight[1] << " " << nearest.weight[2];
  } else if (same) equal++;
  else if (isHit(found) != (nearest.triangle != nullptr)) atBorder++;
  else betweenLeaves++;
}

void ReferenceCheck::compare(const Answer& answer, const Sheet& sheet, const Block* block) {
  const RTCRayHit &ray = answer.ray, &found = answer.found;
  const double t = isHit(found) ? double(found.ray.tfar) : infinity;
  const UncertainRay uncertain(block, ray.ray);
  const ReferenceHit exact = uncertain.exactHit();
  const double rounding = uncertain.rounding;
  rays++;
  hits += isHit(found);
  auto fail = [&](const testing::Message& what) {
    if (failures++ < 12)
      ADD_FAILURE() << what << ": " << sheet.quads << " quads, " << nameOf(sheet.shape) << ", scale " << sheet.scale
                    << " at " << block->center[0] << ", ray " << nameOf(answer.kind) << ", t " << t << ", reference "
                    << exact.t << ", rounding " << rounding;
  };
  if (answer.isOccluded != isHit(found)) fail(testing::Message() << "any hit differs");

  const double u = found.hit.u, v = found.hit.v, n[3] = {found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z},
               n2 = dot(n, n);
  if (isHit(found)) {
    if (!(found.ray.tfar >= ray.ray.tnear && found.ray.tfar <= ray.ray.tfar))
      fail(testing::Message() << "outside tnear, tfar");
    // GRID's own parameters exceed [0,1] by rounding, and its triangles may have no area
    const double outside = compression == RTC_COMPRESSION_CGRID ? 1e-4 : 0;
    if (!(std::min(u, v) >= -outside && std::max(u, v) <= 1 + outside && n2 < infinity && (n2 > 0 || outside)))
      fail(testing::Message() << "parameters " << u << ", " << v << ", normal " << n[0] << " " << n[1] << " " << n[2]);
  }

  // the error of the position divided by the extent of a leaf, which may be a few times smaller than 1/quads
  const double quads = sheet.quads, tolerance = 0.01 / quads + 8 * std::max(uncertain.epsilon[0], uncertain.epsilon[1]);
  const bool roughNormals = uncertain.epsilon[2] > 1e-4; // heights of a leaf round as much as they differ
  auto sameNormal = [&](const ReferenceHit& hit) {
    return roughNormals || dot(hit.Ng, n) > 0.999 * std::sqrt(dot(hit.Ng, hit.Ng) * n2);
  };
  auto equals = [&](const ReferenceHit& hit) {
    if (hit.found != isHit(found)) return false;
    return !hit.found || (std::fabs(hit.t - t) <= rounding && std::fabs(hit.u - u) <= tolerance &&
                          std::fabs(hit.v - v) <= tolerance && sameNormal(hit));
  };
  sameT += isHit(found) ? std::fabs(t - exact.t) <= rounding : !exact.found;
  if (equals(exact)) {
    equal++;
    return;
  }

  if (compression == RTC_COMPRESSION_CGRID) {
    // Embree's triangle test is less exact than a block's bounds, at edges and for rays in the plane of a triangle.
    // cGRID must find GRID's hit; the compiler may fuse operations in only one of two copies of the same test.
    if (sameHit(found, answer.ofGrid)) {
      hitsOfGrid++;
      return;
    }
    if ((isHit(found) && (grazes(ray.ray, n) || nearEdge(u * quads, v * quads))) ||
        (exact.found && grazes(ray.ray, exact.Ng))) {
      strayed++;
      return;
    }
  }

  // a different result must be the result of a ray within the error of SIMD
  Answers answers;
  const bool explained = uncertain.explain(answers, [&](const Answers& a) {
    if (!isHit(found)) return a.misses;
    const double value[3] = {t, u, v}, slack[3] = {rounding, tolerance, tolerance};
    return std::any_of(a.leaves.begin(), a.leaves.end(), [&](const auto& leaf) {
      for (int k = 0; k < 3; k++)
        if (!(value[k] >= leaf.second.lower[k] - slack[k] && value[k] <= leaf.second.upper[k] + slack[k])) return false;
      return std::any_of(leaf.second.hits.begin(), leaf.second.hits.end(), sameNormal);
    });
  });
  if (!explained) {
    testing::Message m;
    m << (isHit(found) ? "no such hit" : "no miss") << " among " << answers.leaves.size() << " leaves"
      << (answers.misses ? " and misses" : "") << ", u " << u * quads << ", v " << v * quads << " quads, reference "
      << exact.u * quads << ", " << exact.v * quads;
    for (const auto& leaf : answers.leaves)
      m << "; leaf " << leaf.first << " t " << leaf.second.lower[0] << " to " << leaf.second.upper[0];
    fail(m);
  } else if (answers.misses && !answers.leaves.empty()) atBorder++;
  else if (answers.leaves.size() > 1) betweenLeaves++;
  else alongLeaf++;
}

void ReferenceCheck::conclude(double share) {
  std::printf(
      "%u rays, %u hits: %u equal, %u in t; %u hit or miss by rounding, %u hit one of several leaves by rounding, %u "
      "graze one leaf; %u GRID's, %u strayed\n",
      rays, hits, equal, sameT, atBorder, betweenLeaves, alongLeaf, hitsOfGrid, strayed);
  EXPECT_EQ(failures, 0u) << "of " << rays;
  EXPECT_GT(hits, rays / 3) << "too many rays miss the blocks";
  EXPECT_GE(sameT + hitsOfGrid, share * rays) << "the tolerance of the reference explains too many hits";
  EXPECT_LE(strayed, rays / 20);
}

} // namespace programs::test
