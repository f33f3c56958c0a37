// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Motion for models that are made or read without one: poses of the cage at later time steps. */

#include "surface/model.h"

#include <string>
#include <vector>

namespace cbvh {

struct MotionSettings
{
  std::string name;    // one of motionNames()
  int steps = 2;       // in time, 2 and more
  float degrees = 30;  // from the first step to the last
};

/* "turn", of the whole, about the axis that points upwards; "bend", to one side, and "twist", the more the higher; "walk": what is below the middle
 * swings, to one side of it forwards and to the other backwards. */
const std::vector<std::string>& motionNames();

/* Throws Error for an unknown name or a number of steps that is none. */
void validateMotion(const MotionSettings& settings);

/* Positions of the vertices of a cage in a pose, a named motion's after so many degrees. */
std::vector<Vec3f> posed(const std::string& name, const std::vector<Vec3f>& positions, float degrees);

/* Gives a model poses; likewise. */
void addMotion(Model& model, const MotionSettings& settings);

} // namespace cbvh
