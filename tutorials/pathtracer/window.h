// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A window that shows a picture during rendering. Builds without GLFW and OpenGL use no_window.cpp instead of
 * window.cpp. */

#include "path_tracer.h"

namespace cbvh {

/* Throws Error if this build or this machine does not support windows. */
void requireWindows();

/* Opens a window of a size and shows the picture after each of `samples` samples. Returns when the window is closed,
 * which may be before the last sample. Throws Error. */
void showWindow(PathTracer& tracer, ImageSize size, unsigned samples);

} // namespace cbvh
