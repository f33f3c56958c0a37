// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds without GLFW and OpenGL use no_window.cpp instead of window.cpp. */

#include "path_tracer.h"

namespace programs {

/* Throws Error if the build or the machine has no windows. */
void requireWindows();

/* Shows the picture after each of `samples` samples. Returns when the window is closed, perhaps before the last
 * sample. Throws Error and Canceled. */
void showWindow(PathTracer& tracer, ImageSize size, unsigned samples);

} // namespace programs
