// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libembree_cbvh in tasks of an application: groups keep no reference to the application's task groups, and each
 * function completes although its task group is canceled. */

#include "small_cube.h"
#include "support/child_process.h"
#include "support/task_groups.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace programs::test { namespace {

const float* const movingSteps[] = {cubeVertices, cubeVertices};

CbvhCage cubeOfSteps(unsigned timeSteps) {
  CbvhCage cage = cube();
  cage.vertices = {8, 12, movingSteps, timeSteps, 0, 1};
  return cage;
}

struct Work {
  CbvhContext context = nullptr;
  CbvhSurface surface = nullptr, loaded = nullptr;
  CbvhGroup group = nullptr;
  const std::string path = testing::TempDir() + "task_groups.cbvh";

  Work() { cbvhNewContext(nullptr, nullptr, nullptr, &context); }
  ~Work() {
    cbvhReleaseGroup(group);
    cbvhReleaseSurface(surface);
    cbvhReleaseSurface(loaded);
    cbvhReleaseContext(context);
    std::remove(path.c_str());
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  bool commitSurface(unsigned timeSteps) {
    const CbvhCage cage = cubeOfSteps(timeSteps);
    return !cbvhNewSurface(context, &surface) && !cbvhSetSurfaceCage(surface, &cage) &&
           !cbvhCommitSurface(surface, nullptr, nullptr);
  }
  bool saveAndLoad() {
    return !cbvhSaveSurface(surface, path.c_str()) && !cbvhLoadSurface(context, path.c_str(), &loaded);
  }
  bool commitGroup() {
    const CbvhSurface surfaces[] = {surface, loaded};
    if (!group && cbvhNewGroup(context, surfaces, 2, &group)) return false;
    return !cbvhCommitGroup(group);
  }
  bool isHit() const {
    CbvhRayHit ray = rayFromAbove();
    return cbvhIntersect1(group, &ray, nullptr);
  }
};

// Exit status of a child process: 0 if everything worked.
int workInTemporaryGroups(unsigned timeSteps) {
  bool worked = true;
  {
    Work work;
    const auto inGroup = [&](auto function) {
      runInTemporaryGroup([&] { worked = worked && function(); });
      cancelOtherGroup();
    };
    inGroup([&] { return work.commitSurface(timeSteps); });
    inGroup([&] { return work.saveAndLoad(); });
    inGroup([&] { return work.commitGroup(); });
    worked = worked && work.isHit();
    inGroup([&] { return !cbvhSetSurfaceMask(work.surface, 3) && work.commitGroup(); });
    worked = worked && work.isHit();
  }
  cancelOtherGroup();
  return worked ? 0 : 1;
}

TEST(CapiTaskGroups, GroupsOutliveTheTaskGroupThatCommitsThem) {
  for (unsigned timeSteps : {1u, 2u})
    EXPECT_EQ(statusOfChild([&] { return workInTemporaryGroups(timeSteps); }), 0) << timeSteps << " time step(s)";
}

TEST(CapiTaskGroups, FunctionsInACanceledTaskGroupComplete) {
  for (unsigned timeSteps : {1u, 2u}) {
    Work work;
    tbb::task_group group;
    group.run([&] {
      group.cancel();
      EXPECT_TRUE(work.commitSurface(timeSteps)) << cbvhGetErrorText();
      EXPECT_TRUE(work.saveAndLoad()) << cbvhGetErrorText();
      EXPECT_TRUE(work.commitGroup()) << cbvhGetErrorText();
      CbvhDicingArguments dicing = CbvhDicingArguments();
      dicing.position[2] = 10;
      dicing.direction[2] = -1;
      dicing.up[1] = 1;
      dicing.pixelSize = 0.01f;
      CbvhSurface cage = nullptr;
      const CbvhCage input = cube();
      float rates[24] = {};
      EXPECT_EQ(cbvhNewSurface(work.context, &cage), CBVH_OK);
      EXPECT_EQ(cbvhSetSurfaceCage(cage, &input), CBVH_OK);
      EXPECT_EQ(cbvhDiceSurface(cage, &dicing, rates), CBVH_OK) << cbvhGetErrorText();
      EXPECT_GT(rates[0], 0);
      cbvhReleaseSurface(cage);
    });
    group.wait();
    EXPECT_TRUE(work.isHit());
  }
}

}} // namespace programs::test
