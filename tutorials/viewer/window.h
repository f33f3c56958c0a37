// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The viewer's window: upstream's tutorial application (GLFW, ImGui) around a Viewer. */

#include "options.h"

namespace cbvh {

/* Opens the window and returns when it is closed. Throws Error if there is no display. Throws Canceled. */
void showWindow(const ViewerOptions& options);

} // namespace cbvh
