// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/model.h"

#include <string>
#include <vector>

namespace programs {

struct MotionSettings {
  std::string name;   // one of motionNames()
  int steps = 2;      // 2 to 129
  float degrees = 30; // from the first step to the last
};

/* "turn" rotates about the y axis; "bend" and "twist" increase with y; "walk" swings the parts below the middle
 * of y, forwards on one side and backwards on the other. */
const std::vector<std::string>& motionNames();

/* Throws Error. */
void validateMotion(const MotionSettings& settings);

/* Positions of a cage's vertices after `degrees` of a named motion. */
std::vector<Vec3f> poseVertices(const std::string& name, const std::vector<Vec3f>& positions, float degrees);

/* Throws Error as validateMotion. */
void addMotion(Model& model, const MotionSettings& settings);

} // namespace programs
