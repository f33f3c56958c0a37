// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Upstream's tutorial application (GLFW, ImGui) around a Viewer. */

#include "options.h"

namespace programs {

/* Returns when the window is closed. Throws Error if there is no display, and Canceled after a signal. */
void showWindow(const ViewerOptions& options);

} // namespace programs
