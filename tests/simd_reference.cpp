// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Every ISA finds the scalar reference's hits, on the very blocks that the library
 * built: closest and any hit, for random blocks and for the rays that are hard.
 *
 * The bound. The SIMD code knows a ray inside a block up to the vector "epsilon" of
 * local_ray.h, at both ends of its segment, and widens bounds by as much. So its hit
 * must be one that the reference finds for a ray whose ends in the block are moved by
 * no more than that:
 *   - it may not be nearer than the nearest hit of any such ray with bounds widened by
 *     0 to 2 epsilons (once by SIMD itself, once as the moved ray's own error),
 *   - it may not be farther than the farthest of them,
 *   - it may be missing only if one of them misses without widening.
 * What t itself rounds comes on top: the sum t0 + tau (t1-t0) of a few rounded terms
 * as large as the distance to the block. */

#include "kernels/cbvh/reference.h"
#include "scene_blocks.h"
#include "test_random.h"
#include "test_scene.h"

#include <algorithm>
#include <map>

namespace cbvh {
namespace {

using embree::cbvh::Block;
using embree::cbvh::Double3;
using embree::cbvh::ReferenceHit;
using embree::cbvh::ReferenceIntersector;
using embree::cbvh::ReferenceRay;
constexpr double ulp = std::numeric_limits<float>::epsilon();

// --- random sheets -------------------------------------------------------------------

enum Shape { WAVES, NOISE, SPIKES, FOLDED, FLAT, NEEDLE, TRAPEZOID, VERTICAL, SHAPES };
const char* const shapeNames[SHAPES] = {"waves", "noise", "spikes", "folded", "flat", "needle", "trapezoid", "vertical"};

struct Sheet
{
  unsigned quads;
  Cage cage;
  std::vector<Vec> vertices;

  // Overwrites what the tessellator made.
  static void place(const RTCDisplacementFunctionNArguments* args)
  {
    const Sheet& sheet = *(const Sheet*)args->geometryUserPtr;
    for (unsigned i = 0; i < args->N; i++) {
      const unsigned x = unsigned(std::lround(args->u[i]*sheet.quads)), y = unsigned(std::lround(args->v[i]*sheet.quads));
      const Vec& p = sheet.vertices[y*(sheet.quads+1) + x];
      args->P_x[i] = p[0]; args->P_y[i] = p[1]; args->P_z[i] = p[2];
    }
  }
};

Sheet makeSheet(Random& random, Shape shape, unsigned height, double scale, const double position[3])
{
  Sheet sheet;
  sheet.quads = 1u << height;
  double corners[4][3] = {{0,0,0}, {1,0,0}, {1,1,0}, {0,1,0}}; // in the order of the face
  for (auto& c : corners)
    for (int k = 0; k < 3; k++) c[k] += 0.1*random.normal();
  if (shape == NEEDLE) for (auto& c : corners) c[1] *= 1e-3;
  if (shape == FLAT) for (auto& c : corners) c[2] = 0;
  if (shape == TRAPEZOID) { corners[2][0] = 0.7; corners[3][0] = 0.3; }
  if (shape == FOLDED) std::swap(corners[2], corners[3]);
  const double phase = 6*random.uniform();
  auto toWorld = [&](const double p[3]) {
    return Vec{float(position[0] + scale*p[0]), float(position[1] + scale*p[1]), float(position[2] + scale*p[2])};
  };
  for (unsigned y = 0; y <= sheet.quads; y++)
    for (unsigned x = 0; x <= sheet.quads; x++) {
      const double u = double(x)/sheet.quads, v = double(y)/sheet.quads;
      double p[3];
      for (int k = 0; k < 3; k++)
        p[k] = (1-v)*((1-u)*corners[0][k] + u*corners[1][k]) + v*((1-u)*corners[3][k] + u*corners[2][k]);
      switch (shape) {
      case WAVES: case FOLDED: case TRAPEZOID: p[2] += 0.05*std::sin(7*u + 3*v + phase); break;
      case NOISE: for (double& c : p) c += 0.2/sheet.quads*random.normal(); break;
      case SPIKES: if (random.chance(0.1)) p[2] += 0.5*random.uniform(); break;
      case NEEDLE: p[2] += 1e-3*random.normal(); break;
      case VERTICAL: p[2] += 2*u; p[0] *= 0.01; break;
      default: break;
      }
      sheet.vertices.push_back(toWorld(p));
    }
  for (auto& c : corners) sheet.cage.positions.push_back(toWorld(c));
  sheet.cage.addFace({0, 1, 2, 3});
  sheet.cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  return sheet;
}

// --- rays --------------------------------------------------------------------------------

enum RayKind { ACROSS, AXIS, VERTEX, EDGE, INSIDE, ON_SURFACE, SHORT, IN_PLANE, RAY_KINDS };
const char* const rayNames[RAY_KINDS] = {"across", "axis", "through a vertex", "through an edge", "from inside the block", "from the surface", "short", "in the plane"};

RTCRayHit makeRandomRay(Random& random, RayKind kind, const Sheet& sheet, double scale)
{
  const unsigned n = sheet.quads, w = n + 1;
  auto vertex = [&](unsigned x, unsigned y, double p[3]) { for (int k = 0; k < 3; k++) p[k] = sheet.vertices[y*w + x][k]; };
  const unsigned x = random.below(n), y = random.below(n);
  double corner[3][3];
  vertex(x, y, corner[0]);
  vertex(x+1, y, corner[1]);
  vertex(x, y+1, corner[2]);
  double target[3], dir[3];
  const double a = random.uniform(), b = random.uniform()*(1-a);
  for (int k = 0; k < 3; k++) {
    dir[k] = random.normal();
    switch (kind) {
    case VERTEX: target[k] = corner[0][k]; break;
    case EDGE: target[k] = corner[0][k] + a*(corner[1][k] - corner[0][k]); break;
    default: target[k] = corner[0][k] + a*(corner[1][k] - corner[0][k]) + b*(corner[2][k] - corner[0][k]); break;
    }
  }
  if (kind == AXIS) {
    const int axis = int(random.below(3));
    for (int k = 0; k < 3; k++) dir[k] = k == axis ? (random.chance(0.5) ? 1 : -1) : 0;
  }
  if (kind == IN_PLANE) for (int k = 0; k < 3; k++) dir[k] = corner[1][k] - corner[0][k];
  if (kind == ACROSS) for (double& t : target) t += 0.1*scale*random.normal();
  double length = 0;
  for (double d : dir) length += d*d;
  length = std::sqrt(length);
  if (!(length > 0)) { dir[2] = length = 1; }
  double back = 3*scale; // from the origin to the target
  if (kind == INSIDE) back = 0.2*scale*random.uniform();
  if (kind == ON_SURFACE) back = 0;
  Vec o, d;
  const double lengthOfDirection = random.chance(0.5) ? 1 : random.magnitude(1e-15, 1e18);
  for (int k = 0; k < 3; k++) {
    o[k] = float(target[k] - back*dir[k]/length);
    d[k] = float(dir[k]/length*lengthOfDirection);
  }
  const float unit = float(scale/lengthOfDirection);
  RTCRayHit ray = makeRay(o, d);
  if (kind == SHORT) {
    ray.ray.tnear = unit*float(random.uniform(0, 3.2));
    ray.ray.tfar = unit*float(random.uniform(2.8, 6));
  }
  if (kind == ON_SURFACE) ray.ray.tnear = unit*1e-4f;
  return ray;
}

// --- reference ---------------------------------------------------------------------------

struct Bounds { double nearest, farthest; ReferenceHit exact; double rounding, epsilon; };

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

Bounds referenceBounds(const Block* block, const RTCRay& r)
{
  ReferenceRay ray;
  ray.org[0] = r.org_x; ray.org[1] = r.org_y; ray.org[2] = r.org_z;
  ray.dir[0] = r.dir_x; ray.dir[1] = r.dir_y; ray.dir[2] = r.dir_z;
  ray.tnear = r.tnear; ray.tfar = r.tfar;

  // the epsilon of local_ray.h
  double reach = 0, dir2 = 0, od = 0, shift[3][3];
  for (int i = 0; i < 3; i++) {
    const double o = ray.org[i] - double(block->centre[i]);
    reach = std::max(reach, std::fabs(o));
    od += o*ray.dir[i];
    dir2 += ray.dir[i]*ray.dir[i];
  }
  Bounds bounds;
  bounds.epsilon = 0;
  double size = 0; // of the block in the world
  for (int k = 0; k < 3; k++) {
    double stretch = 0, axis[3];
    for (int i = 0; i < 3; i++) stretch += std::fabs(double(block->columns[i][k]));
    const double epsilon = 4*ulp*reach*stretch + 8*ulp;
    bounds.epsilon = std::max(bounds.epsilon, epsilon);
    axisInWorld(block, k, epsilon, shift[k]);
    axisInWorld(block, k, 1, axis);
    size += std::sqrt(axis[0]*axis[0] + axis[1]*axis[1] + axis[2]*axis[2]);
  }
  const double length = std::sqrt(dir2);
  const double middle = -od/dir2, half = std::max(size, 1e-30)/length;

  bounds.nearest = std::numeric_limits<double>::infinity();
  bounds.farthest = -bounds.nearest;
  bounds.exact = ReferenceIntersector(block, 0).intersect(ray);
  // both ends move alike, apart, or one of them alone: towards each corner of the box of errors
  static const double moves[4][2] = {{1, 1}, {1, -1}, {1, 0}, {0, 1}};
  for (int m = 0; m <= 32; m++) {
    ReferenceRay moved = ray;
    for (int i = 0; i < 3 && m < 32; i++) {
      double delta = 0;
      for (int k = 0; k < 3; k++) delta += ((m >> k) & 1 ? 1 : -1)*shift[k][i];
      const double turn = 0.5*(moves[m >> 3][1] - moves[m >> 3][0])*delta/half;
      moved.org[i] += 0.5*(moves[m >> 3][0] + moves[m >> 3][1])*delta - turn*middle;
      moved.dir[i] += turn;
    }
    for (int widening = 0; widening <= 2; widening++) {
      const ReferenceHit hit = ReferenceIntersector(block, widening).intersect(moved);
      bounds.nearest = std::min(bounds.nearest, hit.t);
      if (hit.found || widening == 0) bounds.farthest = std::max(bounds.farthest, hit.t);
    }
  }
  // t0, t1 and their sums round like the distance to the block, s like 1
  bounds.rounding = ulp*(16*(reach + size)/length);
  return bounds;
}

// Rays in the plane of a triangle, whose test divides by this cosine: t is lost, and with
// it what lies in a block's box.
bool grazes(const RTCRay& r, double x, double y, double z)
{
  const double d[3] = {r.dir_x, r.dir_y, r.dir_z};
  return std::fabs(d[0]*x + d[1]*y + d[2]*z) <= 1e-3*std::sqrt((d[0]*d[0] + d[1]*d[1] + d[2]*d[2])*(x*x + y*y + z*z));
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

// --- the test ----------------------------------------------------------------------------

struct Case { RTCCompression compression; const char* name; };
const Case cases[] = {{RTC_COMPRESSION_GRID, "grid"}, {RTC_COMPRESSION_VOXEL, "voxel"}, {RTC_COMPRESSION_LEAF, "leaf"}};

class SimdReference : public testing::TestWithParam<std::string> {};

void build(RTCDevice device, RTCScene scene, const Sheet& sheet, RTCCompression compression)
{
  SurfaceSettings settings;
  settings.rate = float(sheet.quads);
  settings.compression = compression;
  settings.frameLevel = 0;
  RTCGeometry geometry = newSurface(device, sheet.cage, settings);
  rtcSetGeometryUserData(geometry, (void*)&sheet);
  rtcSetGeometryDisplacementFunction(geometry, Sheet::place);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
}

constexpr int raysPerKind = 8;

void compare(const std::string& isa, const Case& c, uint32_t seed)
{
  Device device(isa + ",threads=1");
  if (!device) GTEST_SKIP() << "this machine does not run " << isa;
  Random random(seed);
  const struct { double scale, position[3]; } placements[] = {
    {1, {0,0,0}}, {1, {0,0,0}}, {1e-3, {0.5,-0.25,1}}, {1e-6, {0,0,0}}, {1e6, {0,0,0}}, {1, {148376,1234,-223423}}};
  unsigned hits = 0, rays = 0, failures = 0, vague = 0, strayed = 0, pinned = 0;
  for (unsigned height = 0; height <= 5; height++)
    for (int shape = 0; shape < SHAPES; shape++)
      for (const auto& at : placements)
      {
        const Sheet sheet = makeSheet(random, Shape(shape), height, at.scale, at.position);
        Scene scene(device), grid(device);
        build(device, scene, sheet, c.compression);
        build(device, grid, sheet, RTC_COMPRESSION_NONE);
        ASSERT_EQ(device.takeError(), RTC_ERROR_NONE);
        const std::vector<const Block*> blocks = sceneBlocks(scene);
        ASSERT_EQ(blocks.size(), 1u);
        ASSERT_EQ(blocks[0]->height(), height);

        for (int i = 0; i < raysPerKind*RAY_KINDS; i++) {
          const int kind = i % RAY_KINDS;
          const RTCRayHit ray = makeRandomRay(random, RayKind(kind), sheet, at.scale);
          const RTCRayHit found = intersect(scene, ray);
          const double t = isHit(found) ? double(found.ray.tfar) : std::numeric_limits<double>::infinity();
          const Bounds bounds = referenceBounds(blocks[0], ray.ray);
          rays++;
          hits += isHit(found);
          vague += !(bounds.farthest - bounds.nearest <= 100*bounds.rounding) && bounds.nearest != bounds.farthest;
          auto where = [&] {
            return testing::Message() << isa << ", " << c.name << ", height " << height << ", " << shapeNames[shape] << ", scale " << at.scale
              << " at " << at.position[0] << ", ray " << rayNames[kind] << ", t " << t << ", reference " << bounds.exact.t
              << " in [" << bounds.nearest << ", " << bounds.farthest << "], rounding " << bounds.rounding;
          };
          if (!(t >= bounds.nearest - bounds.rounding && t <= bounds.farthest + bounds.rounding)) {
            // Embree's triangle test is less exact than a block's bounds are: at the edges of a sheet,
            // and for rays in the plane of a triangle. cGRID strays where GRID does.
            if (c.compression == RTC_COMPRESSION_GRID &&
                (sameHit(found, intersect(grid, ray)) ||
                 (isHit(found) && grazes(ray.ray, found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z)) ||
                 (bounds.exact.found && grazes(ray.ray, bounds.exact.Ng[0], bounds.exact.Ng[1], bounds.exact.Ng[2])))) strayed++;
            else if (failures++ < 12) ADD_FAILURE() << where();
          }
          if (occluded(scene, ray) != isHit(found) && failures++ < 12)
            ADD_FAILURE() << "any hit differs: " << where();
          if (!isHit(found)) continue;
          if (!(found.ray.tfar >= ray.ray.tnear && found.ray.tfar <= ray.ray.tfar) && failures++ < 12)
            ADD_FAILURE() << "outside tnear, tfar: " << where();

          // The same point of the same leaf has the same parameters and normal. Leaves overlap, and
          // a ray may enter two at once.
          if (at.scale != 1 || at.position[0] != 0 || shape == NEEDLE || shape == FLAT || !(std::fabs(t - bounds.exact.t) <= bounds.rounding)) continue;
          const ReferenceHit& e = bounds.exact;
          const double rcpQuads = 1.0/sheet.quads;
          if (std::floor(e.u*sheet.quads) != std::floor(found.hit.u*sheet.quads) || std::floor(e.v*sheet.quads) != std::floor(found.hit.v*sheet.quads)) continue;
          if (c.compression == RTC_COMPRESSION_GRID && nearEdge(e.u*sheet.quads, e.v*sheet.quads)) continue;
          pinned++;
          const double cosine = (e.Ng[0]*found.hit.Ng_x + e.Ng[1]*found.hit.Ng_y + e.Ng[2]*found.hit.Ng_z)/
            std::sqrt((e.Ng[0]*e.Ng[0] + e.Ng[1]*e.Ng[1] + e.Ng[2]*e.Ng[2])*
                      (double(found.hit.Ng_x)*found.hit.Ng_x + double(found.hit.Ng_y)*found.hit.Ng_y + double(found.hit.Ng_z)*found.hit.Ng_z));
          // the error of the position over the extent of a leaf, which may be a few times less than 1/quads
          const double tolerance = 0.01*rcpQuads + 8*bounds.epsilon;
          if (!(std::fabs(e.u - found.hit.u) < tolerance && std::fabs(e.v - found.hit.v) < tolerance && cosine > 0.999) &&
              !(c.compression == RTC_COMPRESSION_GRID && sameHit(found, intersect(grid, ray))) && failures++ < 12)
            ADD_FAILURE() << "u " << found.hit.u << ", v " << found.hit.v << ", expected " << e.u << ", " << e.v << ", cosine " << cosine << ": " << where();
        }
      }
  EXPECT_EQ(failures, 0u) << "of " << rays;
  EXPECT_GT(hits, rays/3) << "the rays miss the blocks";
  EXPECT_LT(vague, rays/3) << "the reference is too vague to test anything";
  EXPECT_LT(strayed, rays/50);
  EXPECT_GT(pinned, rays/20) << "too few parameters and normals compared";
  std::printf("%s, %s: %u rays, %u hits, %u not pinned down, %u strayed with GRID, %u parameters and normals\n", isa.c_str(), c.name, rays, hits, vague, strayed, pinned);
}

TEST_P(SimdReference, FindsTheHitsOfCGrid) { compare(GetParam(), cases[0], 31); }
TEST_P(SimdReference, FindsTheHitsOfCVoxel) { compare(GetParam(), cases[1], 32); }
TEST_P(SimdReference, FindsTheHitsOfCLeaf) { compare(GetParam(), cases[2], 33); }

INSTANTIATE_TEST_SUITE_P(Isa, SimdReference, testing::Values(TEST_ISAS),
  [](const auto& info) {
    std::string name;
    for (char c : info.param) if (std::isalnum(c)) name += c;
    return name;
  });

} // namespace
} // namespace cbvh
