// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The paper's rule for leaves of cLEAF, to compare with: a ray that meets the interval
 * between a leaf's two patches hits it, at its near side. Scalar, over the very blocks of
 * a scene, as user geometry. */

#include "kernels/cbvh/framed/block.h"
#include <embree3/rtcore.h>

#include <memory>
#include <vector>

namespace cbvh::test {

class NearSideScene
{
public:
  /* compressed: of nothing but cLEAF surfaces; outlives this, committed once. */
  explicit NearSideScene(RTCScene compressed);
  ~NearSideScene();
  NearSideScene(const NearSideScene&) = delete;
  NearSideScene& operator=(const NearSideScene&) = delete;

  /* Hits have the face as primID, 0 as geomID. */
  RTCScene handle() const { return scene; }

private:
  std::vector<const embree::cbvh::Block*> blocks;
  RTCDevice device;
  RTCScene scene;
};

} // namespace cbvh::test
