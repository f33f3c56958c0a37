// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces rays through blocks of random words with the kernels' intersectors and with the scalar one. Compiled once for
 * every ISA, outside of the library.
 *
 * Children of random words overlap, leaves have steps between them, and rays pass over boxes: more cases of the hit
 * rule and of the traversal order than in blocks of the encoder. */

#include "kernels/common/scene.h"
#include "kernels/cbvh/paper/block_intersector1.h"
#include "support/scalar_intersector.h"
#include "support/encoded_block.h"
#include "support/random.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <tuple>
#include <vector>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

// --- a ray that stores hits here instead of calling Embree's epilogues ----------------------

namespace programs::test {

struct RecordingRay : public embree::Ray {
  using embree::Ray::Ray;

  float from = -1; // earlier hits are rejected, as by a filter
  bool found = false;
  float u = 0, v = 0;
  float Ng[3] = {0, 0, 0};
};

struct AnyHitRay : public embree::Ray {
  using embree::Ray::Ray;

  bool found = false;
};

// Receives a visitor's report, whose last argument is the hit.
template<typename... Reported>
bool report(RecordingRay& ray, embree::IntersectContext*, Reported&&... reported) {
  const embree::isa::cbvh::SurfaceHit1& hit = std::get<sizeof...(Reported) - 1>(std::tie(reported...));
  if (hit.t < ray.from) return false;
  ray.found = true;
  ray.tfar = hit.t;
  ray.u = hit.u;
  ray.v = hit.v;
  for (int k = 0; k < 3; k++) ray.Ng[k] = hit.Ng[k];
  return true;
}

template<typename... Reported>
bool report(AnyHitRay& ray, embree::IntersectContext*, Reported&&...) {
  return ray.found = true;
}

} // namespace programs::test

namespace embree::isa::cbvh {
template<> struct IsAnyHit<::programs::test::RecordingRay> {
  static const bool value = false;
};
template<> struct IsAnyHit<::programs::test::AnyHitRay> {
  static const bool value = true;
};
} // namespace embree::isa::cbvh

namespace programs::test { namespace {

using namespace embree::cbvh;
namespace simd = embree::isa::cbvh;
typedef ScalarIntersector<double> Scalar;

// --- blocks ---------------------------------------------------------------------------------

enum Outline { SQUARE, TRAPEZOID, SKEWED, NEEDLE, OUTLINES };

// Corners of a randomly rotated quad: (0,0), (1,0), (0,1), (1,1).
struct Quad {
  float corners[4][3];
  double size;

  Quad(Random& random, Outline outline) {
    size = random.magnitude(1e-3, 1e3);
    double axis[3][3]; // orthogonal
    auto unit = [&](double a[3]) {
      const double length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
      for (int k = 0; k < 3; k++) a[k] /= length;
    };
    for (int i = 0; i < 2; i++)
      for (double& a : axis[i]) a = random.normal();
    unit(axis[0]);
    auto cross = [&](const double a[3], const double b[3], double c[3]) {
      for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    };
    cross(axis[0], axis[1], axis[2]);
    unit(axis[2]);
    cross(axis[2], axis[0], axis[1]);
    const double away = random.chance(0.5) ? 0 : size * random.magnitude(1, 1e3),
                 center[3] = {away * random.normal(), away * random.normal(), away * random.normal()};
    double plane[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    if (outline == TRAPEZOID) {
      plane[2][0] = 0.3;
      plane[3][0] = 0.7;
    }
    if (outline == SKEWED) {
      plane[2][0] += 2;
      plane[3][0] += 2;
    }
    for (int c = 0; c < 4; c++) {
      if (outline == NEEDLE) plane[c][1] *= 0x1p-9;
      const double z = outline == NEEDLE ? 0 : 0.1 * random.normal();
      for (int k = 0; k < 3; k++)
        corners[c][k] =
            float(center[k] + size * (plane[c][0] * axis[0][k] + plane[c][1] * axis[1][k] + z * axis[2][k]));
    }
  }
};

uint64_t randomHeights(Random& random) {
  if (random.chance(0.5)) {
    uint64_t heights = 0;
    for (int child = 0; child < 4; child++) {
      const uint32_t any = random.below(0x7FFE), leaf = random.chance(0.1)   ? solidLeaf
                                                        : random.chance(0.1) ? emptyLeaf
                                                                             : any;
      heights |= uint64_t(leaf) << (separateLeafBits * child);
    }
    return heights | uint64_t(random.below(8)) << separateThicknessShift | uint64_t(1) << 63;
  }
  int heights[9];
  for (int& h : heights) h = int(random.below(latticeBins));
  heights[4] = latticeBins / 2; // all patches are at least partly in the box, as in encoded blocks
  const Heights bits = packLattice(heights);
  return uint64_t(bits.high) << 32 | bits.low;
}

// Planes of a lattice ascend, as in encoded blocks.
uint32_t randomLatticeWord(Random& random) {
  uint32_t word = random.below(4) << latticeThicknessShift;
  for (int axis = 0; axis < 2; axis++)
    word |= (random.below(16) | random.below(16) << 5 | random.below(32) << 10) << latticeShift(axis);
  return word;
}

// A frame that fits a quad, with random words and heights.
class RandomBlock {
public:
  RandomBlock(Random& random, Kind kind, uint32_t height, const Quad& quad)
    : memory(blockLayout(uint32_t(kind), height).bytes / 16 + 1) {
    const std::vector<float> vertices(&quad.corners[0][0], &quad.corners[0][0] + 12);
    const EncodedBlock frame(Kind::CVOXEL, 0, vertices, quad.corners);
    EXPECT_TRUE(frame);
    Block* block = (Block*)memory.data();
    (BlockHeader&)* block = *frame.get();
    const uint32_t blocks = 1 + random.below(4);
    block->info = blockInfo(uint32_t(kind), height, random.below(blocks), random.below(blocks));
    block->tiling = blockTiling(blocks - 1, blocks - 1, 0, 0);
    const BlockLayout layout = block->layout();
    for (uint32_t i = 0; i < layout.numNodes; i++) block->nodes()[i] = random.bits();
    if (kind != Kind::CLEAF) return;
    block->info |= random.below(4) << 28;
    for (uint32_t i = 0; i < layout.leavesPerSide * layout.leavesPerSide / 4; i++) {
      const uint64_t heights = randomHeights(random);
      std::memcpy(block->leaves() + 8 * i, &heights, 8);
      if (!(heights >> 63)) block->nodes()[nodesOfLevels(layout.nodeLevels - 1) + i] = randomLatticeWord(random);
    }
  }

  const Block* get() const { return (const Block*)memory.data(); }

private:
  struct alignas(16) Unit {
    char bytes[16];
  };
  std::vector<Unit> memory;
};

// --- rays -----------------------------------------------------------------------------------

struct TestRay {
  float org[3], dir[3], tnear, tfar;
};

// A ray of any direction and length through a point in the block's box; some rays start or end there.
TestRay randomRay(Random& random, const Block* block) {
  const InverseFrame inverse(frameMap(block));
  const Double3 a = inverse({random.uniform(), random.uniform(), random.uniform()}),
                b = inverse({random.uniform(), random.uniform(), random.uniform()});
  const Double3 d = b - a;
  const double before = random.chance(0.3) ? 0 : random.magnitude(0.5, 30), scale = random.magnitude(1e-9, 1e9);
  TestRay ray;
  for (int k = 0; k < 3; k++) {
    const double dk = k == 0 ? d.x : k == 1 ? d.y : d.z, ak = k == 0 ? a.x : k == 1 ? a.y : a.z;
    ray.org[k] = float(block->center[k] + ak - before * dk);
    ray.dir[k] = float(scale * dk);
  }
  ray.tnear = random.chance(0.3) ? float(random.uniform(0, before + 0.5) / scale) : 0;
  ray.tfar = random.chance(0.3) ? float((before + random.uniform(0, 1.5)) / scale) : INFINITY;
  if (ray.tfar < ray.tnear) std::swap(ray.tnear, ray.tfar);
  return ray;
}

Scalar::Ray exact(const TestRay& ray) {
  Scalar::Ray r;
  std::copy_n(ray.org, 3, r.org);
  std::copy_n(ray.dir, 3, r.dir);
  r.tnear = ray.tnear;
  r.tfar = ray.tfar;
  return r;
}

template<typename RayType>
RayType makeRay(const TestRay& ray) {
  return RayType(embree::Vec3fa(ray.org[0], ray.org[1], ray.org[2]), embree::Vec3fa(ray.dir[0], ray.dir[1], ray.dir[2]),
                 ray.tnear, ray.tfar);
}

// The library is not linked. Only this scene's table of surfaces is read, and it is empty.
embree::IntersectContext* contextOfZeros() {
  alignas(64) static char scene[sizeof(embree::Scene)];
  static RTCIntersectContext user;
  static embree::IntersectContext context((embree::Scene*)scene, &user);
  return &context;
}

template<typename RayType>
void traceSimd(const Block* block, RayType& ray) {
  invalidateThreadCaches(); // new blocks may reuse the addresses of old ones
  const simd::RayState state(ray);
  if (block->kind() == Kind::CLEAF)
    simd::BlockIntersector1<simd::LeafVisitor1>::intersect(ray, contextOfZeros(), state, block);
  else simd::BlockIntersector1<simd::VoxelVisitor1>::intersect(ray, contextOfZeros(), state, block);
}

// --- the same hits ----------------------------------------------------------------------------

// several times the float error of a ray that begins up to thirty block sizes away, at a block up to a thousand block
// sizes from the origin
constexpr double step = 3e-5;

// The scalar intersector's result for a ray and nearby ones: the same hit, or a miss for all.
struct Answer {
  bool stable = true, found;
  double lower[6], upper[6]; // ranges of t/unit, u, v, and the unit normal
  double unit;               // change of t over the size of the block

  // from: hits with smaller t are ignored
  Answer(Random& random, const Block* block, const TestRay& ray, double size, double from = -1) {
    double distance = 0, length = 0;
    for (int k = 0; k < 3; k++) {
      length += double(ray.dir[k]) * ray.dir[k];
      distance += (double(ray.org[k]) - block->center[k]) * (double(ray.org[k]) - block->center[k]);
    }
    length = std::sqrt(length);
    distance = std::sqrt(distance) + size;
    unit = size / length;
    uint32_t leaf = 0;
    for (int i = 0; i < 24; i++) {
      Scalar::Ray r = exact(ray);
      if (i > 2)
        for (int k = 0; k < 3; k++) {
          r.org[k] += step * size * random.uniform(-1, 1);
          r.dir[k] += step * size / distance * length * random.uniform(-1, 1);
        }
      std::vector<Scalar::Hit> all;
      Scalar(block, i < 3 ? i : 1).intersect(r, &all);
      Scalar::Hit hit;
      for (const Scalar::Hit& h : all)
        if (h.t >= from && h.t < hit.t) hit = h;
      for (const Scalar::Hit& h : all) // leaves overlap, and a ray may enter several at once
        stable &= h.t < from || h.leaf == hit.leaf || h.t > hit.t + 1e-3 * unit;
      if (i == 0) {
        found = hit.found;
        leaf = hit.leaf;
      }
      stable &= hit.found == found && (!found || hit.leaf == leaf);
      if (!stable || !found) continue;
      const double n = std::sqrt(hit.Ng[0] * hit.Ng[0] + hit.Ng[1] * hit.Ng[1] + hit.Ng[2] * hit.Ng[2]);
      const double value[6] = {hit.t / unit, hit.u, hit.v, hit.Ng[0] / n, hit.Ng[1] / n, hit.Ng[2] / n};
      for (int k = 0; k < 6; k++) {
        lower[k] = i == 0 ? value[k] : std::min(lower[k], value[k]);
        upper[k] = i == 0 ? value[k] : std::max(upper[k], value[k]);
      }
    }
    for (int k = 0; stable && found && k < 6; k++) stable &= upper[k] - lower[k] < 0.05;
  }

  void expect(const RecordingRay& ray) const {
    ASSERT_EQ(ray.found, found);
    if (!found) return;
    const double value[6] = {ray.tfar / unit, ray.u, ray.v, ray.Ng[0], ray.Ng[1], ray.Ng[2]};
    for (int k = 0; k < 6; k++) {
      const double slack = 1e-4 + 0.5 * (upper[k] - lower[k]);
      ASSERT_GE(value[k], lower[k] - slack) << "value " << k;
      ASSERT_LE(value[k], upper[k] + slack) << "value " << k;
    }
  }
};

// Calls closure(block, size, ray) for many rays.
template<typename Closure>
void forRandomRays(Random& random, Kind kind, const Closure& closure) {
  for (int i = 0; i < 600; i++) {
    const Quad quad(random, Outline(random.below(NEEDLE)));
    const RandomBlock block(random, kind, random.below(5), quad);
    for (int j = 0; j < 12; j++) {
      SCOPED_TRACE(testing::Message() << "block " << i << ", ray " << j << ", height " << block.get()->height());
      closure(block.get(), quad.size, randomRay(random, block.get()));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// Compares rays whose result does not depend on rounding.
void compareHits(Kind kind, uint32_t seed) {
  Random random(seed);
  unsigned rays = 0, stable = 0, hits = 0;
  forRandomRays(random, kind, [&](const Block* block, double size, const TestRay& r) {
    const Answer answer(random, block, r, size);
    rays++;
    if (!answer.stable) return;
    stable++;
    hits += answer.found;
    RecordingRay closest = makeRay<RecordingRay>(r);
    traceSimd(block, closest);
    answer.expect(closest);
    AnyHitRay any = makeRay<AnyHitRay>(r);
    traceSimd(block, any);
    ASSERT_EQ(any.found, answer.found);
  });
  std::printf("%u rays, %u stable, %u of them hits\n", rays, stable, hits);
  EXPECT_GT(stable, rays / 2);
  EXPECT_GT(hits, stable / 4);
  EXPECT_GT(stable - hits, stable / 50);
}

TEST(SimdTracing, PatchHitsMatchScalarCode) { compareHits(Kind::CLEAF, 95); }
TEST(SimdTracing, BoxHitsMatchScalarCode) { compareHits(Kind::CVOXEL, 96); }

// For cVOXEL, where earlier hits have no influence.
TEST(SimdTracing, NearestBoxThatIsNotRejectedIsHit) {
  Random random(98);
  unsigned compared = 0;
  forRandomRays(random, Kind::CVOXEL, [&](const Block* block, double size, const TestRay& r) {
    std::vector<Scalar::Hit> all;
    Scalar(block, 0).intersect(exact(r), &all);
    if (all.size() < 2) return;
    RecordingRay ray = makeRay<RecordingRay>(r);
    const Answer nearest(random, block, r, size);
    ray.from = float(all[random.below(uint32_t(all.size()))].t + 1e-3 * nearest.unit);
    const Answer answer(random, block, r, size, ray.from);
    if (!answer.stable) return;
    compared++;
    traceSimd(block, ray);
    answer.expect(ray);
  });
  std::printf("%u rays\n", compared);
  EXPECT_GT(compared, 1000u);
}

// --- the ray in the frame ---------------------------------------------------------------------

// Distance of a point in the frame from the exact line, in epsilons of the axes.
double epsilonsOff(const Double3& a, const Double3& b, const double p[3], const double epsilon[3]) {
  const double from[3] = {a.x, a.y, a.z}, to[3] = {b.x, b.y, b.z};
  auto off = [&](double s) {
    double most = 0;
    for (int k = 0; k < 3; k++) most = std::max(most, std::fabs(p[k] - from[k] - s * (to[k] - from[k])) / epsilon[k]);
    return most;
  };
  double lower = -0.5, upper = 1.5; // convex in s
  for (int i = 0; i < 80; i++) {
    const double third = (upper - lower) / 3;
    if (off(lower + third) < off(upper - third)) upper -= third;
    else lower += third;
  }
  return off(0.5 * (lower + upper));
}

// This closes the gaps between blocks: each block sees a ray with an error below its epsilon.
TEST(SimdTracing, SegmentsAreWithinEpsilonOfRay) {
  Random random(97);
  double most[OUTLINES] = {};
  for (int outline = 0; outline < OUTLINES; outline++)
    for (int i = 0; i < 3000; i++) {
      const Quad quad(random, Outline(outline));
      const RandomBlock memory(random, Kind::CVOXEL, 0, quad);
      const Block* block = memory.get();
      const TestRay r = randomRay(random, block);
      const embree::Ray ray = makeRay<embree::Ray>(r);
      const simd::RayState state(ray);
      simd::LocalRay local;
      if (!local.init(state, block, ray.tfar)) continue;
      const Segment<double> segment = enterBlock(*block, exact(r), 1.0);
      if (!segment.valid) continue;
      const Double3 a = {segment.P0[0], segment.P0[1], segment.P0[2]},
                    b = {segment.P1[0], segment.P1[1], segment.P1[2]};
      double size = 0;
      for (int k = 0; k < 3; k++) size = std::max(size, std::fabs(segment.P1[k] - segment.P0[k]));
      if (size < 0.05) continue; // touches only a corner of the box
      for (float s : {0.0f, 0.5f, 1.0f}) {
        double p[3], epsilon[3];
        for (int k = 0; k < 3; k++) {
          p[k] = double(local.P0[k]) + s * (double(local.P1[k]) - double(local.P0[k]));
          epsilon[k] = local.epsilon[k];
          ASSERT_NEAR(epsilon[k], segment.epsilon[k], 1e-3 * segment.epsilon[k]);
        }
        most[outline] = std::max(most[outline], epsilonsOff(a, b, p, epsilon));
      }
    }
  std::printf("in epsilons, at most: square %g, trapezoid %g, skewed %g, needle %g\n", most[SQUARE], most[TRAPEZOID],
              most[SKEWED], most[NEEDLE]);
  for (double m : most) EXPECT_LT(m, 1);
}

// --- boxes and leaves --------------------------------------------------------------------------

// A segment in scalar and SIMD form: any path through the box of a block, widened by any epsilon.
struct BothSegments {
  simd::LocalRay local;
  Segment<double> scalar;

  explicit BothSegments(Random& random) {
    for (int k = 0; k < 3; k++) {
      const float p0 = float(random.uniform()), p1 = float(random.uniform()),
                  epsilon = float(random.magnitude(1e-3, 3e-2));
      local.P0[k] = p0;
      local.P1[k] = p1;
      local.epsilon[k] = epsilon;
      scalar.P0[k] = p0;
      scalar.P1[k] = p1;
      scalar.epsilon[k] = epsilon;
    }
    local.P0[3] = local.P1[3] = local.epsilon[3] = 0;
    scalar.startClipped = local.startClipped = random.chance(0.5);
    scalar.endClipped = local.endClipped = random.chance(0.5);
    scalar.t0 = scalar.w0 = local.t0 = local.w0 = scalar.w1 = local.w1 = 1;
    scalar.t1 = local.t1 = 2;
    scalar.valid = true;
  }

  // A copy with an error larger than float rounding.
  Segment<double> moved(Random& random) const {
    Segment<double> segment = scalar;
    for (int k = 0; k < 3; k++) {
      segment.P0[k] += 1e-5 * random.uniform(-1, 1);
      segment.P1[k] += 1e-5 * random.uniform(-1, 1);
      segment.epsilon[k] += 1e-5 * random.uniform(-1, 1);
    }
    return segment;
  }
};

enum Encounter { MISSES, HITS, PASSES_ABOVE, PASSES_BELOW, ENCOUNTERS };

// See "Rays" in kernels/cbvh/paper/README.md.
Encounter encounter(const Segment<double>& segment, const NodeBox& box) {
  if (isOnSegment(rangeInBox(segment, box, 3))) return HITS;
  const Range<double> range = rangeInBox(segment, box, 2);
  if (!isOnSegment(range)) return MISSES;
  const double middle = 0.5 * (std::max(range.lower, 0.0) + std::min(range.upper, 1.0));
  return segmentAt(segment, 2, middle) > box.lower[2] + 0.5 * box.extent[2] ? PASSES_ABOVE : PASSES_BELOW;
}

TEST(SimdTracing, BoxesAreHitAndPassedAsInScalarCode) {
  Random random(99);
  unsigned counts[ENCOUNTERS] = {}, unstable = 0;
  for (int i = 0; i < 20000; i++) {
    const BothSegments segments(random);
    const simd::NodeRay ray(segments.local);
    const uint32_t word = random.bits();
    NodePlanes<4> boxes;
    simd::decodeNode(word, rootBox(), boxes, 0);
    simd::BoxRanges<4> ranges;
    const simd::BoxMasks masks = simd::intersectBoxes<embree::vfloat4>(ray, boxes, 1.0f, ranges);
    for (uint32_t child = 0; child < 4; child++) {
      const NodeBox box = decodeChild(word, int(child), rootBox());
      const Encounter expected = encounter(segments.scalar, box);
      bool stable = true;
      for (int m = 0; m < 8; m++) stable &= encounter(segments.moved(random), box) == expected;
      if (!stable) {
        unstable++;
        continue;
      }
      counts[expected]++;
      SCOPED_TRACE(testing::Message() << "segment " << i << ", child " << child);
      ASSERT_EQ((masks.hit >> child) & 1, uint32_t(expected == HITS));
      ASSERT_EQ((masks.passed >> child) & 1, uint32_t(expected == PASSES_ABOVE || expected == PASSES_BELOW));
      if ((masks.passed >> child) & 1) { ASSERT_EQ(ray.isAbove(boxes, child), expected == PASSES_ABOVE); }
    }
  }
  for (unsigned count : counts) EXPECT_GT(count, 1000u);
  EXPECT_LT(unstable, 1000u);
}

bool sameEvent(const LeafEvent& a, const LeafEvent& b) {
  return a.enter == b.enter && a.leave == b.leave && a.changes == b.changes && a.nearEntry == b.nearEntry &&
         a.near == b.near && a.started == b.started && a.ended == b.ended && a.solid == b.solid && a.empty == b.empty;
}

std::string textOf(const LeafEvent& e) {
  const bool flags[7] = {e.changes, e.nearEntry, e.near, e.started, e.ended, e.solid, e.empty};
  std::string text = std::string("enter ") + (e.enter == sideAbove ? "above" : "below") + ", leave " +
                     (e.leave == sideAbove ? "above" : "below");
  const char* const names[7] = {"changes", "nearEntry", "near", "started", "ended", "solid", "empty"};
  for (int i = 0; i < 7; i++)
    if (flags[i]) text += std::string(", ") + names[i];
  return text;
}

TEST(SimdTracing, LeavesAreCrossedAsInScalarCode) {
  Random random(100);
  unsigned compared = 0, unstable = 0, counts[2][7] = {};
  for (int i = 0; i < 20000; i++) {
    const BothSegments segments(random);
    const simd::NodeRay ray(segments.local);
    const uint64_t bits = randomHeights(random);
    const Heights heights = {uint32_t(bits), uint32_t(bits >> 32)};
    const uint32_t word = hasSeparateLeaves(heights) ? random.bits() : randomLatticeWord(random);
    NodeEntries::LeafTile tile;
    // all four groups are the same
    for (uint32_t c = 0; c < 4; c++)
      simd::GroupDecoder4(tile.grandchildren, tile.surfaces, 4 * c).decode(word, bits, rootBox());
    simd::BoxRanges<16> ranges;
    const simd::BoxMasks masks = simd::intersectBoxes<simd::vfloatV>(ray, tile.grandchildren, 1.0f, ranges);
    const uint32_t first = 4 * random.below(4);
    for (uint32_t lane = 0; lane < 4; lane++) {
      const uint32_t child = first + lane;
      ASSERT_EQ((masks.hit >> child) & 1, (masks.hit >> lane) & 1);
      const LeafPatch leaf = decodeLeaf(word, heights, int(lane), rootBox());
      if (leaf.solid || leaf.empty || !((masks.hit >> child) & 1)) continue;
      const LeafEvent expected = crossPatch(segments.scalar, leaf).event;
      bool stable = encounter(segments.scalar, leaf.box) == HITS;
      for (int m = 0; m < 8; m++) {
        const Segment<double> moved = segments.moved(random);
        stable = stable && encounter(moved, leaf.box) == HITS && sameEvent(crossPatch(moved, leaf).event, expected);
      }
      if (!stable) {
        unstable++;
        continue;
      }
      compared++;
      const bool started = segments.local.startClipped && ranges.sNear[child] < 0,
                 ended = segments.local.endClipped && ranges.sFar[child] > 1;
      const LeafEvent event = simd::crossDecodedLeaf(ray, tile, child, ranges, started, ended).event;
      ASSERT_TRUE(sameEvent(event, expected))
          << "segment " << i << ", lane " << lane << ": " << textOf(event) << "; expected " << textOf(expected);
      const bool flags[7] = {expected.enter == sideAbove,
                             expected.leave == sideAbove,
                             expected.changes,
                             expected.nearEntry,
                             expected.near,
                             expected.started,
                             expected.ended};
      for (int f = 0; f < 7; f++) counts[flags[f]][f]++;
    }
  }
  std::printf("%u leaves, %u unstable\n", compared, unstable);
  EXPECT_LT(unstable, compared / 20);
  for (const auto& of : counts)
    for (unsigned count : of) EXPECT_GT(count, 500u);
}

// --- order of hits --------------------------------------------------------------------------

const SurfaceIDs ids; // surface numbers are IDs

struct CountedHit {
  float comparedT, hitT; // see NearestHit
  Block block;
};

// Offers hits to a ray in an order, as traversal does. Returns its final tfar.
float endOfRay(const std::vector<const CountedHit*>& order, simd::NearestHit& nearest) {
  float tfar = INFINITY;
  for (const CountedHit* hit : order) {
    if (nearest.isBefore(hit->comparedT, hit->hitT, &hit->block, tfar, ids)) continue;
    nearest.set(hit->comparedT, hit->hitT, &hit->block, hit->hitT);
    tfar = hit->comparedT;
  }
  return tfar;
}

// Each hit precedes the next one, in every order of insertion.
TEST(NearestHit, NearestWinsThenFirstBlockInEveryOrder) {
  CountedHit hits[7] = {};
  const struct {
    float comparedT, hitT;
    uint32_t geomID, primID, tiling, info;
  } values[7] = {{1, 1, 2, 7, 3, 9}, {2, 1.5f, 2, 7, 3, 9}, {2, 2, 1, 8, 4, 9}, {2, 2, 2, 6, 4, 9},
                 {2, 2, 2, 7, 1, 9}, {2, 2, 2, 7, 3, 5},    {2, 2, 2, 7, 3, 6}};
  for (int i = 0; i < 7; i++) {
    hits[i].comparedT = values[i].comparedT;
    hits[i].hitT = values[i].hitT;
    hits[i].block.surface = values[i].geomID;
    hits[i].block.primID = values[i].primID;
    hits[i].block.tiling = values[i].tiling;
    hits[i].block.info = values[i].info;
  }
  for (int first = 0; first < 7; first++) {
    std::vector<const CountedHit*> order;
    for (int i = first; i < 7; i++) order.push_back(&hits[i]);
    do {
      simd::NearestHit nearest;
      const float tfar = endOfRay(order, nearest);
      ASSERT_EQ(nearest.block, &hits[first].block);
      ASSERT_EQ(nearest.finalTfar(tfar), hits[first].hitT);
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

// Hits of triangles change only the ray's tfar: they are closer than a block's hit, or at the same distance.
TEST(NearestHit, FinalTfarBelongsToTheNearestHit) {
  Block block = {};
  simd::NearestHit nearest;
  EXPECT_EQ(nearest.finalTfar(3), 3);
  EXPECT_TRUE(nearest.isBefore(3, 2.5f, &block, 2, ids));
  EXPECT_FALSE(nearest.isBefore(1.5f, 1.5f, &block, 2, ids));
  nearest.set(2, 1.5f, &block, 1.5f);
  EXPECT_EQ(nearest.finalTfar(2), 1.5f);
  EXPECT_EQ(nearest.finalTfar(1), 1) << "the later hit is nearer";
  nearest.set(2, 1.5f, &block, 0.5f);
  EXPECT_EQ(nearest.finalTfar(0.5f), 0.5f) << "a filter has decreased tfar";
}

}} // namespace programs::test
