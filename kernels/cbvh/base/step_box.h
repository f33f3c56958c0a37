// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace embree::cbvh {
/*! Bounds of a moving block at a time step. Empty if no vertex is finite then. */
struct StepBox {
  float lower[3], upper[3];
  bool isEmpty() const { return !(lower[0] <= upper[0]); }
};
} // namespace embree::cbvh
