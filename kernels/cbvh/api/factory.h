// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include "../stored/report.h"

namespace embree
{
  class Scene;

  /*! True if a value of subdiv_accel requests compression, for example "cbvh", "cbvh.vert" or "cvert";
   *  case-insensitive. */
  bool isCompressedSubdivAccel (const std::string& subdivAccel);

  /*! True if a scene that keeps its accelerators must create new ones: it now has its first compressed surface, or no
   *  longer has any. */
  bool isCompressionOutdated (Scene* scene);

  /*! True if a subdivision surface of the scene has motion blur and is not compressed. */
  bool hasUncompressedMotion (Scene* scene);

  /*! Reports the errors of the last build to the device, once. The committing thread must call it: devices store errors
   *  per thread, and any thread may have run the build. */
  void reportBuildErrors (Scene* scene);

  /*! Returns an accelerator for all static subdivision surfaces of a scene, or null if none of them is compressed.
   *  Selects builder and intersectors for the device's ISA. The caller owns the result. */
  Accel* createCompressedAccel (Scene* scene);

  /*! Returns an accelerator for all moving compressed surfaces of a scene, or null if there are none. The caller owns
   *  the result. */
  Accel* createCompressedMotionAccel (Scene* scene);
}
