// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Motion for static models: poses of the cage at later time steps. */

#include "surface/model.h"

#include <string>
#include <vector>

namespace cbvh {

struct MotionSettings
{
  std::string name;    // one of motionNames()
  int steps = 2;      // time steps, at least 2
  float degrees = 30; // from the first step to the last
};

/* "turn" rotates the whole model about the up axis; "bend" bends it to one side and "twist" twists it, increasing with
 * height; "walk" swings the parts below the middle, forwards on one side and backwards on the other. */
const std::vector<std::string>& motionNames();

/* Throws Error for an unknown name or an invalid number of steps. */
void validateMotion(const MotionSettings& settings);

/* Returns the positions of a cage's vertices after `degrees` of a named motion. */
std::vector<Vec3f> poseVertices(const std::string& name, const std::vector<Vec3f>& positions, float degrees);

/* Sets the poses of a model. Throws Error as validateMotion. */
void addMotion(Model& model, const MotionSettings& settings);

} // namespace cbvh
