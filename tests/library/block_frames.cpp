// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Alignment of the frames of blocks that the library built. */

#include "kernels/cbvh/paper/block.h"
#include "support/displaced_sheet.h"
#include "support/scene_blocks.h"

#include <cmath>

namespace programs::test { namespace {

using embree::cbvh::Block;

// Cosine between the z axes of frame and world, for the only block of a sheet in the plane z = 0 that displacement
// tilts to z = 2 x.
double uprightness(const char* config) {
  Device device(config);
  DisplaceFunction slope = [](unsigned, float, float, Vec& p) { p[2] = 2 * p[0]; };
  Scene scene(device);
  commit(scene, newSheet(device, 1, 0, 8, slope));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  const std::vector<const Block*> blocks = sceneBlocks(scene);
  EXPECT_EQ(blocks.size(), 1u);
  if (blocks.empty()) return 0;
  const double x = blocks[0]->columns[0][2], y = blocks[0]->columns[1][2], z = blocks[0]->columns[2][2];
  return z / std::sqrt(x * x + y * y + z * z);
}

// Heights of leaves are along the normal of the smooth surface, the direction of displacement. Boxes are aligned to
// the normal of the displaced surface, where they are tightest.
TEST(BlockFrames, FramesOfLeavesFollowSmoothSurface) {
  EXPECT_NEAR(uprightness("subdiv_accel=cbvh.leaf,cbvh_frame_level=0"), 1, 1e-6);
  EXPECT_NEAR(uprightness("subdiv_accel=cbvh.voxel,cbvh_frame_level=0"), 1 / std::sqrt(5), 1e-6);
  EXPECT_NEAR(uprightness("subdiv_accel=cbvh.grid,cbvh_frame_level=0"), 1 / std::sqrt(5), 1e-6);
}

}} // namespace programs::test
