// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include "../stored/report.h"

namespace embree
{
  class Scene;

  /*! Whether that value of subdiv_accel is one of ours: "cbvh", "cbvh.vert", "cvert", in any case of letters. */
  bool isNameOfOurs (const std::string& subdivAccel);

  /*! Whether a scene that keeps its accelerators, as dynamic ones do, has to get new ones:
   *  its surfaces were compressed and none asks for it any more, or the other way round. */
  bool isCompressionOutdated (Scene* scene);

  /*! whether a subdivision surface of the scene moves and is not compressed */
  bool hasMotionOfEmbree (Scene* scene);

  /*! Hands the errors of the last build to the device, once. Called by the thread that
   *  commits: a device keeps the error of each thread, and builds run on any. */
  void reportBuildErrors (Scene* scene);

  /*! Accelerator for all subdivision surfaces of a scene without motion blur; null
   *  when none of them is to be compressed. Selects builder and intersectors for the
   *  device's ISA. The caller owns it. */
  Accel* createCompressedAccel (Scene* scene);

  /*! Accelerator for all compressed surfaces of a scene with motion blur; null where there are none. */
  Accel* createCompressedMotionAccel (Scene* scene);
}
