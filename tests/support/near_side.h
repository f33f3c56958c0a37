// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The paper's intersection rule for cLEAF, as a reference: a ray that intersects the interval between a leaf's two
 * patches hits the leaf at its near side. Scalar code on the blocks of a scene, as user geometry. */

#include "kernels/cbvh/paper/block.h"
#include <embree3/rtcore.h>

#include <memory>
#include <vector>

namespace programs::test {

class NearSideScene {
public:
  /* compressed: a scene of cLEAF surfaces only. It must outlive this object and be committed exactly once. */
  explicit NearSideScene(RTCScene compressed);
  ~NearSideScene();
  NearSideScene(const NearSideScene&) = delete;
  NearSideScene& operator=(const NearSideScene&) = delete;

  /* Hits have the face as primID and 0 as geomID. */
  RTCScene handle() const { return scene; }

private:
  std::vector<const embree::cbvh::Block*> blocks;
  RTCDevice device;
  RTCScene scene;
};

} // namespace programs::test
