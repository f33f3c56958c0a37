// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Moving cVERT blocks are lossless at every time step, boxes of a segment contain their groups at both ends, and
 * rotation, bending and scaling need few bytes. */

#include "kernels/cvert/encoder/lattice.h"
#include "kernels/cvert/encoder/motion_encoder.h"
#include "kernels/cvert/decoder/decoded_block.h"
#include "kernels/cvert/decoder/validate.h"
#include "support/moving_sheet.h"

#include <gtest/gtest.h>

#include <memory>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 311;

bool sameFloat(float a, float b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0 || (a == 0 && b == 0) || (std::isnan(a) && std::isnan(b));
}

// Form and margins of the boxes of the segment that begins at a step, or null if one of its ends is raw.
const uint8_t* marginsOf(const VertHeader* block, uint32_t segment, uint32_t& info) {
  const VertStep* const end = stepOf(block, segment + 1);
  if (isRaw(end->info) || isRaw(segment ? stepOf(block, segment)->info : block->info)) return nullptr;
  info = segment ? stepOf(block, segment)->info : block->info;
  return segment ? (const uint8_t*)stepOf(block, segment) + vertStepLayout(block->region, info).margins
                 : (const uint8_t*)block + vertLayout(block->region, info).margins;
}

// Relative to the origin of a step; exact.
double shearedCoordinate(uint32_t info, const float origin[3], const float* p) {
  const int m = shearedAxis(info), a = (m + 1) % 3, b = (m + 2) % 3;
  return double(p[m]) - origin[m] + shearSlope(info, 1) / 16.0 * (double(p[a]) - origin[a]) +
         shearSlope(info, 2) / 16.0 * (double(p[b]) - origin[b]);
}

void expectBoxesContain(const EncodedMotion& encoded, uint32_t segment) {
  const VertHeader* const block = encoded.block();
  uint32_t info = 0;
  const uint8_t* const margins = marginsOf(block, segment, info);
  if (!margins) return;
  for (uint32_t step : {segment, segment + 1}) {
    const auto decoded = std::make_unique<DecodedBlock>(block, step);
    const float* const origin = step ? stepOf(block, step)->origin : block->origin;
    const uint32_t groupsX = groupsOf(decoded->quadsX), groups = groupsX * groupsOf(decoded->quadsY);
    for (uint32_t g = 0; g < groups; g++) {
      float lower[3], upper[3];
      decoded->groupBox(g, info, margins, lower, upper);
      const uint32_t x0 = 4 * (g % groupsX), y0 = 4 * (g / groupsX);
      for (uint32_t y = y0; y <= std::min(y0 + 4, decoded->quadsY); y++)
        for (uint32_t x = x0; x <= std::min(x0 + 4, decoded->quadsX); x++)
          for (int k = 0; k < 3; k++) {
            const float* const p = decoded->vertex(x, y);
            const double c = k == shearedAxis(info) ? shearedCoordinate(info, origin, p) : p[k];
            ASSERT_TRUE(lower[k] <= c && c <= upper[k])
                << "segment " << segment << ", step " << step << ", group " << g << ", axis " << k;
          }
    }
  }
}

TEST(MotionBlock, VerticesRoundTripAtEveryStep) {
  Random random(seed);
  auto encoder = std::make_unique<MotionEncoder>();
  size_t raw = 0, turned = 0, alone = 0;
  for (int i = 0; i < 1500; i++) {
    const MovingSheet sheet(random, 1 + random.below(16), 1 + random.below(16), i);
    const EncodedMotion encoded(*encoder, sheet);
    ASSERT_GT(encoded.size, sizeof(VertHeader));
    ASSERT_LE(encoded.size, MotionEncoder::maxBytes(sheet.steps.size()));
    ASSERT_EQ((vertBytes(encoded.block()) + 3) & ~3u, encoded.size) << "unused bytes";
    ASSERT_EQ(validateVert(encoded.block(), encoded.size).message(), "");
    ASSERT_EQ(motionOf(encoded.block()).numSteps, sheet.steps.size());
    for (uint32_t s = 0; s < sheet.steps.size(); s++) {
      const auto decoded = std::make_unique<DecodedBlock>(encoded.block(), s);
      for (size_t v = 0; v < sheet.steps[s].size(); v++)
        for (int k = 0; k < 3; k++) {
          const auto& p = sheet.steps[s][v];
          const bool isFinite = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
          ASSERT_TRUE(isFinite ? sameFloat(decoded->vertices[v][k], p[k]) : std::isnan(decoded->vertices[v][k]))
              << "sheet " << i << ", step " << s << ", vertex " << v << ", axis " << k;
        }
      if (s + 1 < sheet.steps.size()) { ASSERT_NO_FATAL_FAILURE(expectBoxesContain(encoded, s)) << "sheet " << i; }
    }
    raw += encoded.statistics.raw;
    turned += encoded.statistics.rotatedGroups;
    const size_t groups = groupsOf(sheet.quadsX) * groupsOf(sheet.quadsY) * (sheet.steps.size() - 1);
    if (!encoded.statistics.raw) alone += groups - encoded.statistics.rotatedGroups;
  }
  EXPECT_GT(raw, 100u);
  EXPECT_GT(turned, 5000u);
  EXPECT_GT(alone, 500u);
}

TEST(MotionBlock, RawStepsStoreFloats) {
  Random random(seed + 3);
  auto encoder = std::make_unique<MotionEncoder>();
  MovingSheet sheet(random, 3, 2, SheetMotion::turn, 1, 4);
  for (int s : {0, 1, 2}) sheet.steps[s][5][s] = -INFINITY;
  for (auto& p : sheet.steps[3]) p[2] = NAN;
  const EncodedMotion encoded(*encoder, sheet);
  const size_t vertices = 12 * 12, boxes = 6 * 4, offsets = 3 * 4;
  EXPECT_EQ(encoded.size, 64 + 16 + vertices + boxes + offsets + 3 * (64 + vertices));
  for (uint32_t s : {1, 2, 3})
    for (int k = 0; k < 3; k++) {
      float least = s == 3 ? 0 : INFINITY;
      for (size_t v = 0; v < 12 && s < 3; v++)
        if (v != 5) least = std::min(least, sheet.steps[s][v][k]);
      EXPECT_EQ(stepOf(encoded.block(), s)->origin[k], least) << "step " << s << ", axis " << k;
    }
}

TEST(MotionBlock, ReservedBitsOfLaterStepsAreUnsupported) {
  Random random(seed + 4);
  auto encoder = std::make_unique<MotionEncoder>();
  MovingSheet sheet(random, 6, 5, SheetMotion::turn, 1, 3);
  sheet.steps[2][7][0] = NAN; // a raw step
  EncodedMotion encoded(*encoder, sheet);
  ASSERT_FALSE(isRaw(stepOf(encoded.block(), 1)->info));
  ASSERT_TRUE(isRaw(stepOf(encoded.block(), 2)->info));
  ASSERT_EQ(validateVert(encoded.block(), encoded.size).message(), "");
  for (uint32_t s : {1, 2}) {
    VertStep* const step = (VertStep*)stepOf(encoded.block(), s);
    const auto expectUnsupported = [&](uint32_t& word, uint32_t bit) {
      word ^= 1u << bit;
      EXPECT_EQ(validateVert(encoded.block(), encoded.size).code, ErrorCode::UNSUPPORTED) << "step " << s;
      word ^= 1u << bit;
    };
    expectUnsupported(step->rotation, 23);
    for (uint32_t i : {4, 5})
      for (uint32_t bit : {14, 15, 30, 31}) expectUnsupported(step->corners[i], bit);
  }
}

// Bytes of the later steps per 16 x 16 quads.
double bytesOfLaterSteps(MotionEncoder& encoder, const MovingSheet& sheet) {
  const EncodedMotion encoded(encoder, sheet);
  EXPECT_FALSE(encoded.statistics.raw);
  return double(encoded.statistics.stepBytes);
}

TEST(MotionBlock, RotationBendingAndScalingArePredicted) {
  Random random(seed + 1);
  auto encoder = std::make_unique<MotionEncoder>();
  for (const SheetMotion motion : {SheetMotion::turn, SheetMotion::grow, SheetMotion::bend}) {
    double moving = 0, still = 0, own = 0;
    for (int i = 0; i < 50; i++) {
      const MovingSheet sheet(random, 16, 16, motion, 30, 2);
      moving += bytesOfLaterSteps(*encoder, sheet);
      own += double(EncodedMotion(*encoder, MovingSheet(sheet, {1, 0})).firstStepBytes());
      still += bytesOfLaterSteps(*encoder, MovingSheet(sheet, {0, 0}));
    }
    EXPECT_LT(moving, 0.7 * own) << "motion " << int(motion);
    EXPECT_LT(still, 110.0 * 50) << "a step without motion must have no fields";
  }
}

// Displacement along the diagonal of the world: least squares are nearly singular.
TEST(MotionBlock, ParallelResidualsArePredicted) {
  Random random(seed + 3);
  auto encoder = std::make_unique<MotionEncoder>();
  for (uint32_t height : {700u, 3000u}) {
    double still = 0, own = 0;
    for (int i = 0; i < 50; i++) {
      MovingSheet sheet(random, 16, 16, SheetMotion::turn, 0, 2);
      for (uint32_t v = 0; v < 17 * 17; v++) {
        const float x = 64 * float(v % 17), y = 64 * float(v / 17), h = float(random.below(height));
        for (auto& step : sheet.steps) step[v] = {x + h, y + h, h};
      }
      still += bytesOfLaterSteps(*encoder, sheet);
      own += double(EncodedMotion(*encoder, sheet).firstStepBytes());
    }
    EXPECT_LT(still, 0.7 * own) << "height " << height;
  }
}

TEST(MotionBlock, RandomMotionIsNotLargerThanSeparateSteps) {
  Random random(seed + 2);
  auto encoder = std::make_unique<MotionEncoder>();
  double both = 0, alone = 0;
  for (int i = 0; i < 50; i++) {
    const MovingSheet sheet(random, 16, 16, SheetMotion::shake, 30, 2);
    const EncodedMotion encoded(*encoder, sheet);
    both += double(encoded.size);
    auto still = std::make_unique<VertEncoder>();
    for (const auto& step : sheet.steps) {
      for (size_t v = 0; v < step.size(); v++) std::copy(step[v].begin(), step[v].end(), still->vertices[v]);
      std::vector<uint8_t> bytes(VertEncoder::maxBytes);
      VertStatistics statistics;
      alone += double(still->encode({packRegion(16, 16, 0, 0), packPatchQuads(16, 16)}, bytes.data(), statistics));
    }
  }
  EXPECT_LE(both, alone);
}

}} // namespace programs::test
