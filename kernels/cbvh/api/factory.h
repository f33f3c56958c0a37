// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Creates the acceleration structures for the compressed surfaces of a scene. Embree's Device and Scene call these
 * functions (kernels/upstream/patches). building/builder.cpp fills the structures. */

#include "../embree/scene.h"
#include "../stored/report.h"

namespace embree
{
  class Scene;

  /*! True if a value of the device's key subdiv_accel selects compression, for example "cbvh", "cbvh.vert" or "cvert".
   *  Ignores case. */
  bool isCompressedSubdivAccel (const std::string& subdivAccel);

  /*! True if a scene that keeps its accelerators needs new ones: it got its first compressed surface, or lost its
   *  last. */
  bool isCompressionOutdated (Scene* scene);

  /*! True if an uncompressed subdivision surface of the scene has motion blur. */
  bool hasUncompressedMotion (Scene* scene);

  /*! Reports the errors of the last build to the device, once. Call it on the committing thread: devices store errors
   *  per thread, and any thread may have run the build. */
  void reportBuildErrors (Scene* scene);

  /*! Returns the structure for the static compressed geometries of a scene and for all its other static subdivision
   *  surfaces. Returns null if none is compressed. The caller owns the result, which is not built yet. */
  Accel* createCompressedAccel (Scene* scene);

  /*! Same for the moving compressed geometries only. */
  Accel* createCompressedMotionAccel (Scene* scene);
}
