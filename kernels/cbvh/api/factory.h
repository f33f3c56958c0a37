// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "../embree/scene.h"
#include "../stored/report.h"

namespace embree
{
  class Scene;

  /*! Case-insensitive; for example "cbvh", "cbvh.vert" or "cvert". */
  bool isCompressedSubdivAccel (const std::string& subdivAccel);

  /*! True if a scene that keeps its accelerators needs new ones: it got its first compressed surface, or lost its
   *  last. */
  bool isCompressionOutdated (Scene* scene);

  /*! True if an uncompressed subdivision surface of the scene has motion blur. */
  bool hasUncompressedMotion (Scene* scene);

  /*! Reports the errors of the last build to the device, once. Call it on the committing thread: devices store errors
   *  per thread, and any thread may have run the build. */
  void reportBuildErrors (Scene* scene);

  /*! For all static subdivision surfaces of a scene; null if none is compressed. The caller owns the result. */
  Accel* createCompressedAccel (Scene* scene);

  /*! Same for moving surfaces. */
  Accel* createCompressedMotionAccel (Scene* scene);
}
