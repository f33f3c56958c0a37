// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays through random displaced sheets, compared with GRID: per representation a million single rays and a million in
 * coherent packets. Also rays that passed in earlier versions. cbvh_bench --check sheets traces more. */

#include "basics/parallel.h"
#include "measure/sheet_crossings.h"
#include "support/scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace programs::test { namespace {

class CrossedSheets : public testing::TestWithParam<RTCCompression> {};

TEST_P(CrossedSheets, NoRayPassesThroughRandomSheets) {
  Device device;
  for (const bool packets : {false, true}) {
    SCOPED_TRACE(packets ? "packets" : "single rays");
    SheetSettings settings;
    settings.packets = packets;
    const programs::SheetCrossings found = crossSheets(device, GetParam(), settings, threadCount(0));
    EXPECT_EQ(found.rays, 1000000u);
    EXPECT_EQ(found.closest, 0u);
    EXPECT_EQ(found.any, 0u);
    for (const std::string& example : found.examples) ADD_FAILURE() << example;
  }
}

struct Known {
  int level, frameLevel;
  double amplitude, sideways;
  Vec org, dir;
};

// All of them entered their first leaf below its patch, after passing over others.
const Known known[] = {
    {5, 0, 3, 0, {0.931433916f, 0.64561826f, 0.0570035204f}, {-0.893551171f, -0.448961407f, -0.790583491f}},
    {5, 0, 1, 0, {-0.721437335f, -0.000574890291f, 0.0191232525f}, {-0.998789847f, 0.049181655f, -0.335739315f}},
    {6, 2, 1, 0, {-0.610621214f, 0.0206685122f, 0.0107404422f}, {-0.999700308f, 0.0244808868f, -0.234315008f}},
    {5, 2, 0.2, 0.3, {0.261337489f, 0.430581003f, 0.00786359143f}, {-0.551255643f, 0.8343364f, -0.0589791946f}},
    {3, 2, 1, 0.3, {0.878058851f, -0.64934516f, 0.132683814f}, {0.14841795f, 0.988924742f, -1.26615787f}}};

TEST_P(CrossedSheets, RaysOfPastDefectsDoNotPass) {
  Device device;
  for (const Known& k : known) {
    DisplacedSheet sheet;
    sheet.level = k.level;
    sheet.rate = float(1 << k.level);
    sheet.frameLevel = k.frameLevel;
    sheet.amplitude = k.amplitude;
    sheet.sideways = k.sideways;
    const RTCScene scene = commitSheet(device, sheet, GetParam());
    const RTCRayHit ray = makeRay(k.org, k.dir);
    EXPECT_TRUE(isHit(intersect(scene, ray))) << sheet.describe();
    EXPECT_TRUE(occluded(scene, ray)) << sheet.describe();
    rtcReleaseScene(scene);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, CrossedSheets,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         [](const auto& info) { return kindName(info.param); });

}} // namespace programs::test
