// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The viewer's window: upstream's tutorial application (GLFW, ImGui), showing our
 * pictures. */

#include "options.h"
#include "scene_store.h"

namespace cbvh {

/* Opens the window and returns when it is closed.
 *
 * model: outlives the call. store: of that model. camera: where to start.
 * Throws Error when there is no display, Cancelled. */
void showWindow(const ViewerOptions& options, const Model& model, SceneStore& store, const Camera& camera);

} // namespace cbvh
