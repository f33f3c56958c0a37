// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Creates the acceleration structures for the compressed surfaces of a scene. Called by Embree
 * (kernels/upstream/patches). */

#include "../embree/scene.h"
#include "../blocks/report.h"

namespace embree {
/*! True if a value of the device's key subdiv_accel selects compression, for example "cbvh", "cbvh.vert" or "cvert".
 *  Ignores case. */
bool isCompressedSubdivAccel(const std::string& subdivAccel);

/*! True if a scene needs new accelerators: it got its first compressed static or moving surface, or lost its last but
 *  kept uncompressed ones, or it got its first uncompressed moving subdivision surface next to compressed ones. */
bool isCompressionOutdated(Scene* scene);

/*! True if an enabled, uncompressed subdivision surface of the scene has motion blur. */
bool hasUncompressedMotion(Scene* scene);

/*! Reports the errors of the last build to the device, once. Must be called on the committing thread, because devices
 *  store errors per thread. */
void reportBuildErrors(Scene* scene);

/*! Returns an unbuilt structure for the static compressed geometries and all other static subdivision surfaces of a
 *  scene, or null if none is compressed. The caller owns the result. Clears scene->surfaceIDs, which builds set. */
Accel* createCompressedAccel(Scene* scene);

/*! Same for the moving compressed geometries only, but keeps scene->surfaceIDs. */
Accel* createCompressedMotionAccel(Scene* scene);
} // namespace embree
