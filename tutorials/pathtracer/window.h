// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A window that shows a picture while it is made. Builds without GLFW and OpenGL have
 * no_window.cpp in place of window.cpp. */

#include "path_tracer.h"

namespace cbvh {

/* Throws Error if this build or this machine has no windows. */
void requireWindows();

/* Opens a window of a size, has so many samples traced, and shows each as it comes; returns when
 * the window is closed, which may be before. Throws Error, Cancelled. */
void showWindow(PathTracer& tracer, ImageSize size, unsigned samples);

} // namespace cbvh
