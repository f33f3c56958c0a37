// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "window.h"
#include "basics/error.h"

namespace programs {

void requireWindows() {
  throw Error("--window: this build has no windows, which need GLFW and OpenGL: expected --output");
}

void showWindow(PathTracer&, ImageSize, unsigned) { requireWindows(); }

} // namespace programs
