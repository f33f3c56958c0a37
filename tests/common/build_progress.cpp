// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/error.h"
#include "basics/progress.h"
#include "building/built_scene.h"
#include "scenes/cube.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace programs::test { namespace {

class BuildProgress : public testing::TestWithParam<RepresentationKind> {
protected:
  ~BuildProgress() override {
    setPhaseListener({});
    clearCancel();
  }

  /* Builds 393216 quads. */
  void build() {
    BuildSettings settings;
    settings.level = 8;
    BuiltScene(makeCube(cubeAmplitude), {GetParam()}, settings);
  }
};

TEST_P(BuildProgress, IsReportedDuringTheBuild) {
  std::vector<double> all, within;
  std::string first;
  setPhaseListener([&](const std::string& name, double fraction) {
    if (first.empty()) first = name;
    if (name == first) (fraction > 0.0 && fraction < 1.0 ? within : all).push_back(fraction);
  });
  build();
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.front(), 0.0);
  EXPECT_EQ(all.back(), 1.0);
  EXPECT_TRUE(std::is_sorted(within.begin(), within.end()));
  EXPECT_GE(within.size(), 4u) << first;
}

TEST_P(BuildProgress, BuildStopsOnRequestAndCanBeRepeated) {
  setPhaseListener([&](const std::string&, double fraction) {
    if (fraction > 0.0) requestCancel();
  });
  EXPECT_THROW(build(), Canceled);
  setPhaseListener({});
  clearCancel();
  EXPECT_NO_THROW(build());
}

INSTANTIATE_TEST_SUITE_P(, BuildProgress,
                         testing::Values(RepresentationKind::Naive, RepresentationKind::NaiveCompact,
                                         RepresentationKind::Grid, RepresentationKind::CVert),
                         [](const auto& info) {
                           std::string name = Representation{info.param}.fileStem();
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}} // namespace programs::test
